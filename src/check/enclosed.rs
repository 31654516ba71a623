//! How much void a chamber holds that the plate closes, from below and from above.

use super::filling::{Filling, void_above_plate};
use super::finding::Bracket;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::Solid;
use crate::topology::{Adjacency, Chamber, components};

/// What the rounding of densities may add up to, in shares of a volume.
pub(super) const ROUNDING: f64 = 1e-5;

/// Volume of the void that a chamber holds above the plate, mm³, up to its throat.
///
/// At least the free cubes of the chamber and the void in the cubes touched beside them, where no other void is near; at most all
/// void near them that hangs together with it, which has nothing free beyond where there is no throat. Dead ends narrower than a
/// sample, and those narrower than the throat, are followed as far as the throat is wide.
///
/// # Errors
/// None for a chamber of the solid.
///
/// # Cost
/// O(samples of the window).
pub(super) fn enclosed(chamber: &Chamber, clearance: &Field<u32>, solid: &Solid) -> Result<Bracket> {
    let throat = chamber.throat.map_or(0.0, |t| f64::from(t.clearance).sqrt());
    // Other void shows beside the farthest cubes that may be the chamber's, and so is looked for farther out by a diagonal.
    let wide = Filling::grown(chamber, clearance, solid, 4.0 + throat)?;
    let within = wide.balls(chamber, clearance, |c| (c.sqrt() + 2.0 + throat).powi(2))?.intersection(&wide.set)?;
    let sure = surely_its_own(&wide, chamber, clearance)?;
    let likely = wide.balls(chamber, clearance, |c| (c.sqrt() + 1.0).powi(2))?.difference(&wide.material()?)?;
    let sum = |set: &Indicator| void_above_plate(&wide, set);
    let free = wide.set.difference(&wide.touched()?)?;
    let grid = *sure.grid();
    // By the plate, which caps the clearance, what is free may be the chamber's own, but for what is straight below others.
    let mut others = Indicator::from_predicate(grid, |at| {
        let index = grid.index(at);
        free.contains(index) && !sure.contains(index) && !wide.is_by_the_plate(index[2])
    });
    spread_down(&wide, &mut others, |index| free.contains(index) && !sure.contains(index));
    let beside = |index: [usize; 3]| near(index, &others, |other| wide.is_above_plate(other));
    let most = if chamber.throat.is_some() { within.clone() } else { within.difference(&others)? };
    let own = match chamber.throat {
        Some(_) => within.intersection(&likely.union(&sure)?)?,
        None => Indicator::from_predicate(grid, |at| {
            let index = grid.index(at);
            most.contains(index) && (free.contains(index) || !beside(index))
        }),
    };
    let low = Indicator::from_predicate(grid, |at| {
        let index = grid.index(at);
        sure.contains(index) || (own.contains(index) && !free.contains(index) && !beside(index))
    });
    let parts = components(&most, Adjacency::Corner);
    let mut met = vec![false; parts.count()];
    sure.iter().filter_map(|at| parts.of(grid.index(at))).for_each(|l| met[l as usize] = true);
    let high = sum(&parts.select(|l| met[l as usize]));
    Ok(Bracket::new(sum(&own), sum(&low) * (1.0 - ROUNDING), high * (1.0 + ROUNDING)))
}

/// The free cubes of a chamber: its balls of clearance, and what is free straight below them down to the plate, which caps the
/// clearance.
fn surely_its_own(wide: &Filling, chamber: &Chamber, clearance: &Field<u32>) -> Result<Indicator> {
    let mut sure = wide.balls(chamber, clearance, |c| (c - 1.0).max(0.0))?;
    let touched = wide.touched()?;
    spread_down(wide, &mut sure, |index| !touched.contains(index));
    Ok(sure)
}

/// Adds to a set what is wanted straight below it by the plate.
fn spread_down(wide: &Filling, set: &mut Indicator, wanted: impl Fn([usize; 3]) -> bool) {
    let [nx, ny, nz] = set.grid().dims();
    for k in (0..nz.saturating_sub(1)).rev().filter(|&k| wide.is_by_the_plate(k)) {
        for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
            if set.contains([i, j, k + 1]) && wanted([i, j, k]) {
                set.set([i, j, k], true);
            }
        }
    }
}

