//! Features that stand tall on little: height over least width.

use super::outlines::outlines;
use super::pieces::{Piece, Rising, pieces};
use super::section::Point;
use crate::geometry::vector::Vec3;
use crate::geometry::{Hull, MeshDistance, TriangleMesh};
use rayon::prelude::*;

/// A piece of the part above some height, and the section it stands on.
#[derive(Debug, Clone, PartialEq)]
pub struct TallFeature {
    /// Height of its top above the section, mm.
    pub height_mm: f64,
    /// Least and greatest width of the section's convex hull, mm.
    pub width_mm: (f64, f64),
    /// No section of the piece has a greater slenderness.
    pub at_most: f64,
    /// Middle of the section.
    pub foot: Vec3,
    /// Box of section and top.
    pub extent: (Vec3, Vec3),
}

impl TallFeature {
    /// Height over least width.
    pub fn slenderness(&self) -> f64 {
        self.height_mm / self.width_mm.0
    }
}

/// Which sections count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Counting {
    /// Pieces that are no more slender are not told.
    pub least: f64,
    /// Sections longer than this many times their least width are walls, if one of their outlines is by itself.
    pub longest_ratio: f64,
    /// Height of a layer: a piece has at least one below its top, and none is looked at below the middle of its lowest.
    pub layer_mm: f64,
    /// Heights nearer than this are one, and no section is narrower.
    pub tie_mm: f64,
}

impl Counting {
    /// Whether a section is longer than that, by its least width and its greatest, the diagonal: that of a rectangle as long is √(1 + ratio²) widths.
    /// What is as long to within the coordinates is not longer.
    fn is_longer(&self, width: f64, diagonal: f64) -> bool {
        let times = 1f64.hypot(self.longest_ratio);
        diagonal > times * width * (1.0 + ROUNDING) + MOVED * (1.0 + times) * self.tie_mm
    }
}

/// How far the bound may lie above what was measured, as a share.
const GAP: f64 = 0.002;
/// Stretches of height that are looked at for one piece.
const STRETCHES: usize = 1 << 14;
/// Stretches with long sections that are divided for one piece until an outline is seen to be a wall all through.
const WALLS: usize = 1 << 12;
/// A length changes by no more than so many times what its ends move along each axis: 2√3.
const MOVED: f64 = 3.4642;
/// What is lost to rounding where two lengths are compared, as a share.
const ROUNDING: f64 = 1e-9;

/// The pieces of the solid that are more slender than `counting.least`, the most slender first.
///
/// A piece is what hangs together above a height about its top, followed down until it joins another with a top as high or higher. Let its
/// top be at height t, and let w(z) be the least width of the convex hull of its section at z. Its slenderness is the supremum of
/// (t − z)/w(z) over the heights z from where it joins another piece to one layer below t, at which the section is no wall. A wall is longer than so many times
/// its width: its hull, and that of one of its outlines, since two legs beside each other are none. A piece that joins none is judged
/// from its lowest layer on, which is as its section at half its height is and begins at the piece's lowest point. If it widens from
/// there without getting as tall as it is wide, it stands on a point, an edge or a round side and is not slender for that: then it is judged from where it widens no
/// more, looked for a tenth farther up each time, and all below counts as that section is.
///
/// Both sides are certified. What is measured is a section of the mesh. For the bound, heights are halved at those of vertices until
/// no stretch can hold more: the edges that cross a whole stretch move linearly in it, and the hull of their points lies in that of the
/// section. The width of a hull changes by no more than its points move apart, so it is bounded from both ends of the stretch. The
/// same holds in perspective from the height of the top, where points move linearly in 1/(t − z) and the width of the picture is the
/// inverse of the slenderness; this is exact for cones as the first is for prisms. [`TallFeature::at_most`] is above the value by two thousandths,
/// or by more where 16,384 of them did not do. Where 4,096 do not show that one outline is a wall all through, a long section counts as one.
///
/// `bounds` says which facets bound the solid, and `tree` holds these. It holds for a closed surface that does not cross itself.
///
/// # Cost
/// O(E log E) for E edges for the pieces; for each that is high enough O(E log E) more, and some tens of hulls.
pub fn tall_features(
    mesh: &TriangleMesh,
    bounds: impl Fn(usize) -> bool,
    tree: &MeshDistance,
    counting: &Counting,
) -> Vec<TallFeature> {
    let all = pieces(mesh, bounds, tree);
    let mut found: Vec<TallFeature> = all.par_iter().filter_map(|piece| most_slender(piece, counting)).collect();
    found.sort_by(|a, b| b.slenderness().total_cmp(&a.slenderness()));
    found
}

