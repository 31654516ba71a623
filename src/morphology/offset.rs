//! Offsets of meshes by a signed length, from exact distances.

use super::bodies::{Bodies, Facets};
use super::buried::refuse_buried_facets;
use super::level::Level;
use super::near::{Near, squared_distance_to_shell};
use super::traced::Traced;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::geometry::{Enclosure, InsideRule, MeshDistance, TriangleMesh, enclose};
use crate::grid::Grid;
use crate::units::{Length, Volume};
use rayon::prelude::*;

/// Half the diagonal of a unit cube, with a hair for rounding.
pub(super) const HALF_DIAGONAL: f64 = 0.866_025_403_785;

/// Where the lattice stands about the box, in spacings: faces on round coordinates are neither on samples nor on cubes.
const BETWEEN: [f64; 3] = [0.23, 0.31, 0.27];

/// Offsets by less than this, in spacings, look at samples inside the part: those at most a spacing from the level, seen from
/// half a diagonal further.
pub const NEAR_PART: f64 = 2.0;

/// A shape made from a mesh: its surface, and the two numbers that its volume lies between.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaped {
    /// The surface: closed, manifold, vertices on the level set but for some on creases; empty where nothing remains.
    pub mesh: TriangleMesh,
    /// Certified bounds on the volume of the exact result.
    pub volume: [Volume; 2],
    /// The function whose zero set the surface is: millimetres, negative inside, exact near the surface.
    pub field: Field<f32>,
}

/// The offset of a solid by a signed length: `{ x : d(x) ≤ by }` with d the signed distance, negative inside.
///
/// Outwards it is the sum with a ball, inwards the difference. Distances are exact, to the facets; the surface's
/// vertices lie on the level, those on creases where the sheets beside them meet, as two steps of Newton's find it, but that they are drawn
/// back where facets would cross; curved facets are inscribed; edges deeper than three thousandths of the spacing are split, outwards up to twice. Bodies that overlap
/// or touch are one solid: outwards, and at 0, the facets of each that lie inside another do not count. Sheets and gaps thinner than the spacing stay
/// whole but for up to a spacing along their rims, where no other is within two spacings; between bodies that overlap gaps may fill.
///
/// # Limits
/// Of one body that passes through itself they do: the bracket is wider there, and vertices may lie up to a spacing inside where
/// the level is nearer than two.
///
/// # Errors
/// [`Error::Operand`] for a length that is not finite or more than a thousand spacings, [`Error::NoGeometry`] for a mesh
/// without facets, [`Error::NotSolid`] inwards where a facet lies inside the material because bodies overlap or touch;
/// otherwise as [`crate::geometry::voxelize()`].
///
/// # Cost
/// One cast and one distance transform of the grid; four distances to the mesh for each sample near the new surface. Outwards by
/// less than two spacings the health of the mesh as well, and where several bodies are near, a distance and a winding number for each.
pub fn offset(mesh: &TriangleMesh, by: Length, spacing: Length) -> Result<Shaped> {
    let mut part = Measured::around(mesh, by, spacing)?;
    if by.as_mm() < 0.0 {
        part.refuse_buried_facets(mesh)?;
    } else if by.as_mm() < NEAR_PART * spacing.as_mm() {
        part.of.bodies = Bodies::overlapping(mesh, spacing);
    }
    part.grown(by)
}

/// The union of closed bodies, whose winding numbers must nowhere be negative.
///
/// # Errors
/// As [`offset`].
pub(super) fn united(bodies: &[TriangleMesh], spacing: Length) -> Result<Shaped> {
    let all = bodies.iter().fold(TriangleMesh::default(), |all, body| all.joined(body));
    let mut part = Measured::around(&all, Length::mm(0.0), spacing)?;
    part.of.bodies = Some(Bodies::of(bodies));
    part.grown(Length::mm(0.0))
}

/// A mesh on a grid: its sides, the distances to it, and roughly those of the samples.
pub(super) struct Measured {
    pub(super) of: Facets,
    pub(super) sides: Enclosure,
    /// Squared distances, in spacings, to the cubes that facets touch.
    pub(super) shell2: Field<u32>,
}

