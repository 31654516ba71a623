//! What of a result is finer than the samples that it was made of, and missing.

use super::operated::Operated;
use super::pieces::{Box3, Pieces};
use super::whole::Whole;
use crate::error::Result;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use crate::morphology::{missed, remains};
use crate::notice::{Notice, number_of};
use crate::units::{Length, short};
use std::borrow::Cow;

/// A piece with no side longer than so many spacings is a crumb.
const CRUMB: f64 = 3.0;
/// How far a surface may end from the box of the exact result, in spacings.
const SHORT: f64 = 2.0;
/// As many crumbs as may be meant: a sphere of three samples is a sphere.
const MEANT: usize = 2;
/// How far a crumb may reach beyond the box of the body that it is what remains of, in spacings.
const BEYOND: f64 = 0.5;

/// By how much the box of what an operation makes of a body differs from the body's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// All of every body remains: the box is longer by so much before and behind, and the exact result touches it on all sides.
    Around(Vec3, Vec3),
    /// What remains, if anything does, lies within that box.
    Within(Vec3, Vec3),
}

impl Reach {
    /// The box of what becomes of a body, `outwards` 1, or of a void, −1.
    pub(super) fn about(&self, (lo, hi): Box3, outwards: f64) -> Box3 {
        let (Reach::Around(before, behind) | Reach::Within(before, behind)) = *self;
        ([0, 1, 2].map(|a| lo[a] + outwards * before[a]), [0, 1, 2].map(|a| hi[a] + outwards * behind[a]))
    }

    pub(super) fn keeps_all(&self) -> bool {
        matches!(self, Reach::Around(..))
    }
}

impl Pieces<'_> {
    /// Says where the surface comes in crumbs, as it does where the result is thinner than the spacing: the rest is left out. One or
    /// two may be meant: where what becomes of a body or a void of the part is as small, or nobody knows what does.
    ///
    /// # Cost
    /// O(facets); where there are one or two crumbs, the union of the part's bodies.
    pub fn left_out(&self, part: &TriangleMesh, reach: Option<Reach>, spacing: Length) -> Option<Notice> {
        let mut crumbs = self.crumbs(spacing * CRUMB);
        if crumbs.len() <= MEANT {
            let meant = meant(part, reach.filter(|_| !crumbs.is_empty())?, spacing);
            let beyond = BEYOND * spacing.as_mm();
            let lies_in =
                |of: &Box3, all: &Box3| (0..3).all(|a| all.0[a] - beyond <= of.0[a] && of.1[a] <= all.1[a] + beyond);
            crumbs.retain(|crumb| !meant.iter().any(|body| lies_in(crumb, body)));
        }
        let &(at, _) = crumbs.first()?;
        let text = format!(
            "{} no longer than {CRUMB} samples, {}at ({}) mm: where the result is thinner than the spacing parts of it are left out; choose a \
             smaller --voxel",
            number_of(crumbs.len() as u64, ["loose piece is", "loose pieces are"]),
            if crumbs.len() == 1 { "" } else { "one " },
            at.map(short).join(", ")
        );
        Some(Notice::new("thinner-than-spacing", text).at(at))
    }

    /// Says that the surface comes in more pieces than the part where that only grows, as each piece of a sum holds a body of the part: where
    /// what joins them is thinner than the spacing; between bodies a closing may leave pieces that hold none.
    ///
    /// # Cost
    /// O(facets); where there are several pieces, the union of the part's bodies.
    pub fn comes_apart(&self, part: &TriangleMesh) -> Option<Notice> {
        let count = self.bodies();
        if count < 2 {
            return None;
        }
        let bodies = Pieces::of(&Whole::of(part).mesh).bodies();
        let volumes = self.volumes();
        let solid = volumes.iter().zip(&self.boxes).filter(|(volume, _)| **volume > 0.0);
        let (_, (lo, hi)) = solid.min_by(|a, b| a.0.total_cmp(b.0))?;
        let at = [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]));
        (count > bodies).then(|| {
            let text = format!(
                "the result comes in {count} pieces and the part in {bodies}, the least near ({}) mm: what joins them may be thinner than the \
                 spacing; choose a smaller --voxel",
                at.map(short).join(", ")
            );
            Notice::new("thinner-than-spacing", text).counted(count as u64).at(at)
        })
    }

    /// The boxes of the pieces whose sides are no longer than a length.
    fn crumbs(&self, longest: Length) -> Vec<Box3> {
        let is_small = |(lo, hi): &&Box3| (0..3).all(|a| hi[a] - lo[a] <= longest.as_mm());
        self.boxes.iter().filter(is_small).copied().collect()
    }
}