/// A section that was measured.
#[derive(Debug, Clone)]
struct Measured {
    slenderness: f64,
    /// Where what it carries begins.
    z: f64,
    hull: Hull,
}

/// What is known of a piece.
struct Search<'a> {
    piece: &'a Piece,
    counting: &'a Counting,
    best: Option<Measured>,
    /// The greatest bound of a stretch that was not looked at further.
    at_most: f64,
    left: usize,
    /// Stretches that may still be divided because no outline is seen to be a wall.
    walls_left: usize,
}

/// The most slender section of a piece; `None` if none is more slender than what is told.
fn most_slender(piece: &Piece, counting: &Counting) -> Option<TallFeature> {
    let top = piece.top[2];
    let low = if piece.joins { piece.bottom } else { foot(piece, counting) };
    let mut search = Search { piece, counting, best: None, at_most: 0.0, left: STRETCHES, walls_left: WALLS };
    if !piece.joins && low < top - counting.layer_mm {
        let lowest: Vec<&Rising> = piece.edges.iter().filter(|e| e.heights[0] <= low && e.heights[1] > low).collect();
        search.measure(&Hull::of(lowest.iter().map(|e| e.at(low))), piece.bottom, (&lowest, low));
    }
    // Lower stretches first: what is told is mostly there.
    let mut open = vec![([low, top - counting.layer_mm], (0..piece.edges.len() as u32).collect::<Vec<u32>>())];
    while let Some((heights, edges)) = open.pop() {
        if let Some(z) = search.look(heights, &edges) {
            for part in [[z, heights[1]], [heights[0], z]] {
                let within = |e: &&u32| {
                    let [low, high] = piece.edges[**e as usize].heights;
                    low < part[1] && high > part[0]
                };
                open.push((part, edges.iter().filter(within).copied().collect()));
            }
        }
    }
    let (at_most, best) = (search.at_most, search.best?);
    // Nearer to the least that is told than the gap it was not looked for.
    if best.slenderness <= counting.least && at_most <= counting.least * (1.0 + GAP) {
        return None;
    }
    let (lo, hi) = plan(best.hull.corners().iter().copied())?;
    let [x, y] = middle(&best.hull);
    let (lo, hi) = plan([lo, hi, [piece.top[0], piece.top[1]]])?;
    Some(TallFeature {
        height_mm: top - best.z,
        width_mm: best.hull.widths(),
        at_most: at_most.max(best.slenderness),
        foot: [x, y, best.z],
        extent: ([lo[0], lo[1], best.z], [hi[0], hi[1], top]),
    })
}

/// From which height on a piece is judged that joins no other.
fn foot(piece: &Piece, counting: &Counting) -> f64 {
    let width = |up: f64| {
        let z = piece.bottom + up;
        let crossing = piece.edges.iter().filter(|e| e.heights[0] <= z && e.heights[1] > z);
        Hull::of(crossing.map(|e| e.at(z))).widths().0
    };
    let first = 0.5 * counting.layer_mm;
    let (mut up, mut wide) = (first, width(first));
    while wide > up {
        let (next, tie) = (1.1 * up, 2.0 * MOVED * counting.tie_mm);
        let wider = width(next);
        if wider <= wide + tie {
            return piece.bottom + up;
        }
        (up, wide) = (next, wider);
    }
    piece.bottom + first
}

/// Least and greatest coordinates.
fn plan(points: impl IntoIterator<Item = Point>) -> Option<(Point, Point)> {
    let mut points = points.into_iter();
    let first = points.next()?;
    let wider = |(lo, hi): (Point, Point), p: Point| ([0, 1].map(|a| lo[a].min(p[a])), [0, 1].map(|a| hi[a].max(p[a])));
    Some(points.fold((first, first), wider))
}

/// The middle of a hull's box.
fn middle(hull: &Hull) -> Point {
    plan(hull.corners().iter().copied()).map_or([0.0; 2], |(lo, hi)| [0, 1].map(|a| 0.5 * (lo[a] + hi[a])))
}