impl Measured {
    /// The mesh on a grid that holds it and its offset.
    ///
    /// # Errors
    /// As [`offset`].
    pub(super) fn around(mesh: &TriangleMesh, by: Length, spacing: Length) -> Result<Self> {
        let (r, h) = (by.as_mm(), spacing.as_mm());
        let (lo, hi) = mesh.bounds().ok_or_else(|| Error::NoGeometry {
            problem: "the mesh has no facets".into(),
            remedy: "give a closed mesh".into(),
        })?;
        if !(r.is_finite() && r.abs() <= 1000.0 * h) {
            return Err(Error::Operand {
                operation: "offset",
                problem: format!("a length of {r} mm at a spacing of {h} mm"),
                remedy: "give a finite length of at most a thousand spacings".into(),
            });
        }
        let reach = r.max(0.0);
        Self::on(mesh, &Grid::covering(lo.map(|x| x - reach), hi.map(|x| x + reach), spacing, 2, BETWEEN)?)
    }

    /// The mesh on a grid.
    pub(super) fn on(mesh: &TriangleMesh, grid: &Grid) -> Result<Self> {
        let sides = enclose(mesh, grid, InsideRule::Crossings)?;
        let of = MeshDistance::new(mesh).into();
        Ok(Measured { of, shell2: squared_distance_to_shell(&sides)?, sides })
    }

    /// The offset of what was measured.
    fn grown(self, by: Length) -> Result<Shaped> {
        let (values, near) = Near::of(self.of, &self.sides.centres, &self.shell2, by.as_mm(), None)?;
        let traced = Traced { values, level: Some(Level { near, r: by.as_mm() }), walls: None };
        let (mesh, volume) = (traced.surface()?, bracket(&traced.values));
        Ok(Shaped { mesh, volume, field: traced.values })
    }

    /// Refuses a mesh whose nearest facet may not be its boundary.
    pub(super) fn refuse_buried_facets(&self, mesh: &TriangleMesh) -> Result<()> {
        refuse_buried_facets(mesh, &self.of.exact, &self.sides.centres, &self.shell2)
    }
}

/// Bounds on the volume of `{ s ≤ 0 }`: s changes by at most a millimetre per millimetre, also where it is the least of several
/// distances, so a ball of radius |s| about a sample lies on the sample's side.
fn bracket(field: &Field<f32>) -> [Volume; 2] {
    let grid = field.grid();
    let (h, plane) = (grid.h(), grid.dims()[0] * grid.dims()[1]);
    let of_plane = |values: &[f32]| {
        values.iter().fold([0.0, 0.0], |[low, high], &s| {
            let share = ball_in_cube(f64::from(s.abs()) / h);
            if s <= 0.0 { [low + share, high + 1.0] } else { [low, high + 1.0 - share] }
        })
    };
    let planes: Vec<[f64; 2]> = field.values().par_chunks(plane).map(of_plane).collect();
    [0, 1].map(|side| grid.sample_volume() * planes.iter().map(|p| p[side]).sum::<f64>())
}

/// The volume of the part of a ball that lies in the unit cube about its centre, for radii up to where it no longer
/// grows simply: a lower bound above √½, and for radii that are off by rounding.
pub(super) fn ball_in_cube(radius: f64) -> f64 {
    let radius = (radius - 1e-6).max(0.0);
    if radius >= HALF_DIAGONAL {
        return 1.0;
    }
    let r = radius.min(std::f64::consts::FRAC_1_SQRT_2);
    let ball = 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    let height = (r - 0.5).max(0.0);
    let cap = std::f64::consts::PI * height * height * (3.0 * r - height) / 3.0;
    ball - 6.0 * cap
}

#[cfg(test)]
mod tests {
    use super::super::rolling::open_by_ball;
    use super::*;
    use crate::geometry::vector::norm;
    use crate::geometry::{Primitive, cuboid};
    use std::f64::consts::PI;

    fn cube() -> TriangleMesh {
        Primitive::parse("box:20x20x20mm").unwrap().mesh(Length::mm(1.0))
    }

    /// Steiner: V + S·r + 3π·a·r² + 4/3·π·r³.
    fn grown(a: f64, r: f64) -> f64 {
        a.powi(3) + 6.0 * a * a * r + 3.0 * PI * a * r * r + 4.0 / 3.0 * PI * r.powi(3)
    }

    fn inside_bracket(shape: &Shaped, volume: f64) {
        let [low, high] = shape.volume.map(|v| v.as_mm3());
        assert!(low <= volume && volume <= high, "{volume} not in {low} … {high}");
    }

