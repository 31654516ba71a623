//! The ways to stand a part up that the page compares: the pose of the run and the best others, each with a thumbnail.

use super::render::{Picture, stance};
use crate::access::{Orientation, Orientations, Question, orientations, standing};
use crate::geometry::vector::{Vec3, dot};
use crate::part::Part;
use crate::process::Process;
use crate::units::Angle;
use rayon::prelude::*;

/// Ways to stand a part up that the command compares in full where it writes a page.
pub const COMPARED: usize = 6;

/// Facets times directions that scoring may take for a page.
const SCORED: usize = 6_000_000;
/// Nearer than this two ways to stand look the same to somebody who chooses.
const APART: f64 = 25.0;
/// Samples along the longest side for the full measure: half of what `amcheck orient` takes.
const SAMPLES: usize = 64;

/// Orientations, and a picture of each that is named by its rank.
#[derive(Debug, Clone)]
pub struct Stances {
    pub orientations: Orientations,
    pub pictures: Vec<Picture>,
}

/// Compares the pose of a part with others, `most` in full; `None` for a part that has no volume to be oriented.
///
/// Directions are given in the frame of the file.
///
/// # Cost
/// As [`orientations`] with at most 100 directions, fewer for parts of more than 60,000 facets.
pub fn stances(part: &Part, process: &Process, most: usize) -> Option<Stances> {
    let mesh = part.mesh();
    let directions = (SCORED / mesh.triangles.len().max(1)).clamp(12, 100);
    let given = Some([0.0, 0.0, 1.0]);
    let question = Question {
        directions,
        best: most,
        given,
        apart: Angle::degrees(APART),
        samples: SAMPLES,
        ..Question::of(process, part.step())
    };
    let mut orientations = orientations(mesh, part, &question).ok()?;
    let pictures = orientations.list.par_iter().enumerate().with_max_len(1);
    let pictures = pictures.map(|(n, o)| thumbnail(part, o, n + 1)).collect();
    for o in &mut orientations.list {
        let rows = o.rotation;
        o.up = of_file(part, o.up);
        o.rotation = rows.map(|row| of_file(part, row));
    }
    Some(Stances { orientations, pictures })
}

/// A direction of the part's frame in that of the file.
fn of_file(part: &Part, d: Vec3) -> Vec3 {
    let pose = part.pose();
    [0, 1, 2].map(|c| dot([pose[0][c], pose[1][c], pose[2][c]], d)).map(crate::units::report_digits)
}

/// The part in an orientation of its own frame, what needs support painted, named by its rank.
///
/// # Cost
/// O(facets + pixels).
pub fn thumbnail(part: &Part, o: &Orientation, rank: usize) -> Picture {
    let posed = standing(part.mesh(), &o.rotation);
    let mut needs = vec![false; posed.triangles.len()];
    for &f in &o.wanting_support {
        needs.get_mut(f as usize).into_iter().for_each(|n| *n = true);
    }
    stance(&rank.to_string(), &posed, &needs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::part::Up;
    use crate::units::Length;

    /// A plate that is judged on its edge: the pose of the run is listed, the best is flat, told in the frame of the file.
    #[test]
    fn the_pose_of_the_run_is_among_them_and_directions_are_those_of_the_file() {
        let mesh = Primitive::parse("box:40x30x4mm").unwrap().mesh(Length::mm(1.0));
        let part = Part::new(mesh, Up::Along([1.0, 0.0, 0.0]), 1e-6, 0.0).unwrap();
        let found = stances(&part, &Process::named("fdm").unwrap(), 4).unwrap();
        let list = &found.orientations.list;
        let given = list.iter().find(|o| o.from == "given").unwrap();
        assert_eq!(given.up, [1.0, 0.0, 0.0]);
        assert_eq!(given.box_mm[2], 40.0);
        assert!(list[0].up[2].abs() == 1.0 && list[0].box_mm[2] == 4.0, "{:?}", list[0]);
        assert!(list.len() == 4 && found.pictures.len() == 4 && found.pictures[3].name == "4");
    }
}