impl Search<'_> {
    /// Looks at a stretch of heights with the edges that lie in it; returns where to divide it, if it may hold more than is known.
    fn look(&mut self, [low, high]: [f64; 2], edges: &[u32]) -> Option<f64> {
        if high - low <= self.counting.tie_mm || edges.is_empty() {
            return None;
        }
        let all = || edges.iter().map(|&e| &self.piece.edges[e as usize]);
        let through: Vec<&Rising> = all().filter(|e| e.heights[0] <= low && e.heights[1] >= high).collect();
        let is_plain = through.len() == edges.len();
        let top = self.piece.top[2];
        let ends = Ends::of(&through, [low, high], top);
        if is_plain {
            // All edges cross the stretch, so these are its sections.
            ends.hulls.iter().zip([low, high]).for_each(|(hull, z)| self.measure(hull, z, (&through, z)));
        }
        let bound = ends.slenderness([low, high], top, self.counting.tie_mm);
        let known = self.best.as_ref().map_or(0.0, |b| b.slenderness).max(self.counting.least);
        if bound <= known * (1.0 + GAP) {
            self.at_most = self.at_most.max(bound);
            return None;
        }
        let is_longer = |width: f64| self.counting.is_longer(width, ends.longest());
        // The hull of all that lies in the stretch holds each section, and is no narrower than what crosses it.
        let whole = || {
            Hull::of(all().flat_map(|e| {
                let [from, to] = e.heights;
                [e.at(low.max(from)), e.at(high.min(to))]
            }))
        };
        if is_longer(ends.widths[0].0.max(ends.widths[1].0)) {
            let width = whole().widths().0;
            let is_wall =
                |outline: &Vec<&Rising>| self.counting.is_longer(width, Ends::of(outline, [low, high], top).longest());
            if is_longer(width) && (self.walls_left == 0 || outlines(&through).iter().any(is_wall)) {
                return None;
            }
            self.walls_left = self.walls_left.saturating_sub(usize::from(is_longer(width)));
        }
        if self.left == 0 {
            self.at_most = self.at_most.max(bound);
            return None;
        }
        self.left -= 1;
        let mut between: Vec<f64> = all().flat_map(|e| e.heights).filter(|&z| z > low && z < high).collect();
        if between.is_empty() {
            return Some(0.5 * (low + high));
        }
        let middle = between.len() / 2;
        Some(*between.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    /// Measures a section that carries the piece above a height: the edges that cross it, and where.
    fn measure(&mut self, hull: &Hull, z: f64, (edges, at): (&[&Rising], f64)) {
        let widths = hull.widths();
        let is_longer = |hull: &Hull| {
            let (width, diagonal) = hull.widths();
            self.counting.is_longer(width, diagonal)
        };
        let is_wall =
            || is_longer(hull) && outlines(edges).iter().any(|o| is_longer(&Hull::of(o.iter().map(|e| e.at(at)))));
        let slenderness = (self.piece.top[2] - z) / widths.0;
        let known = self.best.as_ref().map_or(0.0, |b| b.slenderness);
        if widths.0 > self.counting.tie_mm && slenderness > known && !is_wall() {
            self.best = Some(Measured { slenderness, z, hull: hull.clone() });
        }
    }
}

/// The hulls of points that move linearly, at both ends of a stretch.
struct Ends {
    hulls: [Hull; 2],
    /// The widths of what is left of each without corners that rounding made.
    widths: [(f64, f64); 2],
    /// How far the corners of each hull move apart from one end to the other.
    apart: [f64; 2],
    /// The same in perspective.
    apart_in_perspective: [f64; 2],
}

impl Ends {
    fn of(edges: &[&Rising], heights: [f64; 2], top: f64) -> Self {
        let points: Vec<[Point; 2]> = edges.iter().map(|e| heights.map(|z| e.at(z))).collect();
        let hulls = [0, 1].map(|end| Hull::of(points.iter().map(|p| p[end])));
        let sharp = [0, 1].map(|end| hulls[end].sharpened());
        let in_order = |a: &Point, b: &Point| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]));
        let sorted = [0, 1].map(|end| {
            let mut corners = sharp[end].corners().to_vec();
            corners.sort_by(in_order);
            corners
        });
        let middles = [0, 1].map(|end| middle(&hulls[end]));
        let nearer = heights.map(|z| 1.0 / (top - z));
        let moved = |end: usize, [from, to]: [f64; 2]| {
            let corners = &sorted[end];
            let all = points.iter().filter(|p| corners.binary_search_by(|c| in_order(c, &p[end])).is_ok());
            let way = |[p, q]: [Point; 2]| [0, 1].map(|a| q[a] * to - p[a] * from);
            let whole = way(middles);
            let beside = |p: &[Point; 2]| (way(*p)[0] - whole[0]).hypot(way(*p)[1] - whole[1]);
            let mut own: Vec<&[Point; 2]> = all.collect();
            // Of edges that meet in a corner the one that goes most as the whole does.
            own.sort_by(|a, b| in_order(&a[end], &b[end]).then_with(|| beside(a).total_cmp(&beside(b))));
            own.dedup_by_key(|p| p[end]);
            let spread = plan(own.into_iter().map(|p| way(*p)));
            spread.map_or(0.0, |(lo, hi)| (hi[0] - lo[0]).hypot(hi[1] - lo[1]))
        };
        let apart = [0, 1].map(|end| moved(end, [1.0; 2]));
        let apart_in_perspective = [0, 1].map(|end| moved(end, nearer));
        let widths = [0, 1].map(|end| sharp[end].widths());
        Ends { hulls, widths, apart, apart_in_perspective }
    }

    /// No section of the stretch is less long.
    fn longest(&self) -> f64 {
        (self.widths[0].1 - self.apart[0]).max(self.widths[1].1 - self.apart[1])
    }

    /// A bound of the slenderness of all sections of the stretch; a width below `tie` counts as that.
    fn slenderness(&self, heights: [f64; 2], top: f64, tie: f64) -> f64 {
        let [below, above] = heights.map(|z| top - z);
        let widths = self.widths.map(|w| w.0);
        let (share, width) = narrowest(widths, self.apart);
        // Where both bounds of the width meet, the bound of the slenderness has its one turn.
        let at_turn = if width > tie { (below + share * (above - below)) / width } else { below / tie };
        let at_ends = [
            below / (widths[0].max(widths[1] - self.apart[1])).max(tie),
            above / (widths[1].max(widths[0] - self.apart[0])).max(tie),
        ];
        let plain = at_turn.max(at_ends[0]).max(at_ends[1]);
        let pictured = [widths[0] / below, widths[1] / above];
        let (_, picture) = narrowest(pictured, self.apart_in_perspective);
        plain.min(1.0 / picture.max(tie / below))
    }
}

