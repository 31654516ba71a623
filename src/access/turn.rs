//! A way to stand the part up in which less hangs over, measured.

use super::direction::{Facets, Score, Whole, candidates};
use super::orient::{shares, standing, stood, upright};
use super::question::Question;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, angle};
use crate::layer::Bounding;
use crate::units::Angle;
use rayon::prelude::*;

/// Poses that are measured.
const MEASURED: usize = 2;

/// A direction to stand the part up by, and what hangs over then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Direction of the mesh that points up.
    pub up: Vec3,
    /// Area of the facets that need support then without what of them rests on the plate or on other material, mm².
    pub hanging_mm2: f64,
    /// The least angle of these facets from the horizontal; a right angle without any.
    pub flattest: Angle,
}

/// The turn with the least area that needs support, among the two most promising of the axes and the part's flat faces; `None`
/// where none of them fits the machine and stands.
///
/// The mesh stands with +z up; that direction and those within `question.apart` of it are not among them. Promise is the score of
/// [`orientations`](super::orientations); the area is that of the facets that [`stood`] finds, as far as they rest on nothing, so it is what a
/// check of the turned part measures.
///
/// # Cost
/// O(directions·facets) for 30 directions at most, posed one after the other until two stand, and twice the ceilings of a posed part.
pub fn least_hanging(mesh: &TriangleMesh, facets: &impl Bounding, question: &Question) -> Option<Turn> {
    let bounding = |f: usize| facets.bounds_solid(f);
    let flats = Facets::of(mesh, &bounding, 0);
    let whole = Whole::of(mesh, &flats);
    if !(whole.volume > 0.0 && whole.area > 0.0) {
        return None;
    }
    let apart = question.apart.as_radians();
    let turned = |(up, _): &(Vec3, &str)| angle(*up, [0.0, 0.0, 1.0]) > apart;
    let list: Vec<(Vec3, &str)> = candidates(&flats, &[], 0).into_iter().filter(turned).collect();
    let mut scores: Vec<Score> =
        list.into_par_iter().with_max_len(1).map(|(up, from)| flats.score(up, from, question, &whole)).collect();
    scores.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let posed = |score: &Score| {
        let posed = standing(mesh, &upright(score.up));
        question.stands(&posed, bounding).then_some(score.up)
    };
    let promising: Vec<Vec3> = scores.iter().filter_map(posed).take(MEASURED).collect();
    let measured = promising.into_par_iter().with_max_len(1).map(|up| Turn::measured(mesh, up, facets, question));
    measured.collect::<Vec<_>>().into_iter().min_by(|a, b| a.hanging_mm2.total_cmp(&b.hanging_mm2))
}

impl Turn {
    /// What hangs over of a part that is stood up so.
    fn measured(mesh: &TriangleMesh, up: Vec3, facets: &impl Bounding, question: &Question) -> Self {
        let (posed, wanted) = stood(mesh, &upright(up), facets, question);
        let hanging = shares(&posed, &wanted, facets, question);
        Turn {
            up,
            hanging_mm2: hanging.iter().map(|&(f, share)| share * posed.facet_area(f as usize)).sum(),
            flattest: flattest(&posed, hanging.iter().map(|h| h.0)),
        }
    }
}

/// The least angle of facets that look down from the horizontal; a right angle without any.
pub fn flattest(mesh: &TriangleMesh, facets: impl IntoIterator<Item = u32>) -> Angle {
    let down = facets.into_iter().map(|f| -mesh.normal(f as usize)[2]).fold(0.0, f64::max);
    Angle::radians(down.min(1.0).acos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::extruded;
    use crate::process::Process;

    #[test]
    fn a_gallows_is_laid_on_its_side_and_a_cube_has_nothing_to_gain() {
        let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 16.0], [30.0, 16.0], [30.0, 20.0], [0.0, 20.0]];
        let mesh = extruded(&outline, &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 6.0);
        let question = Question::of(&Process::named("fdm").unwrap(), 1e-6);
        let standing_now = stood(&mesh, &upright([0.0, 0.0, 1.0]), &|_| true, &question).1;
        let now: f64 = standing_now.iter().map(|&f| mesh.facet_area(f as usize)).sum();
        assert!((now - 26.0 * 6.0).abs() < 1e-6, "{now}");
        let turn = least_hanging(&mesh, &|_| true, &question).unwrap();
        assert_eq!((turn.hanging_mm2, turn.flattest), (0.0, Angle::degrees(90.0)));
        assert_eq!(flattest(&mesh, standing_now), Angle::degrees(0.0));
        assert!(turn.up[2] < 0.99);
        let small = Question { build_volume_mm: [10.0; 3], ..question };
        assert_eq!(least_hanging(&mesh, &|_| true, &small), None);
    }

    #[test]
    fn what_of_a_slope_lies_on_the_plate_does_not_hang_over() {
        // A wedge whose underside rises by 3° from a foot of 10 mm over 30 mm.
        let (depth, slope) = (6.0, 3f64.to_radians());
        let outline = [[0.0, 0.0], [10.0, 0.0], [40.0, 30.0 * slope.tan()], [40.0, 60.0], [0.0, 30.0]];
        let mesh = extruded(&outline, &[[0, 1, 4], [1, 2, 4], [2, 3, 4]], depth);
        let question = Question::of(&Process::named("fdm").unwrap(), 1e-6);
        let found = Turn::measured(&mesh, [0.0, 0.0, 1.0], &|_| true, &question);
        // Half a layer of 0.2 mm lies on the plate.
        let truth = depth * (30.0 - 0.1 / slope.tan()) / slope.cos();
        assert!((found.hanging_mm2 - truth).abs() < 1e-4 * truth, "{found:?} {truth}");
    }
}
