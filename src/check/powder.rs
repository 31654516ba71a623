//! Powder on surface that no tool touches: what a jet of air sees along a straight line, and what runs out by itself.

use crate::access::{Patch, Setup, grain_reach};
use crate::distance::{nearest_sample, squared_distance};
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::MeshDistance;
use crate::geometry::vector::{add, along, dot, norm, scale, sub};
use crate::part::Part;
use crate::topology::{Adjacency, components};
use crate::units::short;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Add;

/// A line that all but follows a facet, as the cosine to its normal, starts a grain before it instead of on it.
const GRAZING: f64 = 1e-3;
/// Where such a line starts, in steps of the file's coordinates: before all that they leave open.
const GRAIN: f64 = 10.0;

/// Samples beyond the part's grid that a ball is looked for on.
const BESIDE: isize = 2;

/// Whether powder leaves the surface at the middle of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leaves {
    /// A straight line along a direction of the list leaves the part from here.
    pub in_sight: bool,
    /// A ball as wide as the escape hole comes from outside to within its radius, in sight of it: for certain, and perhaps.
    pub runs_out: [bool; 2],
}

impl Leaves {
    /// Whether powder stays: for certain, and perhaps.
    pub fn stays(self) -> [bool; 2] {
        [!self.in_sight && !self.runs_out[1], !self.in_sight && !self.runs_out[0]]
    }
}

/// Whether powder leaves the patches of a surface that no tool touches.
pub struct Powder {
    /// The least way out that powder takes by itself, millimetres, if the process has one.
    hole: Option<f64>,
    leaves: BTreeMap<usize, (f64, Leaves)>,
}

impl Powder {
    /// Of the patches of a surface that are asked for, by their indices.
    ///
    /// # Errors
    /// As [`leaves`].
    pub fn on(part: &Part, setups: &[Setup], surface: &[Patch], asked: &[usize], hole: Option<f64>) -> Result<Self> {
        let asked: Vec<(usize, &Patch)> = asked.iter().filter_map(|&p| Some((p, surface.get(p)?))).collect();
        let patches: Vec<&Patch> = asked.iter().map(|a| a.1).collect();
        let found = leaves(part, setups, &patches, hole)?;
        Ok(Powder { hole, leaves: asked.into_iter().zip(found).map(|((p, at), l)| (p, (at.area, l))).collect() })
    }

    /// Area of some of the patches that powder stays on: for certain, and perhaps, mm².
    pub fn stays_on(&self, patches: &[usize]) -> [f64; 2] {
        let known = || patches.iter().filter_map(|p| self.leaves.get(p));
        [0, 1].map(|n| known().filter(|(_, l)| l.stays()[n]).map(|(area, _)| area).fold(0.0, f64::add))
    }

    /// What becomes of the powder, in a sentence; none where no patch was asked for.
    pub fn sentence(&self) -> Option<String> {
        let sum = |wanted: fn(&Leaves) -> bool| {
            self.leaves.values().filter(|(_, l)| wanted(l)).map(|(area, _)| area).fold(0.0, f64::add)
        };
        let all: Vec<usize> = self.leaves.keys().copied().collect();
        if all.is_empty() {
            return None;
        }
        let [least, most] = self.stays_on(&all);
        if least >= sum(|_| true) {
            return Some(
                "Powder stays on all that cannot be touched: no straight line of air leads there, and no way out."
                    .into(),
            );
        }
        let mut ways = vec![format!("powder stays on {}", between(least, most))];
        let (seen, runs) = (sum(|l| l.in_sight), [sum(|l| l.runs_out[0]), sum(|l| l.runs_out[1])]);
        if let (Some(hole), true) = (self.hole, runs[1] > 0.0) {
            let by = format!("runs out of {} through ways at least {} mm wide", between(runs[0], runs[1]), short(hole));
            ways.push(by);
        }
        if seen > 0.0 {
            ways.push(format!("a straight line of air leads to {}", area(seen)));
        }
        Some(format!("Of what cannot be touched, {}.", ways.join(", ")))
    }
}