    #[test]
    fn a_cube_grown_by_two_has_steiners_volume() {
        let h = 24.0 / 128.0;
        let shape = offset(&cube(), Length::mm(2.0), Length::mm(h)).unwrap();
        let relative = shape.mesh.signed_volume() / grown(20.0, 2.0) - 1.0;
        println!("20 mm cube + 2 mm at 128 samples: {relative:.2e}, {} facets", shape.mesh.triangles.len());
        assert!(relative.abs() <= 1e-4, "{relative}");
        inside_bracket(&shape, grown(20.0, 2.0));
        let [low, high] = shape.volume.map(|v| v.as_mm3());
        // The area is 3 208 mm²; the bracket is at most √3 of it in spacings.
        assert!(high - low < 3f64.sqrt() * h * 3208.0);
    }

    #[test]
    fn vertices_lie_on_the_offset_however_few_spacings_it_is() {
        for (size, r, h) in [
            ([128.0, 60.0, 40.0], 1.0, 1.0),
            ([128.5, 61.0, 40.3], 1.0, 1.0),
            ([60.0, 30.0, 20.0], 0.5, 1.0),
            ([60.0, 30.0, 20.0], 0.2, 0.5),
            ([60.0, 30.0, 20.0], 1.4, 1.0),
            ([60.0, 30.0, 20.0], 0.05, 0.5),
        ] {
            let half = size.map(|s: f64| 0.5 * s);
            let mesh = cuboid(half.map(|x| -x), half);
            let shape = offset(&mesh, Length::mm(r), Length::mm(h)).unwrap();
            let off = |p: &[f64; 3]| {
                let beyond = [0, 1, 2].map(|a| p[a].abs() - half[a]);
                let inside = beyond.iter().fold(f64::NEG_INFINITY, |m, b| m.max(*b)).min(0.0);
                (norm(beyond.map(|b| b.max(0.0))) + inside - r).abs()
            };
            let most = shape.mesh.vertices.iter().map(off).fold(0.0, f64::max);
            // Where the slopes at both ends of an edge are within a tenth, the crossing is that of the cubic through them, which is off by
            // an eighth of that at most.
            assert!(most < 0.0125 * h, "{size:?} + {r} at {h}: {most}");
        }
    }

    #[test]
    fn shrinking_a_cube_keeps_its_corners() {
        let shape = offset(&cube(), Length::mm(-3.0), Length::mm(0.5)).unwrap();
        inside_bracket(&shape, 14f64.powi(3));
        println!("20 mm cube - 3 mm: {:.6} of 2744", shape.mesh.signed_volume());
        // Creases run along edges; a corner may be off by the margin that a feature keeps from its cell.
        assert!((shape.mesh.signed_volume() / 14f64.powi(3) - 1.0).abs() < 1e-4, "{}", shape.mesh.signed_volume());
        assert!(offset(&cube(), Length::mm(-11.0), Length::mm(0.5)).unwrap().mesh.triangles.is_empty());
    }

    #[test]
    fn vertices_on_creases_between_curved_sides_lie_on_the_level() {
        let rod = Primitive::parse("cylinder:r3h14mm").unwrap().mesh(Length::mm(0.002));
        let (h, by) = (0.5, 1.5);
        let (mut vertices, mut off, mut worst) = (0, 0, 0.0f64);
        for turn in [0.4f64, 0.9, 1.4] {
            // Lying across the first, aslant to the grid.
            let ((s, c), (t, d)) = (turn.sin_cos(), (0.5 * turn).sin_cos());
            let rows = [[c, s * t, s * d], [0.0, d, -t], [-s, c * t, c * d]];
            let both = rod.clone().joined(&rod.transformed(rows, [0.3, 1.1, 0.2]));
            let exact = MeshDistance::new(&both);
            let made = offset(&both, Length::mm(by), Length::mm(h)).unwrap().mesh;
            vertices += made.vertices.len();
            for &p in &made.vertices {
                let beside = (exact.nearest(p, f64::INFINITY).unwrap().distance - by).abs();
                off += usize::from(beside > 0.01 * h);
                worst = worst.max(beside);
            }
        }
        println!(
            "two rods + {by} mm: {off} of {vertices} vertices off the level by more than {}, {worst} at most",
            0.01 * h
        );
        // Newton's two steps leave less than a hundredth of a spacing, but where creases end and no three sheets meet, and where they are
        // blunted so that no facets cross; the tangent planes at the corners of a cell alone leave 1 in 160 vertices off, and up to a
        // third of a spacing.
        assert!(off * 10_000 < vertices && worst < 0.02 * h, "{off} of {vertices}, {worst}");
    }

