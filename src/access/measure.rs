//! The inaccessibility measure: how much of the tool would have to be inside the part to touch a point.

use super::pose::Rotation;
use super::setup::Setup;
use super::stack::Stack;
use super::tool::{Body, Tool};
use crate::convolution::Convolver;
use crate::error::{Error, Result, ToolFault};
use crate::field::{Field, Indicator};
use crate::geometry::vector::{Vec3, bounds, corners_of, dot, sub};
use crate::grid::Grid;
use crate::morphology::Sides;
use crate::units::Volume;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// f(x) = min over tools T, rotations R and sharp points k of vol(X ∩ (R·T + x − R·k)), on the part's grid.
///
/// An estimate: volumes are counts of samples, and x − R·k is rounded to a sample of the setup's lattice, wherever its grid ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// The least overlap, mm³.
    pub field: Field<f32>,
}

impl Measure {
    /// The set { f > λ }: what cannot be touched but by letting more than λ of the tool into the part. λ = 0 is the ideal, a
    /// few samples absorb the sampling.
    pub fn beyond(&self, lambda: Volume) -> Indicator {
        let least = lambda.as_mm3() as f32;
        Indicator::from_predicate(*self.field.grid(), |at| self.field.values()[at] > least)
    }
}

/// The inaccessibility measure of a part over tools and where they come from.
///
/// `part` is the part in its own frame (the setup from +z); coaxial tools come along the directions of `setups`, tools of any
/// other shape at the `rotations`. A coaxial tool without sharp points is meant to touch with its tip.
///
/// # Errors
/// [`Error::Tool`] where a tool has neither a setup nor a rotation; [`Error::Operand`] for a setup of another spacing than the
/// part's; otherwise as [`Convolver::correlate`].
///
/// # Cost
/// For each coaxial tool and setup, (samples) · (rows of its discs), the samples at which a tip off the setup's grid may reach into it
/// among them; for any other tool and rotation, two transforms, the
/// part's spectrum kept.
///
/// # Source
/// M. Mirzendehdel, M. Behandish, S. Nelaturi, Topology optimization with accessibility constraint for multi-axis machining,
/// 2020.
pub fn inaccessibility(part: &Setup, setups: &[&Setup], rotations: &[Rotation], tools: &[Tool]) -> Result<Measure> {
    let grid = *part.grid();
    setups.iter().try_for_each(|setup| grid.one_spacing_with("inaccessibility", setup.grid()))?;
    let mut least = Field::constant(grid, f32::INFINITY);
    for tool in tools {
        let nowhere = Error::Tool { tool: tool.name.clone(), fault: ToolFault::NoDirections };
        match &tool.body {
            Body::Coaxial(_) if setups.is_empty() => return Err(nowhere),
            Body::Solid(_) if rotations.is_empty() => return Err(nowhere),
            Body::Coaxial(m) => {
                let stack = Stack::middles(m, grid.spacing());
                let sharp = rings(tool);
                for setup in setups {
                    let tips = tips(&grid, setup, &sharp);
                    let counts = overlap_counts(&with_room(&setup.centres, tips, &stack)?, &stack);
                    take_least(&mut least, &counts, |x| setup.to_frame(x), &sharp);
                }
            }
            Body::Solid(mesh) => {
                let turned = |r: &Rotation, p: Vec3| r.map(|row| dot(row, p));
                let posed = rotations.iter().map(|r| {
                    Sides::of_mesh(&mesh.transformed(*r, [0.0; 3]), grid.spacing(), [0.0; 3]).map(|s| s.points)
                });
                let posed = posed.collect::<Result<Vec<_>>>()?;
                let reach = [0, 1, 2].map(|a| posed.iter().map(|p| p.grid().dims()[a]).max().unwrap_or(1));
                let convolver = Convolver::new(&part.centres, reach)?;
                for (rotation, posed) in rotations.iter().zip(&posed) {
                    let counts = convolver.correlate(posed)?.field;
                    let sharp: Vec<Vec3> = tool.sharp.iter().map(|s| turned(rotation, s.at_mm)).collect();
                    take_least(&mut least, &counts, |x| x, &sharp);
                }
            }
        }
    }
    let sample = grid.sample_volume().as_mm3() as f32;
    least.values_mut().par_iter_mut().for_each(|v| *v *= sample);
    Ok(Measure { field: least })
}

