//! What can be seen along a direction, and where a grain of powder gets out from.

use super::disc::Disc;
use super::setup::Setup;
use super::stack::{Run, Sense, Stack};
use crate::distance::squared_distance;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::topology::{Adjacency, components};

/// The samples outside the part from which a line along the setup's direction leaves it, on the setup's grid: certain ones,
/// and possible ones.
///
/// Certain: no cube that the part touches lies above. Possible: none that lies wholly in the part does.
///
/// # Cost
/// One walk over the words of the sets.
pub fn line_of_sight(setup: &Setup) -> [Indicator; 2] {
    let above = |set: &Indicator| {
        let Some(disc) = Disc::middles(0.0) else { return set.clone() };
        Stack::new(vec![Run { first: 0, last: None, disc }]).dilate(set, Sense::Obstacle).complement()
    };
    [above(&setup.outer), above(&setup.inner)]
}

/// Where a ball of `radius` millimetres, such as a grain of powder or the end of a brush, gets to from outside: samples that
/// it covers for certain, and samples that it may cover.
///
/// Certain: balls about centres that no touched cube comes near, joined to the border over faces. Possible: balls about
/// centres no nearer to full cubes than the radius less half the diagonal of a cube, joined over corners.
///
/// # Errors
/// [`Error::Operand`] if the grids differ or the radius is negative or not finite; otherwise as [`squared_distance`].
///
/// # Cost
/// Four distance transforms.
pub fn grain_reach(inner: &Indicator, outer: &Indicator, radius: f64) -> Result<[Indicator; 2]> {
    let refused = |problem: String| Error::Operand {
        operation: "reach of a grain",
        problem,
        remedy: "give both sides of one part on one grid, and a finite radius of 0 or more".into(),
    };
    if inner.grid() != outer.grid() {
        return Err(refused(format!("grids differ: {:?} and {:?}", inner.grid(), outer.grid())));
    }
    if !(radius >= 0.0 && radius.is_finite()) {
        return Err(refused(format!("a radius of {radius} mm")));
    }
    let h = inner.grid().h();
    let half_diagonal = 0.5 * 3f64.sqrt();
    let reach = |part: &Indicator, clear: f64, cover: f64, adjacency| -> Result<Indicator> {
        // Room on all sides, so that the outside is one.
        let by = clear.max(cover).ceil().min(1e12) as isize + 1;
        let room = part.window([-by; 3], part.grid().dims().map(|n| n + 2 * by as usize))?;
        let centres = at_least(&room, clear)?;
        let found = components(&centres, adjacency);
        let outside = found.at_border();
        let free = found.select(|c| outside[c as usize]);
        let covered = at_least(&free, cover)?.complement();
        covered.placed([by; 3], *part.grid())
    };
    let r = radius / h;
    Ok([
        reach(outer, r + half_diagonal, r, Adjacency::Face)?,
        reach(inner, r - half_diagonal, r + half_diagonal, Adjacency::Corner)?,
    ])
}

/// The samples at a distance of at least `least` spacings from a set: beyond it where `least` is positive.
fn at_least(set: &Indicator, least: f64) -> Result<Indicator> {
    let most = if least > 0.0 { least * least } else { 0.0 };
    if set.is_empty() {
        return Ok(set.complement());
    }
    let distance = squared_distance(set)?;
    Ok(Indicator::from_predicate(*set.grid(), |at| {
        let d2 = f64::from(distance.values()[at]);
        d2 > 0.0 && d2 > most * (1.0 + 1e-12)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::norm;
    use crate::grid::Grid;
    use crate::units::Length;

    /// A hollow ball of radii 3 and 5 mm with a pipe of the given bore straight up.
    fn bottle(bore: f64) -> Setup {
        let grid = Grid::covering([-6.0; 3], [6.0; 3], Length::mm(0.25), 1, [0.0; 3]).unwrap();
        let depth = |p: [f64; 3]| {
            let shell = (5.0 - norm(p)).min(norm(p) - 3.0);
            let pipe = if p[2] > 0.0 { p[0].hypot(p[1]) - bore } else { f64::INFINITY };
            shell.min(pipe)
        };
        let within = |level: f64| Indicator::from_predicate(grid, |at| depth(grid.position(grid.index(at))) >= level);
        let reach = 0.25 * 0.5 * 3f64.sqrt();
        let frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Setup::of_sets([0.0, 0.0, 1.0], frame, [within(reach), within(0.0), within(-reach)])
    }

    #[test]
    fn a_grain_leaves_a_bottle_through_a_neck_wider_than_itself() {
        let grid = *bottle(1.0).grid();
        let middle = grid.sample_at([0.0, 0.0, -2.0]).unwrap();
        for (bore, radius, certain, possible) in
            [(1.5, 0.6, true, true), (0.6, 1.6, false, false), (1.0, 0.95, false, true)]
        {
            let part = bottle(bore);
            let [sure, may] = grain_reach(&part.inner, &part.outer, radius).unwrap();
            assert!(sure.is_subset(&may).unwrap());
            assert_eq!(
                (sure.contains(middle), may.contains(middle)),
                (certain, possible),
                "bore {bore}, grain {radius}"
            );
            let outside = grid.sample_at([5.5, 0.0, -5.5]).unwrap();
            assert!(sure.contains(outside));
        }
    }

    #[test]
    fn sides_of_two_grids_and_grains_of_no_size_are_refused() {
        let part = bottle(1.0);
        for radius in [-0.1, f64::NAN, f64::INFINITY, 1e300] {
            let refused = grain_reach(&part.inner, &part.outer, radius);
            assert!(matches!(refused, Err(Error::Operand { .. })), "{radius}");
        }
        let other = part.outer.window([0; 3], [9; 3]).unwrap();
        assert!(matches!(grain_reach(&part.inner, &other, 0.5), Err(Error::Operand { .. })));
    }

    #[test]
    fn what_lies_below_the_neck_is_seen_from_above() {
        let part = bottle(1.0);
        let [sure, may] = line_of_sight(&part);
        let at = |p| part.grid().sample_at(p).unwrap();
        assert!(sure.contains(at([0.0, 0.0, -2.0])) && !may.contains(at([2.0, 0.0, 0.0])));
        assert!(sure.contains(at([5.6, 5.6, -5.0])) && sure.is_subset(&may).unwrap());
        assert!(!may.contains(at([0.0, 0.0, -5.5])), "below the bottle");
    }
}