    #[test]
    fn a_box_shrunk_by_less_than_a_spacing_stays_in_the_smaller_box() {
        let (sides, h) = ([10.3, 8.1, 6.2], 0.625);
        for by in [0.15, 0.3, 0.5, 0.6] {
            let made = offset(&cuboid([0.0; 3], sides), Length::mm(-by), Length::mm(h)).unwrap().mesh;
            let (lo, hi) = made.bounds().unwrap();
            let off = (0..3).map(|a| (lo[a] - by).abs().max((hi[a] - sides[a] + by).abs())).fold(0.0, f64::max);
            println!("box - {by} mm at {h}: {off} mm off at most");
            // A facet's rim is no round edge, however near the crease is to it.
            assert!(off < 0.01 * h, "{by}: {lo:?} {hi:?}");
        }
    }

    #[test]
    fn a_crease_just_beside_samples_is_met_where_it_is() {
        // A side of the smaller box is a three hundredth of a spacing off a plane of samples: along them, towards the crease, the distance
        // hardly changes before it.
        let h = 30.0 / 128.0;
        for sides in [[4.0, 5.0, 7.5], [5.0, 7.5, 7.5], [10.0, 6.0, 7.5]] {
            let half = sides.map(|s: f64| 0.5 * s);
            let made = offset(&cuboid(half.map(|x| -x), half), Length::mm(-1.0), Length::mm(h)).unwrap().mesh;
            let beyond = |p: &[f64; 3]| (0..3).map(|a| p[a].abs() - (half[a] - 1.0)).fold(f64::MIN, f64::max);
            let worst = made.vertices.iter().map(beyond).fold(0.0f64, |m, x| m.max(x.abs()));
            // Single precision, and what Newton's last step leaves.
            assert!(worst < 1e-3 * h, "{sides:?}: {worst}");
        }
    }

    #[test]
    fn vertices_where_round_parts_leave_flat_ones_lie_on_the_level() {
        let (h, by) = (0.5, 1.5);
        let (mut vertices, mut worst) = (0, 0.0f64);
        for case in 0..25 {
            // Edges of the lattice lie from a tenth to a hundredth of a spacing under the last face, and in it.
            let side = 6.0 + 0.02 * f64::from(case);
            let made = offset(&cuboid([0.0; 3], [side, 5.0, 4.0]), Length::mm(by), Length::mm(h)).unwrap().mesh;
            vertices += made.vertices.len();
            for p in made.vertices {
                let beyond = [(p[0], side), (p[1], 5.0), (p[2], 4.0)].map(|(x, side)| (x - side).max(-x).max(0.0));
                worst = worst.max((norm(beyond) - by).abs());
            }
        }
        println!("boxes + {by} mm: {vertices} vertices, {worst} mm off the level at most");
        // The root of a cubic through exact values and slopes, and where these tell of a crease, a last step of Newton's that
        // is shorter than a tenth of a spacing.
        assert!(worst < 0.005 * h, "{worst}");
    }

    #[test]
    fn small_offsets_and_none_are_right_too() {
        for r in [0.0, 0.1, -0.1, 0.4] {
            let shape = offset(&cube(), Length::mm(r), Length::mm(0.4)).unwrap();
            let want = if r > 0.0 { grown(20.0, r) } else { (20.0 + 2.0 * r).powi(3) };
            inside_bracket(&shape, want);
            println!("20 mm cube {r:+} mm: {:.4} of {want:.4}", shape.mesh.signed_volume());
            // Sharp or nearly sharp edges: 12·20 mm of them, each cut by at most h²/2.
            assert!((shape.mesh.signed_volume() - want).abs() < 240.0 * 0.08, "{r}: {}", shape.mesh.signed_volume());
        }
    }

