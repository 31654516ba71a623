//! Bodies of a part that a result has nothing of.

use super::left_out::Reach;
use super::operated::Operated;
use super::pieces::{Box3, Pieces};
use crate::error::Result;
use crate::geometry::vector::{Vec3, add, distance, scale};
use crate::geometry::{MeshDistance, TriangleMesh, Winding};
use crate::notice::Notice;
use crate::units::{Length, short};
use std::cell::OnceCell;

/// Nearer than this to a body's box, in spacings, a surface may be the body's.
const BESIDE: f64 = 0.25;
/// As many lost bodies are looked for; where there are more, they are told as at least so many.
const MOST_LOST: usize = 32;
/// Samples across the thinnest side of what is looked at again, and how many they may be altogether.
const ACROSS: f64 = 12.0;
const SAMPLES: f64 = 60_000.0;

impl Operated {
    /// Says which bodies of a part the surface has nothing of though the exact result has, because they, or what is left of them, are thinner
    /// than the spacing. `again` makes the same of one body at a finer spacing, where the operation may well leave nothing of it.
    ///
    /// # Cost
    /// A search for each body, and a small operation for each that the surface has nothing of.
    pub fn lost_bodies(
        &self,
        part: &TriangleMesh,
        reach: Reach,
        spacing: Length,
        again: impl Fn(&TriangleMesh, Length) -> Result<Operated>,
    ) -> Option<Notice> {
        let pieces = Pieces::of(part);
        if pieces.boxes.len() < 2 {
            return None;
        }
        let shown = Shown::of(self, spacing);
        let remains = |piece: usize, left: Box3| {
            let body = pieces.mesh(piece);
            !body.vertices.first().is_some_and(|&p| shown.holds(p))
                && (reach.keeps_all()
                    || again(&body, finer(pieces.boxes[piece], left, spacing)).is_ok_and(|m| m.is_certain()))
        };
        let bodies: Vec<usize> = pieces
            .volumes()
            .into_iter()
            .enumerate()
            .filter(|(_, volume)| *volume > 0.0)
            .map(|(piece, _)| piece)
            .collect();
        let is_lost = |piece: &usize| {
            let left = reach.about(pieces.boxes[*piece], 1.0);
            !is_empty(left) && !shown.in_box(left) && remains(*piece, left)
        };
        let lost: Vec<Vec3> =
            bodies.iter().copied().filter(is_lost).take(MOST_LOST).map(|piece| middle(pieces.boxes[piece])).collect();
        told(&lost, bodies.len())
    }

    fn is_certain(&self) -> bool {
        self.bracket[0].as_mm3() > 0.0
    }
}

fn told(lost: &[Vec3], of: usize) -> Option<Notice> {
    let &at = lost.first()?;
    let (count, at_least) = (lost.len(), if lost.len() == MOST_LOST { "at least " } else { "" });
    let (are, one) = if count == 1 { ("is", "") } else { ("are", "one ") };
    let text = format!(
        "{at_least}{count} of the part's {of} bodies {are} left out, {one}near ({}) mm: what remains is thinner than the spacing; choose a smaller \
         --voxel",
        at.map(short).join(", ")
    );
    Some(Notice::new("thinner-than-spacing", text).counted(count as u64).at(at))
}

/// What a surface shows.
struct Shown<'a> {
    mesh: &'a TriangleMesh,
    surface: MeshDistance,
    winding: OnceCell<Winding>,
    beside: f64,
}

impl<'a> Shown<'a> {
    fn of(made: &'a Operated, spacing: Length) -> Self {
        let surface = MeshDistance::new(&made.mesh);
        Shown { mesh: &made.mesh, surface, winding: OnceCell::new(), beside: BESIDE * spacing.as_mm() }
    }

    /// Whether some of the surface lies in a box, or beside it.
    fn in_box(&self, (lo, hi): Box3) -> bool {
        let [lo, hi] = [lo.map(|x| x - self.beside), hi.map(|x| x + self.beside)];
        let within = |_: u32, p: Vec3| (0..3).all(|a| lo[a] <= p[a] && p[a] <= hi[a]);
        let at = middle((lo, hi));
        self.surface.nearest_where(at, distance(at, hi) * (1.0 + 1e-9), within).is_some()
    }