/// Where a width that is at least `widths[0] − s·apart[0]` and at least `widths[1] − (1 − s)·apart[1]`, for s from 0 to 1, may be
/// least, and what it is at least there.
fn narrowest(widths: [f64; 2], apart: [f64; 2]) -> (f64, f64) {
    let both = apart[0] + apart[1];
    let share = if both > 0.0 { ((widths[0] - widths[1] + apart[1]) / both).clamp(0.0, 1.0) } else { 0.0 };
    (share, (widths[0] - share * apart[0]).max(widths[1] - (1.0 - share) * apart[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::geometry::union::united;
    use crate::random::Lcg;

    const WALL: f64 = 4.0;

    fn found(part: &TriangleMesh, least: f64, layer_mm: f64) -> Vec<TallFeature> {
        let counting = Counting { least, longest_ratio: WALL, layer_mm, tie_mm: 1e-6 };
        tall_features(part, |_| true, &MeshDistance::new(part), &counting)
    }

    /// A surface of revolution about z through these radii and heights from the bottom up; a radius of zero is a point.
    fn turned(profile: &[[f64; 2]], sides: u32) -> TriangleMesh {
        let at = |[r, z]: [f64; 2], k: u32| {
            let (s, c) = (std::f64::consts::TAU * f64::from(k % sides) / f64::from(sides)).sin_cos();
            [r * c, r * s, z]
        };
        let middle = |z: f64| [0.0, 0.0, z];
        let (first, last) = (profile[0], profile[profile.len() - 1]);
        let mut facets = Vec::new();
        for k in 0..sides {
            if first[0] > 0.0 {
                facets.push([middle(first[1]), at(first, k + 1), at(first, k)]);
            }
            if last[0] > 0.0 {
                facets.push([middle(last[1]), at(last, k), at(last, k + 1)]);
            }
            for w in profile.windows(2) {
                let [a, b, c, d] = [at(w[0], k), at(w[0], k + 1), at(w[1], k + 1), at(w[1], k)];
                facets.extend([[a, b, c], [a, c, d]].into_iter().filter(|[p, q, r]| p != q && q != r && p != r));
            }
        }
        TriangleMesh::weld(facets)
    }

    fn moved(mesh: &TriangleMesh, random: &mut Lcg) -> TriangleMesh {
        let (s, c) = (std::f64::consts::TAU * random.unit()).sin_cos();
        mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], random.point(-3.0, 3.0))
    }

    /// The most slender section at many heights, of a part that is one piece at each: nothing but sections and hulls.
    fn at_many_heights(part: &TriangleMesh, layer: f64) -> f64 {
        let (lo, hi) = part.bounds().unwrap();
        let (low, high) = (lo[2] + 0.5 * layer, hi[2] - layer);
        let mut heights: Vec<f64> = (0..=800).map(|n| low + (high - low) * f64::from(n) / 800.0).collect();
        // Right above and below each corner, where the section may jump.
        let corners = part.vertices.iter().flat_map(|v| [v[2] - 1e-7, v[2] + 1e-7]);
        heights.extend(corners.filter(|z| (low..=high).contains(z)));
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|a, b| *a - *b < 1e-9);
        let slender = |z: f64| {
            let (least, greatest) = Hull::of(super::super::section_points(part, z)).widths();
            if least > 1e-6 && greatest <= 1f64.hypot(WALL) * least { (hi[2] - z) / least } else { 0.0 }
        };
        let first = slender(low) * (hi[2] - lo[2]) / (hi[2] - low);
        heights.into_par_iter().map(slender).reduce(|| first, f64::max)
    }

    fn check_against_many_heights(part: &TriangleMesh, layer: f64, random: &mut Lcg) -> f64 {
        let truth = at_many_heights(part, layer);
        let mut first = None;
        for _ in 0..3 {
            let lies = moved(part, random);
            let all = found(&lies, 0.9 * truth, layer);
            let [one] = &all[..] else { panic!("{truth} {all:?}") };
            let (low, high) = (one.slenderness(), one.at_most);
            assert!(truth <= high * (1.0 + 1e-9) && high <= low * (1.0 + GAP) + 1e-9, "{truth} {one:?}");
            // What was measured is there, right above or below.
            let z = one.foot[2].max(lies.bounds().unwrap().0[2] + 0.5 * layer);
            let there = [-1e-7, 1e-7].map(|d| Hull::of(super::super::section_points(&lies, z + d)).widths());
            assert!(there.iter().any(|w| (w.0 - one.width_mm.0).abs() < 1e-5), "{there:?} {one:?}");
            assert!(one.width_mm.1 <= 1f64.hypot(WALL) * one.width_mm.0 * (1.0 + 2.0 * ROUNDING) + 2e-5, "{one:?}");
            let before = *first.get_or_insert(low);
            assert!((low - before).abs() <= GAP * before, "{low} {before}");
        }
        truth
    }

    #[test]
    fn of_prongs_that_are_equally_high_each_is_told_whichever_way_they_stand() {
        let told = |x: f64| {
            let boxes = [
                [[-1.0, -1.0, 0.0], [1.0, 1.0, 10.0]],
                [[-10.0, -2.0, 10.0], [10.0, 2.0, 12.0]],
                [[-9.0 * x - 1.0, -1.0, 12.0], [-9.0 * x + 1.0, 1.0, 32.0]],
                [[7.0 * x - 2.0, -2.0, 12.0], [7.0 * x + 2.0, 2.0, 32.0]],
            ];
            let whole = boxes.map(|[lo, hi]| cuboid(lo, hi)).into_iter().reduce(|a, b| a.joined(&b)).unwrap();
            found(&united(&whole, 1e-6).unwrap(), 4.0, 0.2)
        };
        for x in [1.0, -1.0] {
            let slenderness: Vec<f64> = told(x).iter().map(TallFeature::slenderness).collect();
            // The stem, the thin prong and the thick one.
            let want = [16.0, 10.0, 5.0];
            assert!(
                slenderness.len() == 3 && (0..3).all(|n| (slenderness[n] - want[n]).abs() < 1e-6),
                "{slenderness:?}"
            );
        }
    }

    #[test]
    fn pillars_on_a_plate_are_found_each_and_a_block_is_not() {
        // Each grows out of the plate through a hole in its upper face.
        let plate = cuboid([0.0; 3], [30.0, 20.0, 2.0]);
        let part = plate
            .joined(&cuboid([3.0, 3.0, 2.0], [5.0, 5.0, 32.0]))
            .joined(&cuboid([20.0, 10.0, 2.0], [23.0, 12.0, 22.0]))
            .joined(&cuboid([10.0, 10.0, 2.0], [16.0, 16.0, 12.0]));
        let part = united(&part, 2e-6).unwrap();
        let mut random = Lcg(3);
        for _ in 0..6 {
            let all = found(&moved(&part, &mut random), 8.0, 0.2);
            assert_eq!(all.len(), 2, "{all:?}");
            for (f, (height, width)) in all.iter().zip([(30.0, 2.0), (20.0, 2.0)]) {
                assert!((f.width_mm.0 - width).abs() < 1e-9 && (f.height_mm - height).abs() < 1e-9, "{f:?}");
                assert!((f.at_most - height / width).abs() < 1e-6, "{f:?}");
            }
        }
        assert!(found(&cuboid([0.0; 3], [20.0; 3]), 8.0, 0.2).is_empty());
    }

    #[test]
    fn values_are_those_of_many_heights_however_the_part_lies() {
        let mut random = Lcg(17);
        let shapes: [(&str, TriangleMesh, f64); 6] = [
            ("cone", turned(&[[2.0, 0.0], [0.0, 40.0]], 48), 40.0 / 4.0),
            ("frustum", turned(&[[1.0, 0.0], [4.0, 40.0]], 48), 40.0 / (2.0 * (1.0 + 0.3 / 40.0))),
            ("waist", turned(&[[3.0, 0.0], [1.0, 15.0], [3.0, 40.0]], 48), 25.0 / 2.0),
            (
                "dumbbell",
                turned(&[[4.0, 0.0], [4.0, 5.0], [1.0, 5.01], [1.0, 30.0], [4.0, 30.01], [4.0, 36.0]], 48),
                30.99 / 2.0,
            ),
            ("bulge", turned(&[[1.5, 0.0], [2.0, 10.0], [2.0, 20.0], [1.0, 30.0]], 48), 30.0 / 3.005),
            ("foot", turned(&[[8.0, 0.0], [8.0, 2.0], [3.0, 4.0], [1.5, 8.0], [1.0, 40.0]], 48), 32.0 / 3.0),
        ];
        for (name, part, closed) in shapes {
            let truth = check_against_many_heights(&part, 0.2, &mut random);
            assert!((truth / closed - 1.0).abs() < 0.03, "{name}: {truth} {closed}");
        }
    }

    /// Radii and heights of a quarter of a circle from its lowest point on.
    fn round_foot(radius: f64) -> Vec<[f64; 2]> {
        let rings = (0..=24).map(|k| (std::f64::consts::FRAC_PI_2 * f64::from(k) / 24.0).sin_cos());
        rings.map(|(s, c)| [radius * s, radius * (1.0 - c)]).collect()
    }

    #[test]
    fn what_stands_on_a_point_or_a_round_side_is_not_slender_for_that() {
        let mut random = Lcg(29);
        let over = |radius: f64| round_foot(radius).into_iter().rev().skip(1).map(move |[r, z]| [r, 2.0 * radius - z]);
        let ball: Vec<[f64; 2]> = round_foot(12.0).into_iter().chain(over(12.0)).collect();
        let (a, b) = (0.5f64.sqrt(), (1.0f64 / 3.0).sqrt());
        let on_a_corner = [[a, -a, 0.0], [b * a, b * a, -2.0 * b * a], [b, b, b]];
        let cube = cuboid([0.0; 3], [20.0; 3]).transformed(on_a_corner, [0.0; 3]);
        // At half a layer above its point the ball is an eighth as wide as it is tall, the cube a thousandth.
        for part in [turned(&ball, 60), cube] {
            let all = found(&moved(&part, &mut random), 1.5, 0.2);
            assert!(all.is_empty(), "{all:?}");
        }
        // A pin on its round end is as slender as one on a flat one, to what it widens in the last tenth of its way.
        let pin: Vec<[f64; 2]> = round_foot(1.0).into_iter().chain([[1.0, 30.0]]).collect();
        let [one] = &found(&moved(&turned(&pin, 48), &mut random), 8.0, 0.2)[..] else { panic!() };
        assert!((one.slenderness() / 15.0 - 1.0).abs() < 0.01 && one.at_most <= 15.0 * 1.01, "{one:?}");
        // On a point that is taller than wide it is a pillar from there on.
        let [needle] = &found(&turned(&[[0.0, 0.0], [2.0, 40.0]], 48), 8.0, 0.2)[..] else { panic!() };
        assert!(needle.slenderness() > 1000.0, "{needle:?}");
    }

    #[test]
    fn a_tilted_pin_is_measured_across_its_level_sections() {
        let mut random = Lcg(23);
        let upright = cuboid([0.0; 3], [2.0, 2.0, 30.0]);
        let sheared = upright.transformed([[1.0, 0.0, 0.4], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);
        for _ in 0..4 {
            let [one] = &found(&moved(&sheared, &mut random), 8.0, 0.2)[..] else { panic!() };
            assert!((one.slenderness() - 15.0).abs() < 1e-6 && one.at_most < 15.0 * (1.0 + GAP), "{one:?}");
        }
        let (s, c) = 0.2f64.sin_cos();
        let tilted = upright.transformed([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]], [0.0; 3]);
        // On its edge it stands as on its section above that.
        let [one] = &found(&moved(&tilted, &mut random), 8.0, 0.2)[..] else { panic!() };
        assert!((one.slenderness() / ((30.0 * c + 2.0 * s) / 2.0) - 1.0).abs() < 0.01, "{one:?}");
    }

    #[test]
    fn at_its_limit_a_pillar_is_known_exactly() {
        let mut random = Lcg(29);
        // The diagonals of its sides end beside its corners, and across them lies what rounding makes of a straight side.
        for round in 0..60 {
            let sides = [4, 6, 16, 32][round % 4];
            let upright = turned(&[[1.0, 0.0], [1.0, 16.0]], sides);
            let pillar = if round < 4 { upright } else { moved(&upright, &mut random) };
            let [one] = &found(&pillar, 6.0, 0.2)[..] else { panic!() };
            let exact = 8.0 / (std::f64::consts::PI / f64::from(sides)).cos();
            assert!((one.slenderness() - exact).abs() < 1e-6 && (one.at_most - exact).abs() < 1e-6, "{one:?}");
        }
    }

    #[test]
    fn legs_under_a_top_and_walls_are_no_pillars() {
        let legs = [[0.0, 0.0], [18.0, 0.0], [0.0, 18.0], [18.0, 18.0]];
        let top = cuboid([0.0, 0.0, 30.0], [20.0, 20.0, 32.0]);
        let table = |legs: &[[f64; 2]]| {
            let whole =
                legs.iter().fold(top.clone(), |t, [x, y]| t.joined(&cuboid([*x, *y, 0.0], [x + 2.0, y + 2.0, 30.0])));
            united(&whole, 2e-6).unwrap()
        };
        assert!(found(&table(&legs), 4.0, 0.2).is_empty());
        // On one leg it is the leg that carries all.
        let [one] = &found(&table(&legs[..1]), 4.0, 0.2)[..] else { panic!() };
        assert!((one.slenderness() - 16.0).abs() < 1e-6, "{one:?}");
        assert!(found(&cuboid([0.0; 3], [30.0, 1.2, 25.0]), 8.0, 0.2).is_empty());
    }

    #[test]
    fn legs_beside_each_other_are_no_wall_however_far_apart() {
        let mut random = Lcg(31);
        // Two legs under a beam; what is told is both with the beam, on their width.
        for gap in [3.0, 6.0, 40.0] {
            let beam = cuboid([0.0, 0.0, 78.0], [gap + 4.0, 2.0, 80.0]);
            let legs = [0.0, gap + 2.0].map(|x| cuboid([x, 0.0, 0.0], [x + 2.0, 2.0, 78.0]));
            let part = united(&beam.joined(&legs[0]).joined(&legs[1]), 2e-6).unwrap();
            let [one] = &found(&moved(&part, &mut random), 8.0, 0.2)[..] else { panic!("{gap}") };
            assert!((one.slenderness() - 40.0).abs() < 1e-6 && one.at_most < 40.1, "{gap} {one:?}");
        }
        // Walls with a window near their foot: beside it stands a wall, or posts.
        let wall = |x: f64| {
            let [whole, hole] = [[0.0, 30.0, 0.0, 40.0], [x, 30.0 - x, 10.0, 20.0]];
            let side = |y: f64| {
                [[whole[0], y, whole[2]], [whole[1], y, whole[2]], [whole[1], y, whole[3]], [whole[0], y, whole[3]]]
            };
            let rim =
                |y: f64| [[hole[0], y, hole[2]], [hole[1], y, hole[2]], [hole[1], y, hole[3]], [hole[0], y, hole[3]]];
            let quad = |[a, b, c, d]: [[f64; 3]; 4]| [[a, b, c], [a, c, d]];
            let (near, far) = ((side(0.0), rim(0.0)), (side(2.0), rim(2.0)));
            let ring = (0..4).flat_map(|k| {
                let n = (k + 1) % 4;
                let front = quad([near.0[k], near.0[n], near.1[n], near.1[k]]);
                let back = quad([far.0[n], far.0[k], far.1[k], far.1[n]]);
                let around = quad([near.0[n], near.0[k], far.0[k], far.0[n]]);
                let within = quad([near.1[k], near.1[n], far.1[n], far.1[k]]);
                [front, back, around, within].concat()
            });
            TriangleMesh::weld(ring)
        };
        assert!(found(&wall(9.0), 8.0, 0.2).is_empty());
        let [one] = &found(&wall(5.0), 8.0, 0.2)[..] else { panic!() };
        assert!((one.slenderness() - 15.0).abs() < 1e-6 && (one.foot[2] - 10.0).abs() < 1e-6, "{one:?}");
    }

    #[test]
    fn a_section_is_as_long_as_it_is_and_not_as_its_diagonal() {
        // A rectangle 3.95 times as long as wide has a diagonal of 4.07 widths.
        for (long, count) in [(7.7, 1), (7.9, 1), (8.0, 1), (8.1, 0)] {
            let all = found(&cuboid([0.0; 3], [long, 2.0, 40.0]), 8.0, 0.2);
            assert_eq!(all.len(), count, "{long}");
            assert!(all.iter().all(|f| (f.slenderness() - 20.0).abs() < 1e-6), "{all:?}");
        }
        // As long as four widths, in the numbers of an STL file: no wall whichever way it is turned.
        for n in 0..30 {
            let (s, c) = (0.2 * f64::from(n)).sin_cos();
            let rows = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
            let mut turned = cuboid([0.0; 3], [12.0, 3.0, 40.0]).transformed(rows, [9.0, 15.0, 0.0]);
            turned.vertices.iter_mut().for_each(|p| *p = p.map(|x| f64::from(x as f32)));
            let counting = Counting { least: 8.0, longest_ratio: WALL, layer_mm: 0.2, tie_mm: 2e-6 };
            let all = tall_features(&turned, |_| true, &MeshDistance::new(&turned), &counting);
            assert_eq!(all.len(), 1, "{n}");
        }
    }

    #[test]
    fn two_pillars_on_a_neck_are_told_each_and_the_higher_one_with_what_carries_it() {
        let parts = [
            cuboid([0.0, 0.0, 20.0], [20.0, 4.0, 22.0]),
            cuboid([0.0, 0.0, 22.0], [2.0, 2.0, 52.0]),
            cuboid([18.0, 0.0, 22.0], [20.0, 2.0, 50.0]),
            cuboid([8.0, 0.0, 0.0], [12.0, 4.0, 20.0]),
        ];
        let whole = parts.iter().fold(TriangleMesh::default(), |all, p| all.joined(p));
        let part = united(&whole, 2e-6).unwrap();
        let all = found(&part, 8.0, 0.2);
        let told: Vec<f64> = all.iter().map(|f| (1e3 * f.slenderness()).round()).collect();
        assert_eq!(told, [15000.0, 14000.0]);
        // Without the higher pillar's own slenderness the neck would be what is told.
        let counting = Counting { least: 8.0, longest_ratio: WALL, layer_mm: 31.0, tie_mm: 1e-6 };
        let all = tall_features(&part, |_| true, &MeshDistance::new(&part), &counting);
        assert!((all[0].slenderness() - 52.0 / 4.0).abs() < 1e-6, "{all:?}");
    }
}