/// Two areas, or one if they are the same.
pub fn between(least: f64, most: f64) -> String {
    match (area(least), area(most)) {
        (least, most) if least == most => least,
        (least, most) => format!("{} to {most}", least.trim_end_matches(" mm²")),
    }
}

/// An area in words.
pub fn area(mm2: f64) -> String {
    format!("{} mm²", short((mm2 * 100.0).round() / 100.0))
}

/// Whether powder leaves each of some patches, by air along the directions of the setups or through ways at least `hole` millimetres wide.
///
/// Sight is exact at the middle of each patch. Ways are those of a ball on the part's grid: certain ones clear all cubes that the
/// part touches, possible ones only those wholly in it.
///
/// # Errors
/// As [`Part::solid`] and [`grain_reach`].
///
/// # Cost
/// One ray for each patch and setup; six distance transforms of the part's grid.
fn leaves(part: &Part, setups: &[Setup], patches: &[&Patch], hole: Option<f64>) -> Result<Vec<Leaves>> {
    let ways = match hole {
        Some(hole) if !patches.is_empty() => Some(Ways::of(part, 0.5 * hole)?),
        _ => None,
    };
    let view = part.distance();
    let leads_out = |p: &Patch, d| {
        let before = if dot(d, p.normal) > GRAZING { 0.0 } else { GRAIN * part.step() };
        view.first_hit(along(p.at, p.normal, before), d, 1e-6 * p.radius, f64::INFINITY).is_none()
    };
    let in_sight = |p: &Patch| {
        let mut ahead = setups.iter().map(|s| s.direction).filter(|&d| dot(d, p.normal) > -GRAZING);
        // Nothing leads out of a void that is closed all round.
        !part.bounds_sealed_void(p.facet as usize) && ahead.any(|d| leads_out(p, d))
    };
    let at = |p: &&Patch| Leaves {
        in_sight: in_sight(p),
        runs_out: ways.as_ref().map_or([false, true], |w| w.lead_to(p, view)),
    };
    Ok(patches.par_iter().map(at).collect())
}

/// Where a ball that comes from outside gets to within its radius of, with nothing in between.
struct Ways {
    radius: f64,
    /// For each sample the nearest one that the ball covers for certain, if it covers any.
    nearest: Option<Field<u32>>,
    /// The samples from whose cube a sample that the ball may cover is perhaps in reach.
    perhaps: Indicator,
}

impl Ways {
    fn of(part: &Part, radius: f64) -> Result<Self> {
        let solid = part.solid()?;
        // Beside a face of the part's box the nearest sample that is covered for certain is the second one beyond it.
        let widened = |set: &Indicator| set.window([-BESIDE; 3], set.grid().dims().map(|n| n + 2 * BESIDE as usize));
        let (inner, outer) = (widened(&solid.inner)?, widened(&solid.outer)?);
        let [surely, covered] = grain_reach(&inner, &outer, radius)?;
        let nearest = (!surely.is_empty()).then(|| nearest_sample(&surely)).transpose()?;
        let covered = covered.difference(&inner)?;
        if covered.is_empty() {
            return Ok(Ways { radius, nearest, perhaps: covered });
        }
        // A line between two cubes is longer than that between their samples by at most their diagonal, and leaves the void in no
        // cube that lies wholly in the part: what it may lead through hangs together.
        let (away, most) = (squared_distance(&covered)?, radius / covered.grid().h() + 3f64.sqrt());
        let near = Indicator::from_predicate(*covered.grid(), |at| f64::from(away.values()[at]).sqrt() <= most);
        let near = near.difference(&inner)?;
        let found = components(&near, Adjacency::Corner);
        let mut reached = vec![false; found.count()];
        for at in covered.iter() {
            found.of(covered.grid().index(at)).into_iter().for_each(|c| reached[c as usize] = true);
        }
        Ok(Ways { radius, nearest, perhaps: found.select(|c| reached[c as usize]) })
    }