/// The sharp points of a coaxial tool, its circles as eight points each; the tip where none is named.
fn rings(tool: &Tool) -> Vec<Vec3> {
    let circle = |p: Vec3| {
        let r = p[0].hypot(p[1]);
        let around = if r > 0.0 { 8 } else { 1 };
        (0..around).map(move |n| {
            let turn = TAU * f64::from(n) / f64::from(around);
            [r * turn.cos(), r * turn.sin(), p[2]]
        })
    };
    let list: Vec<Vec3> = tool.sharp.iter().flat_map(|s| circle(s.at_mm)).collect();
    if list.is_empty() { vec![[0.0; 3]] } else { list }
}

/// The box, in the frame of a setup, of the tips x − k of all samples x of a grid.
fn tips(grid: &Grid, setup: &Setup, sharp: &[Vec3]) -> (Vec3, Vec3) {
    let ends = (grid.position([0; 3]), grid.position(grid.dims().map(|n| n - 1)));
    let of_samples = corners_of(ends).map(|x| setup.to_frame(x));
    let (lo, hi) = bounds(of_samples).unwrap_or_default();
    let (least, most) = bounds(sharp.iter().copied()).unwrap_or_default();
    (sub(lo, most), sub(hi, least))
}

/// A set with room for every tip of a box from which a tool may reach into its grid: from below, and from beside it by the width
/// of the tool, which goes up only.
fn with_room(set: &Indicator, tips: (Vec3, Vec3), stack: &Stack) -> Result<Indicator> {
    let grid = set.grid();
    let widest = stack.runs().iter().map(|r| r.disc.half_width(0).unwrap_or(0).max(r.disc.reach())).max().unwrap_or(0);
    let beside = [widest as f64, widest as f64, 0.0];
    let below = [widest as f64, widest as f64, f64::INFINITY];
    let (lo, hi) = (grid.continuous_index(tips.0), grid.continuous_index(tips.1));
    // Tips are rounded to samples; the hair makes up for rounding of their places.
    let beyond = |samples: f64, most: f64| (samples - 0.5 + 1e-6).ceil().clamp(0.0, most) as usize;
    let before = [0, 1, 2].map(|a| beyond(-lo[a], below[a]));
    let after = [0, 1, 2].map(|a| beyond(hi[a] - (grid.dims()[a] - 1) as f64, beside[a]));
    if before == [0; 3] && after == [0; 3] {
        return Ok(set.clone());
    }
    set.placed(before.map(|n| -(n as isize)), grid.padded(before, after)?)
}

/// Lowers each value to the count at x − k, x being seen in the frame of the counts; off their grid nothing overlaps.
fn take_least(least: &mut Field<f32>, counts: &Field<u32>, to_frame: impl Fn(Vec3) -> Vec3 + Sync, sharp: &[Vec3]) {
    let grid: Grid = *least.grid();
    let at = counts.grid();
    least.values_mut().par_iter_mut().enumerate().for_each(|(offset, value)| {
        let x = to_frame(grid.position(grid.index(offset)));
        for &k in sharp {
            let count = at.sample_at(sub(x, k)).map_or(0, |i| counts.values()[at.offset(i)]);
            *value = value.min(count as f32);
        }
    });
}

/// Number of samples of a set in the tool, for the tip at every sample: exact, on the set's grid.
///
/// # Cost
/// O(samples · rows of the discs): sums along z once for each run, then along x, and one difference for each row of a disc.
pub fn overlap_counts(set: &Indicator, stack: &Stack) -> Field<u32> {
    let grid = *set.grid();
    let [nx, ny, nz] = grid.dims();
    let mut counts = Field::constant(grid, 0u32);
    for run in stack.runs() {
        // Along x up to and including a sample, of the layers of the run that lie above the tip.
        let mut sums = vec![0u32; (nx + 1) * ny * nz];
        let plane = (nx + 1) * ny;
        sums.par_chunks_mut(plane).enumerate().for_each(|(k, sums)| {
            let last = run.last.map_or(nz, |l| (k + l + 1).min(nz));
            for s in (k + run.first).min(nz)..last {
                for (j, sums) in sums.chunks_mut(nx + 1).enumerate() {
                    for (w, &word) in set.row(j, s).iter().enumerate() {
                        let mut rest = word;
                        while rest != 0 {
                            sums[w * 64 + rest.trailing_zeros() as usize + 1] += 1;
                            rest &= rest - 1;
                        }
                    }
                }
            }
            for sums in sums.chunks_mut(nx + 1) {
                (1..=nx).for_each(|i| sums[i] += sums[i - 1]);
            }
        });
        let reach = run.disc.reach();
        counts.values_mut().par_chunks_mut(nx).enumerate().for_each(|(row, counts)| {
            let (j, k) = (row % ny, row / ny);
            for y in j.saturating_sub(reach)..(j + reach + 1).min(ny) {
                let Some(width) = run.disc.half_width(y.abs_diff(j)) else { continue };
                let sums = &sums[k * plane + y * (nx + 1)..][..nx + 1];
                for (i, count) in counts.iter_mut().enumerate() {
                    *count += sums[(i + width + 1).min(nx)] - sums[i.saturating_sub(width)];
                }
            }
        });
    }
    counts
}