    #[test]
    fn overlapping_bodies_grow_as_one_and_shrink_only_when_united() {
        let block = Primitive::parse("box:10x10x10mm").unwrap().mesh(Length::mm(1.0));
        let at = |x: f64| block.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [x, 0.0, 0.0]);
        let h = Length::mm(0.4);
        for apart in [5.0, 10.0] {
            let both = at(0.0).joined(&at(apart));
            let (a, r) = (10.0 + apart, 1.0);
            // Steiner for the box that both are.
            let steiner = a * 100.0 + (200.0 + 40.0 * a) * r + PI * (a + 20.0) * r * r + 4.0 / 3.0 * PI * r.powi(3);
            let more = offset(&both, Length::mm(r), h).unwrap();
            inside_bracket(&more, steiner);
            assert!((more.mesh.signed_volume() / steiner - 1.0).abs() < 1e-3, "{}", more.mesh.signed_volume());
            for made in [offset(&both, Length::mm(-r), h), open_by_ball(&both, Length::mm(r), h)] {
                match made {
                    Err(Error::NotSolid { at_mm: Some(p), .. }) => {
                        assert!([5.0, apart - 5.0].iter().any(|x| (p[0] - x).abs() < 1e-6), "{p:?}");
                    }
                    other => panic!("not refused: {:?}", other.map(|s| s.volume)),
                }
            }
            let united = offset(&both, Length::mm(0.0), h).unwrap();
            let less = offset(&united.mesh, Length::mm(-r), h).unwrap();
            let truth = (a - 2.0) * 64.0;
            inside_bracket(&less, truth);
            println!("united, shrunk: {} of {truth}", less.mesh.signed_volume());
            assert!((less.mesh.signed_volume() / truth - 1.0).abs() < 5e-3, "{}", less.mesh.signed_volume());
        }
    }

    #[test]
    fn narrow_grooves_are_no_buried_facets() {
        // A block with a slit far thinner than the spacing, and a groove of two degrees.
        let ring = |profile: &[[f64; 2]]| {
            let (n, mut facets) = (profile.len(), Vec::new());
            let p = |i: usize, z: f64| [profile[i % n][0], profile[i % n][1], z];
            for i in 0..n {
                facets.extend([[p(i, 0.0), p(i + 1, 0.0), p(i + 1, 8.0)], [p(i, 0.0), p(i + 1, 8.0), p(i, 8.0)]]);
            }
            // The profile is a fan about its first corner, which sees all others.
            for i in 1..n - 1 {
                facets.extend([[p(0, 0.0), p(i + 1, 0.0), p(i, 0.0)], [p(0, 8.0), p(i, 8.0), p(i + 1, 8.0)]]);
            }
            TriangleMesh::weld(facets)
        };
        let h = Length::mm(0.5);
        for mouth in [0.02, 0.3] {
            let half = [[10.0, 0.0], [20.0, 0.0], [20.0, 12.0], [10.0 + 0.5 * mouth, 12.0], [10.0, 4.0]];
            let other = half.map(|[x, y]| [20.0 - x, y]);
            let profile: Vec<[f64; 2]> = half.iter().copied().chain(other[1..4].iter().rev().copied()).collect();
            let block = ring(&profile);
            assert!(block.signed_volume() > 0.0);
            offset(&block, Length::mm(-1.0), h).unwrap();
        }
    }

    #[test]
    fn impossible_lengths_are_refused() {
        for r in [f64::NAN, f64::INFINITY, 1e6] {
            assert!(offset(&cube(), Length::mm(r), Length::mm(0.5)).is_err());
        }
        assert!(open_by_ball(&cube(), Length::mm(-1.0), Length::mm(0.5)).is_err());
        assert!(offset(&TriangleMesh::default(), Length::mm(1.0), Length::mm(0.5)).is_err());
    }

    #[test]
    fn a_ball_fills_the_share_of_its_cube_that_is_said() {
        for r in [0.3, 0.5, 0.6, 0.7] {
            let n = 200;
            let at = |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
            let count = (0..n * n * n).filter(|v| {
                let [x, y, z] = [v % n, v / n % n, v / (n * n)].map(at);
                x * x + y * y + z * z <= r * r
            });
            let share = count.count() as f64 / (n as f64).powi(3);
            assert!((share - ball_in_cube(r)).abs() < 2e-3, "{r}: {share} {}", ball_in_cube(r));
        }
        assert!(ball_in_cube(0.8) < 1.0 && ball_in_cube(0.87) == 1.0);
    }
}
