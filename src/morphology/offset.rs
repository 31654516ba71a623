//! Offsets of meshes by a signed length, and the openings and closings made of them, from exact distances.

use crate::distance::squared_distance;
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::geometry::contour::{Edge, linear_crossing, surface};
use crate::geometry::refine::split_curved_edges;
use crate::geometry::vector::{Vec3, along, distance, sub};
use crate::geometry::{InsideRule, MeshDistance, TriangleMesh, voxelize};
use crate::grid::Grid;
use crate::units::{Length, Volume};
use rayon::prelude::*;

/// Half the diagonal of a unit cube, with a hair for rounding.
const HALF_DIAGONAL: f64 = 0.866_025_403_785;

/// A shape made from a mesh: its surface, and the two numbers that its volume lies between.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaped {
    /// The surface: closed, manifold, vertices on the level set; empty where nothing remains.
    pub mesh: TriangleMesh,
    /// Certified bounds on the volume of the exact result.
    pub volume: [Volume; 2],
}

/// The offset of a solid by a signed length: `{ x : d(x) ≤ by }` with d the signed distance, negative inside.
///
/// Outwards it is the sum with a ball, inwards the difference. Distances are exact, to the facets; the surface's
/// vertices lie on the level, curved facets are inscribed, none deeper than a hundredth of the spacing as far as
/// normals tell.
///
/// # Errors
/// [`Error::Operand`] for a length that is not finite or more than a thousand spacings, [`Error::NoGeometry`] for a mesh
/// without facets, otherwise as [`voxelize()`].
///
/// # Cost
/// One cast and one distance transform of the grid; four distances to the mesh for each sample near the new surface.
pub fn offset(mesh: &TriangleMesh, by: Length, spacing: Length) -> Result<Shaped> {
    Ok(offset_field(mesh, by, spacing)?.shaped(by)?.0)
}

/// The opening of a solid by a ball: everything that a ball of the radius, moved about inside, covers.
///
/// # Errors
/// As [`offset`]; a radius must not be negative.
///
/// # Cost
/// Two offsets, the second of the surface of the first.
pub fn open_by_ball(mesh: &TriangleMesh, radius: Length, spacing: Length) -> Result<Shaped> {
    twice(mesh, -check_radius(radius)?, spacing)
}

/// The closing of a solid by a ball: everything that a ball of the radius, moved about outside, cannot reach.
///
/// # Errors
/// As [`open_by_ball`].
pub fn close_by_ball(mesh: &TriangleMesh, radius: Length, spacing: Length) -> Result<Shaped> {
    twice(mesh, check_radius(radius)?, spacing)
}

/// Offset there and back. The bracket comes from the first field alone: its level sets at ±ε, dilated by exact
/// transforms.
fn twice(mesh: &TriangleMesh, first: Length, spacing: Length) -> Result<Shaped> {
    let field = offset_field(mesh, first, spacing)?;
    let volume = field.bracket_of_return(first)?;
    let (between, _) = field.shaped(first)?;
    if between.mesh.triangles.is_empty() {
        return Ok(Shaped { mesh: TriangleMesh::default(), volume });
    }
    let back = offset(&between.mesh, -first, spacing)?;
    Ok(Shaped { mesh: back.mesh, volume })
}

/// `s(x) = d(x) − by` on a grid: exact within 1.9 spacings of zero, of the right sign everywhere.
struct OffsetField {
    values: Field<f32>,
    exact: MeshDistance,
    /// Volumes of the cubes wholly inside the part, and of those touched.
    part: [Volume; 2],
}

fn offset_field(mesh: &TriangleMesh, by: Length, spacing: Length) -> Result<OffsetField> {
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
    let grid = Grid::covering(lo.map(|x| x - reach), hi.map(|x| x + reach), spacing, 2, [0.0; 3])?;
    let solid = voxelize(mesh, &grid, InsideRule::Crossings)?;
    let shell = solid.outer.difference(&solid.inner)?;
    let coarse = squared_distance(&shell)?;
    let exact = MeshDistance::new(mesh);
    let mut values = vec![0f32; grid.samples()];
    let [nx, ny, _] = grid.dims();
    values.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
        for (i, value) in out.iter_mut().enumerate() {
            let index = [i, row % ny, row / ny];
            let sign = if solid.centres.contains(index) { -1.0 } else { 1.0 };
            // The shell's cubes touch the surface, so the nearest one is no further off than half a diagonal tells.
            let about = h * f64::from(coarse.values()[row * nx + i]).sqrt();
            let near = (sign * about - r).abs() <= 1.9 * h;
            let within = about + HALF_DIAGONAL * h;
            let found = if near { exact.nearest(grid.position(index), within) } else { None };
            *value = (sign * found.map_or(about, |n| n.distance) - r) as f32;
        }
    });
    let part = [solid.inner.volume(), solid.outer.volume()];
    Ok(OffsetField { values: Field::from_values(grid, values, f32::MAX)?, exact, part })
}