/// As [`overlap_counts`], by Fourier transforms with exact counts.
///
/// # Errors
/// As [`Convolver::correlate`].
pub fn overlap_counts_by_transform(set: &Indicator, stack: &Stack) -> Result<Field<u32>> {
    let grid = *set.grid();
    let tool = stack.as_set(grid.spacing(), grid.dims()[2])?;
    let reach = tool.grid().dims();
    let counts = Convolver::new(set, reach)?.correlate(&tool)?.field;
    let shift = [(reach[0] - 1) / 2, (reach[1] - 1) / 2, reach[2] - 1];
    let values = (0..grid.samples()).map(|at| {
        let index = grid.index(at);
        counts.values()[counts.grid().offset([0, 1, 2].map(|a| index[a] + shift[a]))]
    });
    Field::from_values(grid, values.collect(), 0)
}

#[cfg(test)]
mod tests {
    use super::super::pose::{axis_rotations, lattice_directions};
    use super::super::tool::SharpPoint;
    use super::*;
    use crate::geometry::{InsideRule, Primitive, TriangleMesh};
    use crate::units::Length;

    const H: Length = Length::mm(0.5);

    fn tool(text: &str) -> Tool {
        Tool::from_toml("t", text, |_| Ok(TriangleMesh::default())).unwrap()
    }

    fn stepped() -> Tool {
        tool(
            "[[piece]]\nrole = \"cutter\"\ndiameter_mm = 1.2\nlength_mm = 2\n[[piece]]\nrole = \"holder\"\ndiameter_mm = 4\n\
              length_mm = 3\n",
        )
    }

    #[test]
    fn sums_of_slices_equal_transforms_and_plain_counting() {
        let grid = Grid::new([0.0; 3], H, [29, 23, 17]).unwrap();
        let set = Indicator::from_predicate(grid, |at| at * 2654435761 % 31 == 0);
        let tool = stepped();
        let stack = Stack::middles(tool.meridian().unwrap(), H);
        let counts = overlap_counts(&set, &stack);
        assert_eq!(counts, overlap_counts_by_transform(&set, &stack).unwrap());
        let digital = stack.as_set(H, 17).unwrap();
        let offsets: Vec<[isize; 3]> = digital
            .iter()
            .map(|at| digital.grid().position(digital.grid().index(at)).map(|x| (x / 0.5).round() as isize))
            .collect();
        for at in (0..grid.samples()).step_by(97) {
            let index = grid.index(at);
            let met = offsets.iter().filter(|o| {
                let s = [0, 1, 2].map(|a| index[a].checked_add_signed(o[a]));
                matches!(s, [Some(i), Some(j), Some(k)] if set.contains([i, j, k]))
            });
            assert_eq!(counts.values()[at] as usize, met.count(), "{index:?}");
        }
    }