impl Operated {
    /// Says where a closing fills what may be room for its element, because no sample tells.
    pub fn may_fill_too_much(&self) -> Option<Notice> {
        let (count, at) = self.filled?;
        let (is, one) = if count == 1 { ("gap or room", "") } else { ("gaps or rooms", "one ") };
        let text = format!(
            "{count} {is} about as wide as the element, {one}near ({}) mm, may be open and came out filled: the spacing does not tell; choose a smaller \
             --voxel",
            at.map(short).join(", ")
        );
        Some(Notice::new("thinner-than-spacing", text).at(at))
    }

    /// Says where the surface ends farther from the box that the exact result touches than samples explain: what reached there is thinner
    /// than the spacing.
    pub fn falls_short(&self, part: &TriangleMesh, reach: Reach, spacing: Length) -> Option<Notice> {
        let (lo, hi) = reach.about(part.bounds().filter(|_| reach.keeps_all())?, 1.0);
        let (from, to) = self.mesh.bounds()?;
        let short_by = (0..3).map(|a| (from[a] - lo[a]).max(hi[a] - to[a])).fold(0.0, f64::max);
        (short_by > SHORT * spacing.as_mm()).then(|| {
            let text = format!(
                "the result ends {} mm short of where its box does: what reaches there is thinner than the spacing and left out; choose a \
                 smaller --voxel",
                short(short_by)
            );
            Notice::new("thinner-than-spacing", text)
        })
    }

    /// Says where an offset by exact distances leaves something, of the part or of a gap in it, that its surface does not reach.
    ///
    /// # Errors
    /// As [`remains`].
    pub fn thinned_out(&self, part: &TriangleMesh, by: Length, spacing: Length) -> Result<Option<Notice>> {
        let Some(field) = &self.distances else { return Ok(None) };
        let found = remains(part, by, &self.mesh, field)?;
        Ok(found.filter(|found| found.beyond.as_mm() > SHORT * spacing.as_mm()).map(|found| {
            let text = format!(
                "{} reaches {} mm beyond the surface near ({}) mm: it is thinner than the spacing there and left out; choose a smaller --voxel",
                if by.as_mm() < 0.0 { "what is left of the part" } else { "what is left of a gap" },
                short(found.beyond.as_mm()),
                found.at_mm.map(short).join(", ")
            );
            Notice::new("thinner-than-spacing", text).at(found.at_mm)
        }))
    }
}

impl Operated {
    /// Says how much of the exact surface of an offset, an opening or a closing by a ball this one misses: where walls or gaps are about as thin as the spacing.
    ///
    /// # Cost
    /// As [`missed`].
    pub fn misses(&self, part: &TriangleMesh, spacing: Length) -> Option<Notice> {
        let missed = |part: &TriangleMesh| missed(part, self.contact?, &self.mesh, spacing);
        // Facets within other bodies are no surface of the part.
        let found = missed(part).and_then(|found| match Whole::of(part).mesh {
            Cow::Borrowed(_) => Some(found),
            Cow::Owned(united) => missed(&united),
        })?;
        let hundredth = |x: f64| short((100.0 * x).round() / 100.0);
        let text = format!(
            "{} % of the surface ({} mm²) is off by more than 0.3 spacings or missing, as near ({}) mm: walls or gaps are about as thin as the spacing there; \
             choose a smaller --voxel",
            hundredth((100.0 * found.share).max(0.01)),
            short(found.area.as_mm2().round().max(1.0)),
            found.at_mm.map(hundredth).join(", ")
        );
        Some(Notice::new("thinner-than-spacing", text).at(found.at_mm))
    }
}