    /// Whether the ball comes to within its radius of the middle of a patch, which sees it: for certain, and perhaps.
    fn lead_to(&self, patch: &Patch, view: &MeshDistance) -> [bool; 2] {
        let surely = self.nearest.as_ref().is_some_and(|nearest| {
            [0.0, 0.5, 1.0].iter().any(|out| {
                let from = add(patch.at, scale(patch.normal, out * self.radius));
                let Some(sample) = nearest.grid().sample_at(from) else { return false };
                let covered = nearest.values()[nearest.grid().offset(sample)] as usize;
                let way = sub(nearest.grid().position(nearest.grid().index(covered)), patch.at);
                let (length, apart) = (norm(way), 1e-6 * patch.radius);
                length <= self.radius
                    && dot(way, patch.normal) > GRAZING * length
                    && view.first_hit(patch.at, scale(way, 1.0 / length), apart, length).is_none()
            })
        });
        // A middle between two cubes belongs to the one before it.
        let beside = add(patch.at, scale(patch.normal, 1e-3 * self.perhaps.grid().h()));
        let samples = [patch.at, beside].map(|p| self.perhaps.grid().sample_at(p));
        [surely, samples.into_iter().any(|s| s.is_none_or(|s| self.perhaps.contains(s)))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::patches;
    use crate::geometry::vector::Vec3;
    use crate::geometry::{Primitive, TriangleMesh};
    use crate::grid::Grid;
    use crate::part::Up;
    use crate::units::Length;

    /// A block of 20 mm with a room of 10 mm in its middle and a square way `wide` straight up from it.
    fn flask(wide: f64) -> TriangleMesh {
        let ring = |half: f64, z: f64| -> [Vec3; 4] {
            [
                [10.0 - half, 10.0 - half, z],
                [10.0 + half, 10.0 - half, z],
                [10.0 + half, 10.0 + half, z],
                [10.0 - half, 10.0 + half, z],
            ]
        };
        let half = 0.5 * wide;
        // From the middle of the floor outside, up, over the rim, and down through the way to the middle of the floor inside.
        let rings =
            [ring(10.0, 0.0), ring(10.0, 20.0), ring(half, 20.0), ring(half, 15.0), ring(5.0, 15.0), ring(5.0, 5.0)];
        let mut found = Vec::new();
        for pair in rings.windows(2) {
            for k in 0..4 {
                let [a, b, c, d] = [pair[0][k], pair[0][(k + 1) % 4], pair[1][(k + 1) % 4], pair[1][k]];
                found.extend([[a, b, c], [a, c, d]]);
            }
        }
        let ([a, b, c, d], [e, f, g, h]) = (rings[0], rings[5]);
        found.extend([[a, c, b], [a, d, c], [e, f, g], [e, g, h]]);
        TriangleMesh::weld(found)
    }

    #[test]
    fn powder_runs_out_through_a_way_wider_than_the_hole_and_is_blown_out_where_a_line_leads() {
        for (wide, hole, runs_out) in [(4.0, 3.0, [true, true]), (2.0, 3.0, [false, false]), (3.0, 2.9, [false, true])]
        {
            let mut part = Part::new(flask(wide), Up::PlusZ, 1e-6, 1.0).unwrap();
            part.cast_on(Grid::covering([0.0; 3], part.extent(), Length::mm(0.25), 1, [0.0; 3]).unwrap());
            let surface = patches(part.mesh(), 0.5, |_| true);
            let inside = |at: Vec3| at.iter().all(|c| (4.9..15.1).contains(c));
            let room: Vec<usize> = (0..surface.len()).filter(|&p| inside(surface[p].at)).collect();
            let setups = part.setups(Length::mm(0.5), Length::mm(2.0)).unwrap();
            let powder = Powder::on(&part, setups, &surface, &room, Some(hole)).unwrap();
            let on_the_floor =
                |at: Vec3, x: f64| (at[2] - 5.0).abs() < 1e-9 && (at[0] - x).abs() < 0.7 && (at[1] - 10.0).abs() < 0.7;
            for (middle, in_sight) in [(10.0, true), (6.5, false)] {
                let there = powder.leaves.iter().filter(|(p, _)| on_the_floor(surface[**p].at, middle));
                let states: Vec<Leaves> = there.map(|(_, l)| l.1).collect();
                assert!(
                    !states.is_empty() && states.iter().all(|l| *l == Leaves { in_sight, runs_out }),
                    "{wide}: {states:?}"
                );
            }
            let [least, most] = powder.stays_on(&room);
            // The ball's radius less its distance from a corner, 0.4 mm, is less than the lattice is sure of: they stay open.
            let corners = 0.01 * 600.0;
            assert!((most < corners) == runs_out[0] && (least == 0.0) == runs_out[1], "{wide}: {least} to {most}");
            assert!(powder.sentence().unwrap().contains("a straight line of air leads to"));
        }
    }

    #[test]
    fn powder_falls_off_every_face_of_a_block_where_no_line_is_allowed() {
        let block = crate::geometry::cuboid([0.0; 3], [9.0, 8.0, 7.0]);
        for h in [0.25, 0.3, 0.5] {
            let mut part = Part::new(block.clone(), Up::PlusZ, 1e-6, 1.0).unwrap();
            part.cast_on(Grid::covering([0.0; 3], part.extent(), Length::mm(h), 1, [0.0; 3]).unwrap());
            let surface = patches(part.mesh(), 0.5, |_| true);
            let all: Vec<usize> = (0..surface.len()).collect();
            let powder = Powder::on(&part, &[], &surface, &all, Some(3.0)).unwrap();
            assert_eq!(powder.stays_on(&all), [0.0, 0.0], "{h}");
        }
    }

    #[test]
    fn a_line_along_a_wall_leads_out_past_it() {
        let part = Part::new(flask(2.0), Up::PlusZ, 1e-5, 1.0).unwrap();
        let surface = patches(part.mesh(), 0.5, |_| true);
        let in_neck = |p: &&Patch| p.at[2] > 15.1 && p.normal[2] == 0.0 && (8.9..11.1).contains(&p.at[0].max(p.at[1]));
        let neck: Vec<&Patch> = surface.iter().filter(in_neck).collect();
        let along_axes = part.setups(Length::mm(0.5), Length::mm(2.0)).unwrap();
        let leaves = leaves(&part, along_axes, &neck, None).unwrap();
        assert!(!leaves.is_empty() && leaves.iter().all(|l| l.in_sight), "{leaves:?}");
    }

    #[test]
    fn a_ball_behind_a_thin_wall_empties_no_room() {
        let shell = |edge: f64| {
            let block = Primitive::parse(&format!("box:{edge}x{edge}x{edge}mm")).unwrap().mesh(Length::mm(1.0));
            let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            block.transformed(still, [10.0; 3])
        };
        let (outside, mut room) = (shell(20.0), shell(18.0));
        room.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let mut part = Part::new(outside.joined(&room), Up::PlusZ, 1e-6, 1.0).unwrap();
        part.cast_on(Grid::covering([0.0; 3], part.extent(), Length::mm(0.25), 1, [0.0; 3]).unwrap());
        let surface = patches(part.mesh(), 1.0, |_| true);
        let within = |at: Vec3| at.iter().all(|c| (0.9..19.1).contains(c));
        let room: Vec<usize> = (0..surface.len()).filter(|&p| within(surface[p].at)).collect();
        let setups = part.setups(Length::mm(0.5), Length::mm(2.0)).unwrap();
        let powder = Powder::on(&part, setups, &surface, &room, Some(3.0)).unwrap();
        let [least, most] = powder.stays_on(&room);
        assert!((least - 6.0 * 18.0 * 18.0).abs() < 1e-6 && least == most, "{least} to {most}");
    }

    #[test]
    fn an_area_is_one_number_where_it_is_known() {
        assert_eq!((between(1.0, 1.001), between(0.5, 12.0)), ("1 mm²".into(), "0.5 to 12 mm²".into()));
    }
}