    /// A block of 8 × 8 × 6 mm with a blind hole of 3 × 3 mm, 4 mm deep from above.
    fn drilled() -> TriangleMesh {
        let h = Length::mm(1.0);
        let block = Primitive::parse("box:8x8x6mm").unwrap().mesh(h);
        let hole = Primitive::parse("box:3x3x4mm").unwrap().mesh(h);
        let up = |mesh: TriangleMesh, z| {
            mesh.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0, 0.0, z])
        };
        // The hole reaches a little above the top: a notch of its own thickness in the air, wound the other way.
        let mut facets: Vec<[Vec3; 3]> = Vec::new();
        let (block, hole) = (up(block, 0.0), up(hole, 0.9));
        facets.extend((0..block.triangles.len()).map(|f| block.corners(f)));
        facets.extend((0..hole.triangles.len()).map(|f| hole.flipped().corners(f)));
        TriangleMesh::weld(facets)
    }

    #[test]
    fn a_closed_pocket_costs_a_tool_of_known_volume() {
        // The pocket is closed by 0.1 mm: from above a pin of 1.2 mm meets only the lid, from below 2.1 mm of floor.
        let mesh = drilled();
        let cast = |d| Setup::cast(&mesh, InsideRule::Crossings, d, H, Length::mm(3.0)).unwrap();
        let setups = lattice_directions()[..2].iter().map(|&d| cast(d)).collect::<Vec<_>>();
        let pin = tool("[[piece]]\nrole = \"cutter\"\ndiameter_mm = 1.2\nlength_mm = 12\n");
        let list: Vec<&Setup> = setups.iter().collect();
        let both = inaccessibility(&setups[0], &list, &[], std::slice::from_ref(&pin)).unwrap();
        let below = inaccessibility(&setups[0], &list[1..], &[], std::slice::from_ref(&pin)).unwrap();
        let grid = *both.field.grid();
        let at = grid.sample_at([0.0, 0.0, -0.8]).unwrap();
        let read = |m: &Measure| f64::from(m.field.values()[grid.offset(at)]);
        // Nine squares of a quarter mm² for a disc of radius 1.2 spacings: five; a lid thinner than a sample may be missed.
        let area = 5.0 * 0.25;
        assert!(read(&both) <= area * 0.5, "{}", read(&both));
        assert!((read(&below) - area * 2.0).abs() <= area * 0.5 + 1e-6, "{}", read(&below));
        assert!(!both.beyond(Volume::mm3(area)).contains(at) && below.beyond(Volume::mm3(area)).contains(at));
    }

    #[test]
    fn the_measure_does_not_depend_on_the_room_around_the_setup() {
        let block = Primitive::parse("box:8x8x6mm").unwrap().mesh(H);
        // Sharp 1.5 mm beside the axis, too, so that tips stand off the part's grid even where the points they touch do not.
        let pin = tool(
            "[[piece]]\nrole = \"cutter\"\ndiameter_mm = 3\nlength_mm = 2\n[[piece]]\nrole = \"holder\"\n\
             diameter_mm = 5\nlength_mm = 3\n[[sharp]]\nname = \"rim\"\nat_mm = [1.5, 0, 1]\n",
        );
        for direction in [[0.0, 0.0, 1.0], [1.0, 1.0, 0.0]] {
            let cast = |d, mm| Setup::cast(&block, InsideRule::Crossings, d, H, Length::mm(mm)).unwrap();
            let part = cast([0.0, 0.0, 1.0], 2.0);
            let [tight, roomy] = [0.0, 14.0].map(|mm| {
                inaccessibility(&part, &[&cast(direction, mm)], &[], std::slice::from_ref(&pin)).unwrap().field
            });
            assert_eq!(tight, roomy, "{direction:?}");
            assert!(tight.values().iter().all(|v| v.is_finite()));
        }
    }

    #[test]
    fn setups_of_another_spacing_are_refused() {
        let block = Primitive::parse("box:2x2x2mm").unwrap().mesh(H);
        let cast = |h| Setup::cast(&block, InsideRule::Crossings, [0.0, 0.0, 1.0], h, Length::mm(1.0)).unwrap();
        let (part, fine) = (cast(H), cast(Length::mm(0.25)));
        let refused = inaccessibility(&part, &[&part, &fine], &[], &[stepped()]).unwrap_err();
        assert!(refused.to_string().contains("0.5 mm and 0.25 mm"), "{refused}");
    }

    #[test]
    fn a_tool_of_any_shape_gives_what_the_coaxial_path_gives() {
        let mesh = drilled();
        let setups: Vec<Setup> = lattice_directions()[..6]
            .iter()
            .map(|&d| Setup::cast(&mesh, InsideRule::Crossings, d, H, Length::mm(1.0)).unwrap())
            .collect();
        let pin =
            Tool::from_mesh("pin", stepped().mesh(40.0, 96), vec![SharpPoint { name: "tip".into(), at_mm: [0.0; 3] }])
                .unwrap();
        let list: Vec<&Setup> = setups.iter().collect();
        let whole = inaccessibility(&setups[0], &[], &axis_rotations(), &[pin]).unwrap();
        let sliced = inaccessibility(&setups[0], &list, &[], &[stepped()]).unwrap();
        // One lattice for the setups of both ways; the mesh's tool stands on another phase, so counts differ by a shell.
        let mut apart = 0;
        for (a, b) in whole.field.values().iter().zip(sliced.field.values()) {
            apart += usize::from((a - b).abs() > 0.35 * a.max(*b) + 1.0);
        }
        assert!(apart * 20 < whole.field.values().len(), "{apart} of {}", whole.field.values().len());
    }
}