    /// Whether a point lies inside.
    fn holds(&self, p: Vec3) -> bool {
        self.winding.get_or_init(|| Winding::new(self.mesh)).at(p) > 0.5
    }
}

fn middle((lo, hi): Box3) -> Vec3 {
    scale(add(lo, hi), 0.5)
}

fn sides((lo, hi): Box3) -> [f64; 3] {
    [0, 1, 2].map(|a| hi[a] - lo[a])
}

fn is_empty(of: Box3) -> bool {
    sides(of).iter().any(|side| *side <= 0.0)
}

/// The spacing at which a body shows what is left of it, as far as a few samples go.
fn finer(body: Box3, left: Box3, spacing: Length) -> Length {
    let thinnest = sides(left).into_iter().fold(f64::INFINITY, f64::min);
    let fine = (thinnest / ACROSS).max((sides(body).iter().product::<f64>() / SAMPLES).cbrt());
    Length::mm(fine.min(spacing.as_mm()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, cuboid};
    use crate::operate::{Element, difference, minkowski, offset};

    const H: Length = Length::mm(0.3);

    /// A block, and cubes of a quarter of a millimetre in a row beside it, the last of them in a hollow of the block.
    fn bodies() -> TriangleMesh {
        let block = cuboid([0.0; 3], [6.0, 6.0, 6.0]).joined(&cuboid([1.0; 3], [5.0; 3]).flipped());
        let at = [[8.1, 0.0, 0.0], [9.2, 0.0, 0.0], [3.0, 3.0, 3.0]];
        at.into_iter().map(|lo: Vec3| cuboid(lo, lo.map(|x| x + 0.25))).fold(block, |all, cube| all.joined(&cube))
    }

    fn lost(made: &Operated, reach: Reach, again: impl Fn(&TriangleMesh, Length) -> Result<Operated>) -> u64 {
        made.lost_bodies(&bodies(), reach, H, again).and_then(|notice| notice.count).unwrap_or_default()
    }

    #[test]
    fn bodies_are_lost_where_something_of_them_should_remain() {
        for side in [0.05, 0.2, 0.3] {
            let by = Element::BuiltIn(Primitive::parse(&format!("box:{side}x{side}x{side}mm")).unwrap());
            let again = |body: &TriangleMesh, h: Length| difference(body, &by, h);
            let reach = Reach::Within([0.5 * side; 3], [-0.5 * side; 3]);
            lost_or_shown(&again(&bodies(), H).unwrap(), reach, again, if side < 0.25 { 3 } else { 0 });
        }
        for by in [-0.05, -0.1, -0.13] {
            let again = |body: &TriangleMesh, h: Length| offset(body, Length::mm(by), h);
            let reach = Reach::Within([-by; 3], [by; 3]);
            lost_or_shown(&again(&bodies(), H).unwrap(), reach, again, if by > -0.125 { 3 } else { 0 });
        }
    }

    /// Of the cubes so many are lost or shown beside the two shells of the block, and some are lost if any.
    fn lost_or_shown(
        made: &Operated,
        reach: Reach,
        again: impl Fn(&TriangleMesh, Length) -> Result<Operated>,
        count: u64,
    ) {
        let (shown, lost) = (Pieces::of(&made.mesh).boxes.len() as u64 - 2, lost(made, reach, again));
        assert!(lost + shown == count && (lost > 0) == (count > 0), "{lost} lost, {shown} shown, {reach:?}");
    }

    #[test]
    fn bodies_that_a_result_shows_or_holds_are_not_lost() {
        let by = Element::BuiltIn(Primitive::parse("box:1x1x1mm").unwrap());
        let again = |body: &TriangleMesh, h: Length| minkowski(body, &by, h);
        assert_eq!(lost(&again(&bodies(), H).unwrap(), Reach::Around([-0.5; 3], [0.5; 3]), again), 0);
        // Grown by 3 mm the block's hollow is gone.
        let again = |body: &TriangleMesh, h: Length| offset(body, Length::mm(3.0), h);
        assert_eq!(lost(&again(&bodies(), H).unwrap(), Reach::Around([-3.0; 3], [3.0; 3]), again), 0);
    }
}