/// The boxes of what becomes of the bodies and voids of a part, those that meet as one, where that is no longer than a crumb.
fn meant(part: &TriangleMesh, reach: Reach, spacing: Length) -> Vec<Box3> {
    let whole = Whole::of(part);
    let pieces = Pieces::of(&whole.mesh);
    let become_of =
        pieces.volumes().into_iter().zip(&pieces.boxes).map(|(volume, own)| reach.about(*own, volume.signum()));
    let longest = CRUMB * spacing.as_mm();
    become_of.filter(|(lo, hi)| (0..3).all(|a| (0.0..=longest).contains(&(hi[a] - lo[a])))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::operate::offset;

    #[test]
    fn small_pieces_are_crumbs_and_large_ones_are_not() {
        let large = cuboid([0.0; 3], [5.0, 1.0, 0.2]);
        let crumb = |x: f64| cuboid([x, 9.0, 0.0], [x + 0.2, 9.2, 0.1]);
        let mesh = large.joined(&crumb(0.0)).joined(&crumb(3.0));
        let crumbs = |mm: f64| Pieces::of(&mesh).crumbs(Length::mm(mm)).len();
        assert_eq!(crumbs(0.3), 2);
        assert_eq!(crumbs(0.15), 0);
        assert_eq!(crumbs(6.0), 3);
    }

    fn made(part: &TriangleMesh, by: f64, h: f64) -> Operated {
        offset(part, Length::mm(by), Length::mm(h)).unwrap()
    }

    #[test]
    fn nothing_is_missed_of_bodies_that_overlap_touch_or_lie_in_each_other() {
        let cube = cuboid([0.0; 3], [10.0; 3]);
        for (at, wide) in [([5.0, 0.0, 0.0], 10.0), ([10.0, 0.0, 0.0], 10.0), ([3.0; 3], 4.0)] {
            let part = cube.clone().joined(&cuboid(at, at.map(|x: f64| x + wide)));
            for by in [-1.0, 1.0] {
                let missed = made(&part, by, 0.25).misses(&part, Length::mm(0.25));
                assert!(missed.is_none(), "{at:?} by {by}: {missed:?}");
            }
        }
    }

    #[test]
    fn a_strip_that_comes_off_a_sharp_edge_is_told() {
        let pieces = cuboid([0.0; 3], [3.0; 3]).joined(&cuboid([3.4, 1.0, 0.0], [3.45, 1.1, 3.0]));
        let apart = made(&pieces, 0.01, 0.02);
        let whole = cuboid([0.0; 3], [3.0; 3]);
        assert_eq!(apart.pieces().comes_apart(&pieces), None);
        let told = apart.pieces().comes_apart(&whole).unwrap();
        let [x, ..] = told.at_mm.unwrap();
        assert!(
            told.count == Some(2) && (x - 3.425).abs() < 0.01 && told.message.contains("2 pieces and the part in 1")
        );
        // A void within a body is no piece.
        let hollow = whole.joined(&cuboid([1.0; 3], [2.0; 3]).flipped());
        assert_eq!(made(&hollow, 0.1, 0.2).pieces().comes_apart(&hollow), None);
    }

    #[test]
    fn one_crumb_is_told_unless_the_body_it_comes_from_is_as_small() {
        let (by, h) = (-0.15, 0.2);
        let shrunk = Reach::Within([-by; 3], [by; 3]);
        let bar = cuboid([0.0; 3], [10.0, 2.0, 2.0]);
        // What remains of the plate is as long as the bar, and thinner than the spacing but for the knob on it.
        let knob = cuboid([5.0, 5.0, -0.1], [5.7, 5.7, 0.5]);
        let part = bar.clone().joined(&cuboid([0.0, 4.0, 0.0], [10.0, 8.0, 0.33]).joined(&knob));
        let found = made(&part, by, h);
        assert_eq!(found.pieces().crumbs(Length::mm(CRUMB * h)).len(), 1);
        assert!(found.pieces().left_out(&part, Some(shrunk), Length::mm(h)).is_some());
        let part = bar.joined(&cuboid([5.0, 5.0, 0.0], [5.8, 5.8, 0.8]));
        let found = made(&part, by, h);
        assert_eq!(found.pieces().crumbs(Length::mm(CRUMB * h)).len(), 1);
        assert_eq!(found.pieces().left_out(&part, Some(shrunk), Length::mm(h)), None);
    }
}