impl OffsetField {
    /// The surface of `{ s ≤ 0 }` with the bracket of its volume, and the set of its samples.
    fn shaped(&self, by: Length) -> Result<(Shaped, Indicator)> {
        let (grid, r) = (*self.values.grid(), by.as_mm());
        let inside = Indicator::from_predicate(grid, |at| self.values.values()[at] <= 0.0);
        let mesh = surface(&inside, |edge| self.crossing(edge, r))?;
        let mesh = split_curved_edges(&mesh, 0.01 * grid.h(), |p| self.on_level(p, r));
        Ok((Shaped { mesh, volume: self.bracket() }, inside))
    }

    /// Where `s` vanishes along an edge: linear, then one step of regula falsi with the exact distance there.
    fn crossing(&self, edge: Edge, r: f64) -> f64 {
        let grid = self.values.grid();
        let mut next = edge.from;
        next[edge.axis] += 1;
        let (a, b) = (f64::from(self.values.at(edge.from)), f64::from(self.values.at(next)));
        let t = linear_crossing(&self.values, edge, 0.0);
        if r.abs() <= 1.5 * grid.h() || !(0.0..=1.0).contains(&t) {
            return t; // too near to the surface for its side to be known between samples
        }
        let p = [0, 1, 2].map(|i| {
            let step = if i == edge.axis { t } else { 0.0 };
            grid.origin()[i] + grid.h() * (edge.from[i] as f64 + step)
        });
        let Some(nearest) = self.exact.nearest(p, r.abs() + 2.0 * grid.h()) else { return t };
        let s = r.signum() * nearest.distance - r;
        if s == 0.0 {
            t
        } else if (s > 0.0) == (a > 0.0) {
            t + (1.0 - t) * s / (s - b)
        } else {
            t * a / (a - s)
        }
    }

    /// The point at distance |r| from the mesh on the line from the nearest mesh point through p, if p is near it.
    fn on_level(&self, p: Vec3, r: f64) -> Vec3 {
        let h = self.values.grid().h();
        match self.exact.nearest(p, r.abs() + 2.0 * h) {
            Some(n) if n.distance > 0.5 * h && (n.distance - r.abs()).abs() < 0.25 * h => {
                along(n.point, sub(p, n.point), r.abs() / distance(p, n.point))
            }
            _ => p,
        }
    }

    /// Bounds on the volume of `{ s ≤ 0 }`: s changes by at most a millimetre per millimetre, so a ball of radius |s|
    /// about a sample lies on the sample's side.
    fn bracket(&self) -> [Volume; 2] {
        let grid = self.values.grid();
        let (h, plane) = (grid.h(), grid.dims()[0] * grid.dims()[1]);
        let of_plane = |values: &[f32]| {
            values.iter().fold([0.0, 0.0], |[low, high], &s| {
                let share = ball_in_cube((f64::from(s.abs()) / h - 1e-6).max(0.0));
                if s <= 0.0 { [low + share, high + 1.0] } else { [low, high + 1.0 - share] }
            })
        };
        let planes: Vec<[f64; 2]> = self.values.values().par_chunks(plane).map(of_plane).collect();
        [0, 1].map(|side| grid.sample_volume() * planes.iter().map(|p| p[side]).sum::<f64>())
    }

