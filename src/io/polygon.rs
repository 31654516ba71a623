//! Triangles of a plane or nearly plane polygon.

use crate::geometry::vector::{Vec3, add, cross, sub};
use crate::notice::{Notice, number_of};

/// More corners than this are refused: clipping is quadratic, and no exporter writes such faces on purpose.
pub(super) const MOST_CORNERS: usize = 4096;

/// The triangles of a polygon, as positions in its list of corners, or `None` if it is not simple.
///
/// Ears are clipped one after the other (Meisters 1975) in the projection along the larger component of the
/// polygon's vector area; every corner is used, those on a straight side in facets without area, so that
/// neighbours stay joined. A fan would put facets outside a concave polygon.
///
/// # Cost
/// O(corners²), up to O(corners³) for spirals.
pub(super) fn triangulate(corners: &[Vec3]) -> Option<Vec<[usize; 3]>> {
    match corners.len() {
        0..=2 => return Some(Vec::new()),
        3 => return Some(vec![[0, 1, 2]]),
        _ => {}
    }
    let points = projected(corners)?;
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(left.len() - 2);
    while left.len() > 3 {
        let n = left.len();
        let triple = |i: usize| Some([*left.get((i + n - 1) % n)?, *left.get(i)?, *left.get((i + 1) % n)?]);
        let ear = (0..n).find(|&i| triple(i).is_some_and(|t| is_ear(t, &left, &points)));
        let straight = || (0..n).find(|&i| triple(i).is_some_and(|t| turn(t, &points) == Some(0.0)));
        let at = ear.or_else(straight)?;
        triangles.push(triple(at)?);
        left.remove(at);
    }
    triangles.push([*left.first()?, *left.get(1)?, *left.get(2)?]);
    let last = triangles.last()?;
    if turn(*last, &points)? < 0.0 { None } else { Some(triangles) }
}

/// The facets of polygons that follow each other in a list of corners, `counts` corners each.
///
/// Polygons that cross themselves are fanned and noticed.
pub(super) fn facets(corners: &[Vec3], counts: &[usize], notices: &mut Vec<Notice>) -> Vec<[Vec3; 3]> {
    let mut facets = Vec::with_capacity(corners.len() / 3);
    let (mut rest, mut fanned, mut at_mm) = (corners, 0u64, None);
    for &count in counts {
        let Some((own, others)) = rest.split_at_checked(count) else { break };
        rest = others;
        let triangles = triangulate(own).unwrap_or_else(|| {
            fanned += 1;
            at_mm = at_mm.or(own.first().copied());
            fan(count).collect()
        });
        let corner = |i: usize| own.get(i).copied().unwrap_or_default();
        facets.extend(triangles.into_iter().map(|t| t.map(corner)));
    }
    if fanned > 0 {
        let notice = Notice::new(
            "polygon-fan",
            number_of(
                fanned,
                [
                    "polygon that crosses itself or has no area was split as a fan",
                    "polygons that cross themselves or have no area were split as fans",
                ],
            ),
        );
        notices.push(at_mm.into_iter().fold(notice.counted(fanned), Notice::at));
    }
    facets
}

/// The fan from the first corner: what is left for a polygon that crosses itself.
fn fan(corners: usize) -> impl Iterator<Item = [usize; 3]> {
    (1..corners.saturating_sub(1)).map(|i| [0, i, i + 1])
}

/// The corners in the coordinate plane the polygon is seen best in, counter-clockwise; `None` without area.
fn projected(corners: &[Vec3]) -> Option<Vec<[f64; 2]>> {
    let first = corners.first().copied().unwrap_or_default();
    let rim = corners.iter().zip(corners.iter().cycle().skip(1));
    let area = rim.fold([0.0; 3], |sum, (&a, &b)| add(sum, cross(sub(a, first), sub(b, first))));
    let [x, y, z] = area.map(f64::abs);
    let (seen, flat): (f64, fn(Vec3) -> [f64; 2]) = if x >= y && x >= z {
        (area[0], |[_, y, z]| [y, z])
    } else if y >= z {
        (area[1], |[x, _, z]| [z, x])
    } else {
        (area[2], |[x, y, _]| [x, y])
    };
    let wound = |[u, v]: [f64; 2]| if seen < 0.0 { [v, u] } else { [u, v] };
    (seen != 0.0).then(|| corners.iter().map(|p| wound(flat(sub(*p, first)))).collect())
}