/// Whether any of the 26 samples around one is in a set and as wanted.
fn near(index: [usize; 3], set: &Indicator, wanted: impl Fn([usize; 3]) -> bool) -> bool {
    let dims = set.grid().dims();
    (0..27).any(|n: usize| {
        let at = [0, 1, 2].map(|a| index[a] + n / 3usize.pow(a as u32) % 3);
        (0..3).all(|a| (1..=dims[a]).contains(&at[a])) && {
            let at = at.map(|c| c - 1);
            set.contains(at) && wanted(at)
        }
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::void::Voids;
    use super::super::void::tests::part;
    use super::*;
    use crate::geometry::{Primitive, TriangleMesh, revolved};
    use crate::random::Lcg;
    use crate::units::Length;

    /// A block of 20 mm a side with a square pocket from below.
    pub(in crate::check) fn pocket(wide: f64, deep: f64) -> TriangleMesh {
        hollow([10.0, 0.5 * wide], deep)
    }

    /// A block 20 mm tall with a square pocket from below, both by half their sides.
    fn hollow([a, b]: [f64; 2], deep: f64) -> TriangleMesh {
        let square = |r: f64, z: f64| [[-r, -r, z], [r, -r, z], [r, r, z], [-r, r, z]];
        let mut facets = Vec::new();
        let mut strip = |p: [[f64; 3]; 4], q: [[f64; 3]; 4]| {
            for i in 0..4 {
                let j = (i + 1) % 4;
                facets.extend([[p[i], p[j], q[j]], [p[i], q[j], q[i]]]);
            }
        };
        strip(square(a, 0.0), square(a, 20.0));
        strip(square(b, deep), square(b, 0.0));
        strip(square(b, 0.0), square(a, 0.0));
        let [p, q] = [square(a, 20.0), square(b, deep)];
        facets.extend([[p[0], p[1], p[2]], [p[0], p[2], p[3]], [q[2], q[1], q[0]], [q[3], q[2], q[0]]]);
        TriangleMesh::weld(facets)
    }

    fn held(mesh: TriangleMesh, h: f64, phase: [f64; 3]) -> Vec<Bracket> {
        let part = part(mesh, h, phase);
        let voids = Voids::of(&part).unwrap();
        let standing = voids.above_plate(&voids.clearance().unwrap()).unwrap();
        let found = voids.on_plate(&standing, 3.0).unwrap();
        found.iter().map(|t| t.volume_mm3).collect()
    }

    #[test]
    fn a_pocket_on_the_plate_holds_its_volume_at_any_spacing() {
        let mut rng = Lcg(5);
        for case in 0..40 {
            let (wide, deep, h) = (6.0 + 8.0 * rng.unit(), 5.0 + 10.0 * rng.unit(), 0.3 + 0.4 * rng.unit());
            let [found] = held(pocket(wide, deep), h, [0, 1, 2].map(|_| rng.unit() - 0.5))[..] else {
                panic!("{case}: one chamber")
            };
            let truth = wide * wide * deep;
            assert!((found.value / truth - 1.0).abs() < 1e-5, "{case}: {found:?} {truth}");
            assert!(found.low <= truth && truth <= found.high, "{case}: {found:?} {truth}");
            assert!(found.high - found.low < 1e-4 * truth, "{case}: {found:?} {truth}");
        }
    }

    #[test]
    fn a_shell_of_two_samples_holds_what_is_inside_it_alone() {
        let mut rng = Lcg(15);
        for case in 0..40 {
            let (edge, wall) = (20.0, 0.4 + 0.6 * rng.unit());
            let h = wall / (1.1 + 1.6 * rng.unit());
            let [a, b] = [0.5 * edge, 0.5 * edge - wall];
            let [found] = held(hollow([a, b], edge - wall), h, [0, 1, 2].map(|_| rng.unit() - 0.5))[..] else {
                panic!("{case}: one chamber")
            };
            let truth = (2.0 * b).powi(2) * (edge - wall);
            assert!(found.low <= truth && truth <= found.high, "{case}: {found:?} {truth}, wall {wall}, h {h}");
        }
    }

    #[test]
    fn the_bracket_holds_what_a_dome_holds() {
        // The void of a truncated cone: π/3 · 9 · (16 + 4 + 8) mm³, as inscribed with 96 sides.
        let dome = revolved(&[[4.0, 0.0], [8.0, 0.0], [8.0, 12.0], [0.0, 12.0], [0.0, 9.0], [2.0, 9.0]], 96);
        let sector = std::f64::consts::TAU / 96.0;
        let truth = 0.5 * 96.0 * sector.sin() * 9.0 / 3.0 * (16.0 + 4.0 + 8.0);
        let mut rng = Lcg(6);
        for case in 0..20 {
            let [found] = held(dome.clone(), 0.25 + 0.2 * rng.unit(), [0, 1, 2].map(|_| rng.unit() - 0.5))[..] else {
                panic!("{case}: one chamber")
            };
            assert!(found.low <= truth && truth <= found.high, "{case}: {found:?} {truth}");
            assert!((found.value / truth - 1.0).abs() < 2e-3, "{case}: {found:?} {truth}");
        }
    }

    #[test]
    fn what_has_nothing_below_holds_nothing() {
        let block = Primitive::parse("box:10x10x10mm").unwrap().mesh(Length::mm(1.0));
        assert!(held(block, 0.5, [0.1; 3]).is_empty());
    }
}