    /// Bounds on the volume after the way back, an offset of this body by `−by`.
    ///
    /// A point x is in the opening by ρ iff some y with d(y) ≤ −ρ is no further than ρ. Sample y with s(y) ≤ 0 is such a
    /// point, so cubes within ρ − ε of it lie inside; and each such point lies in the cube of a sample with s ≤ ε, so
    /// the opening lies in cubes within ρ + 2ε of those. The closing is the same for the complement.
    fn bracket_of_return(&self, by: Length) -> Result<[Volume; 2]> {
        let grid = self.values.grid();
        let (rho, slack) = (by.as_mm().abs() / grid.h(), HALF_DIAGONAL);
        let outward = if by.as_mm() > 0.0 { -1.0 } else { 1.0 };
        let at_most = |level: f64| {
            let level = (level * grid.h()) as f32;
            Indicator::from_predicate(*grid, |at| outward as f32 * self.values.values()[at] <= level)
        };
        let covered = |set: &Indicator, reach: f64| -> Result<f64> {
            if reach < 0.0 || set.is_empty() {
                return Ok(0.0);
            }
            let near = (reach * reach).floor();
            let d2 = squared_distance(set)?;
            Ok(d2.values().par_iter().filter(|&&d| f64::from(d) <= near).count() as f64)
        };
        let low = covered(&at_most(-1e-6), rho - slack)?;
        let high = covered(&at_most(slack + 1e-6), rho + 2.0 * slack)?;
        let cubes = if outward > 0.0 { [low, high] } else { [high, low].map(|n| grid.samples() as f64 - n) };
        let [low, high] = cubes.map(|n| grid.sample_volume() * n);
        // An opening lies in the part, a closing holds it.
        let [least, most] = self.part;
        Ok(if outward > 0.0 { [low, high.min(most)] } else { [low.max(least), high] })
    }
}

/// The volume of the part of a ball that lies in the unit cube about its centre, for radii up to where it no longer
/// grows simply: a lower bound above √½.
fn ball_in_cube(radius: f64) -> f64 {
    if radius >= HALF_DIAGONAL {
        return 1.0;
    }
    let r = radius.min(std::f64::consts::FRAC_1_SQRT_2);
    let ball = 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    let height = (r - 0.5).max(0.0);
    let cap = std::f64::consts::PI * height * height * (3.0 * r - height) / 3.0;
    ball - 6.0 * cap
}

fn check_radius(radius: Length) -> Result<Length> {
    if radius.as_mm() >= 0.0 && radius.as_mm().is_finite() {
        return Ok(radius);
    }
    Err(Error::Operand {
        operation: "opening or closing",
        problem: format!("a radius of {} mm", radius.as_mm()),
        remedy: "give a finite radius, not below zero".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
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
    fn shrinking_a_cube_keeps_its_corners() {
        let shape = offset(&cube(), Length::mm(-3.0), Length::mm(0.5)).unwrap();
        inside_bracket(&shape, 14f64.powi(3));
        // Edges are cut by the cells they pass: a strip of h²/2 at most along 12 edges of 14 mm.
        assert!((shape.mesh.signed_volume() - 14f64.powi(3)).abs() < 12.0 * 14.0 * 0.125);
        assert!(offset(&cube(), Length::mm(-11.0), Length::mm(0.5)).unwrap().mesh.triangles.is_empty());
    }

    #[test]
    fn small_offsets_and_none_are_right_too() {
        for r in [0.0, 0.1, -0.1, 0.4] {
            let shape = offset(&cube(), Length::mm(r), Length::mm(0.4)).unwrap();
            let want = if r > 0.0 { grown(20.0, r) } else { (20.0 + 2.0 * r).powi(3) };
            inside_bracket(&shape, want);
            // Sharp or nearly sharp edges: 12·20 mm of them, each cut by at most h²/2.
            assert!((shape.mesh.signed_volume() - want).abs() < 240.0 * 0.08, "{r}: {}", shape.mesh.signed_volume());
        }
    }

    #[test]
    fn opening_rounds_convex_edges_and_closing_leaves_a_convex_part_alone() {
        let r = 2.0;
        let open = open_by_ball(&cube(), Length::mm(r), Length::mm(0.4)).unwrap();
        let rounded = grown(20.0 - 2.0 * r, r);
        inside_bracket(&open, rounded);
        assert!((open.mesh.signed_volume() / rounded - 1.0).abs() < 5e-3, "{}", open.mesh.signed_volume());
        let closed = close_by_ball(&cube(), Length::mm(r), Length::mm(0.4)).unwrap();
        inside_bracket(&closed, 8000.0);
        assert!((closed.mesh.signed_volume() / 8000.0 - 1.0).abs() < 5e-3, "{}", closed.mesh.signed_volume());
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