/// Twice the signed area of three corners, rounded to zero where rounding could have made its sign.
fn turn([a, b, c]: [usize; 3], points: &[[f64; 2]]) -> Option<f64> {
    let (a, b, c) = (*points.get(a)?, *points.get(b)?, *points.get(c)?);
    let (left, right) = ((b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0]));
    let area = left - right;
    Some(if area.abs() <= 4.0 * f64::EPSILON * (left.abs() + right.abs()) { 0.0 } else { area })
}

/// Whether three neighbouring corners turn left and hold no other corner.
fn is_ear([a, b, c]: [usize; 3], left: &[usize], points: &[[f64; 2]]) -> bool {
    let convex = turn([a, b, c], points).is_some_and(|t| t > 0.0);
    let own = [a, b, c].map(|i| points.get(i));
    let inside = |p: usize| {
        let sides = [turn([a, b, p], points), turn([b, c, p], points), turn([c, a, p], points)];
        sides.iter().all(|s| s.is_some_and(|t| t >= 0.0))
    };
    convex && left.iter().all(|&p| own.contains(&points.get(p)) || !inside(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[Vec3], t: &[usize; 3]) -> Vec3 {
        let [a, b, c] = t.map(|i| corners[i]);
        cross(sub(b, a), sub(c, a)).map(|x| 0.5 * x)
    }

    fn areas(corners: &[Vec3]) -> Vec<f64> {
        triangulate(corners).unwrap().iter().map(|t| area(corners, t)[2]).collect()
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        // An L, a dart whose fan from its first corner would leave it, and a comb.
        let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let dart = [[0.0, 0.0], [4.0, -2.0], [1.0, 0.0], [4.0, 2.0]];
        let comb = [[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [4.0, 1.0], [3.0, 3.0], [2.0, 1.0], [1.0, 3.0]];
        for (corners, whole) in [(&l[..], 5.0), (&dart[..], 2.0), (&comb[..], 9.5)] {
            for shift in 0..corners.len() {
                let mut turned: Vec<Vec3> = corners.iter().map(|p| [p[0], p[1], 7.0]).collect();
                turned.rotate_left(shift);
                let parts = areas(&turned);
                assert_eq!(parts.len(), corners.len() - 2);
                assert!(parts.iter().all(|&a| a >= 0.0), "{parts:?}");
                let own: f64 = {
                    let rim = corners.iter().zip(corners.iter().cycle().skip(1));
                    0.5 * rim.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
                };
                assert_eq!((parts.iter().sum::<f64>(), own), (own, own), "{whole}");
            }
        }
    }

    #[test]
    fn clockwise_and_straight_corners_are_kept() {
        let square = [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 2.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0]];
        let triangles = triangulate(&square).unwrap();
        let mut used: Vec<usize> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        assert_eq!(used, [0, 1, 2, 3, 4]);
        assert_eq!(triangles.iter().map(|t| area(&square, t)[2]).sum::<f64>(), -4.0);
    }

    #[test]
    fn a_bow_tie_is_not_simple() {
        let bow = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        assert_eq!(triangulate(&bow), None);
        assert_eq!(triangulate(&[[0.0; 3], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]), None);
        assert_eq!(fan(4).count(), 2);
    }

    #[test]
    fn the_largest_polygons_take_bounded_time() {
        let start = std::time::Instant::now();
        let n = MOST_CORNERS / 2;
        let spiral = |i: usize, width: f64| {
            let t = i as f64 * 0.05;
            [(t + width) * t.cos(), (t + width) * t.sin(), 0.0]
        };
        let spiral: Vec<Vec3> =
            (20..n + 20).map(|i| spiral(i, 0.0)).chain((20..n + 20).rev().map(|i| spiral(i, 2.0))).collect();
        let star = |i: usize| {
            let (t, r) = (i as f64 * std::f64::consts::PI / n as f64, if i.is_multiple_of(2) { 1.0 } else { 0.1 });
            [r * t.cos(), r * t.sin(), 0.0]
        };
        let star: Vec<Vec3> = (0..2 * n).map(star).collect();
        for corners in [spiral, star] {
            assert_eq!(triangulate(&corners).map(|t| t.len()), Some(2 * n - 2));
            println!("{:?}", start.elapsed());
        }
        // A guard against cubic work, not a benchmark.
        assert!(start.elapsed().as_secs() < 30, "{:?}", start.elapsed());
    }
}
