//! Offsets of meshes by a signed length, and the openings and closings made of them, from exact distances.

use super::buried::refuse_buried_facets;
use super::near::{Near, squared_distance_to_shell};
use crate::distance::squared_distance;
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::geometry::contour::{Edge, linear_crossing, sharp_surface};
use crate::geometry::distance::Nearest;
use crate::geometry::refine::split_curved_edges;
use crate::geometry::vector::{Vec3, add, along, distance, dot, scale, sub, unit};
use crate::geometry::{InsideRule, MeshDistance, TriangleMesh, enclose};
use crate::grid::Grid;
use crate::units::{Length, Volume};
use rayon::prelude::*;

/// Half the diagonal of a unit cube, with a hair for rounding.
const HALF_DIAGONAL: f64 = 0.866_025_403_785;

/// Where the lattice stands about the box, in spacings: faces on round coordinates are neither on samples nor on cubes.
const BETWEEN: [f64; 3] = [0.23, 0.31, 0.27];

/// Normals closer together than 25° belong to no crease of 30°, wherever on the cell's edges they were taken.
const SMOOTH_COSINE: f64 = 0.906;

/// Slopes along an edge that are this near to the mean one, of at most 1, belong to no crease that matters.
const SMOOTH_SLOPE: f64 = 0.1;

/// A shape made from a mesh: its surface, and the two numbers that its volume lies between.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaped {
    /// The surface: closed, manifold, vertices on the level set; empty where nothing remains.
    pub mesh: TriangleMesh,
    /// Certified bounds on the volume of the exact result.
    pub volume: [Volume; 2],
    /// The function whose zero set the surface is: millimetres, negative inside, exact near the surface.
    pub field: Field<f32>,
}

/// The offset of a solid by a signed length: `{ x : d(x) ≤ by }` with d the signed distance, negative inside.
///
/// Outwards it is the sum with a ball, inwards the difference. Distances are exact, to the facets; the surface's
/// vertices lie on the level, curved facets are inscribed, none deeper than a hundredth of the spacing as far as
/// normals tell.
///
/// # Errors
/// [`Error::Operand`] for a length that is not finite or more than a thousand spacings, [`Error::NoGeometry`] for a mesh
/// without facets, [`Error::NotSolid`] inwards where a facet lies inside the material because bodies overlap or touch;
/// otherwise as [`crate::geometry::voxelize()`].
///
/// # Cost
/// One cast and one distance transform of the grid; four distances to the mesh for each sample near the new surface.
pub fn offset(mesh: &TriangleMesh, by: Length, spacing: Length) -> Result<Shaped> {
    offset_of(mesh, by, spacing, Facets::Given)
}

fn offset_of(mesh: &TriangleMesh, by: Length, spacing: Length, facets: Facets) -> Result<Shaped> {
    let field = offset_field(mesh, by, spacing, facets)?;
    let (mesh, volume) = (field.surface(by)?, field.bracket());
    Ok(Shaped { mesh, volume, field: field.values })
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
    let field = offset_field(mesh, first, spacing, Facets::Given)?;
    let volume = field.bracket_of_return(first)?;
    let between = field.surface(first)?;
    if between.triangles.is_empty() {
        return Ok(Shaped { mesh: between, volume, field: field.values });
    }
    Ok(Shaped { volume, ..offset_of(&between, -first, spacing, Facets::Contour)? })
}

/// Where the facets of a part come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Facets {
    /// From outside: some may lie inside the material.
    Given,
    /// From a contour of our own: where crevices are finer than the spacing its facets may cross by part of a cell, which
    /// moves the result by no more.
    Contour,
}

/// `s(x) = d(x) − by` on a grid: exact within a spacing of zero; elsewhere farther from it and of the right sign.
struct OffsetField {
    values: Field<f32>,
    near: Near,
    /// Volumes of the cubes wholly inside the part, and of those touched.
    part: [Volume; 2],
}

fn offset_field(mesh: &TriangleMesh, by: Length, spacing: Length, facets: Facets) -> Result<OffsetField> {
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
    let grid = Grid::covering(lo.map(|x| x - reach), hi.map(|x| x + reach), spacing, 2, BETWEEN)?;
    let sides = enclose(mesh, &grid, InsideRule::Crossings)?;
    let shell2 = squared_distance_to_shell(&sides)?;
    let exact = MeshDistance::new(mesh);
    if r < 0.0 && facets == Facets::Given {
        refuse_buried_facets(mesh, &exact, &sides.centres, &shell2)?;
    }
    let (values, near) = Near::of(exact, &sides.centres, &shell2, r)?;
    Ok(OffsetField { values, near, part: [sides.inner.volume(), sides.outer.volume()] })
}

impl OffsetField {
    /// The surface of `{ s ≤ 0 }`.
    fn surface(&self, by: Length) -> Result<TriangleMesh> {
        let (grid, r) = (*self.values.grid(), by.as_mm());
        let inside = Indicator::from_predicate(grid, |at| self.values.values()[at] <= 0.0);
        let normals = |_, corners: &[Vec3], seen: &[Option<Vec3>]| self.normals(corners, seen, r);
        let mesh = sharp_surface(&inside, |edge| self.crossing(edge, r), normals)?;
        Ok(split_curved_edges(&mesh, 0.01 * grid.h(), |p| self.on_level(p, r)))
    }

    /// Where `s` vanishes along an edge, and the level's normal if it was taken near there: the root of the cubic through
    /// the exact values and slopes at both ends; where these tell of a crease, by the distance at the linear crossing.
    fn crossing(&self, edge: Edge, r: f64) -> (f64, Option<Vec3>) {
        let grid = self.values.grid();
        let mut next = edge.from;
        next[edge.axis] += 1;
        let (a, b) = (f64::from(self.values.at(edge.from)), f64::from(self.values.at(next)));
        let t = linear_crossing(&self.values, edge, 0.0);
        if !(0.0..=1.0).contains(&t) {
            return (t, None);
        }
        let slopes = (self.near.slope(edge.from, a + r), self.near.slope(next, b + r));
        if let (Some(m), Some(n)) = slopes {
            let ends = [m, n].map(|slope| grid.h() * slope[edge.axis]);
            if ends.iter().all(|slope| (slope - (b - a)).abs() < SMOOTH_SLOPE * grid.h()) {
                let root = root_of_cubic([a, b], ends, t);
                return (root, Some(unit(add(scale(m, 1.0 - root), scale(n, root)))));
            }
        }
        self.stepped_crossing(edge, t, [a, b], r)
    }

    /// Where `s` vanishes along an edge: one step of Newton's from the linear crossing with the exact distance there,
    /// which ends on a plane; of regula falsi where that leaves the edge.
    fn stepped_crossing(&self, edge: Edge, t: f64, [a, b]: [f64; 2], r: f64) -> (f64, Option<Vec3>) {
        let grid = self.values.grid();
        let p = [0, 1, 2].map(|i| {
            let step = if i == edge.axis { t } else { 0.0 };
            grid.origin()[i] + grid.h() * (edge.from[i] as f64 + step)
        });
        let Some((n, Some((s, slope)))) = self.near.nearest(p).map(|n| (n, self.exactly(p, &n, r))) else {
            return (t, None);
        };
        let newton = t - s / (grid.h() * slope[edge.axis]);
        let found = if s == 0.0 {
            t
        } else if (0.0..=1.0).contains(&newton) && slope[edge.axis] * (b - a) > 0.0 {
            newton
        } else if (s > 0.0) == (a > 0.0) {
            t + (1.0 - t) * s / (s - b)
        } else {
            t * a / (a - s)
        };
        let beside = (found - t).abs() < 0.1;
        (found, beside.then(|| self.normal(p, &n, r)))
    }

    /// `s` at a point near its zero set, with its slope: the side is that of the level, or where the level is too near to
    /// the part's surface, that of the facet the point stands over.
    fn exactly(&self, p: Vec3, n: &Nearest, r: f64) -> Option<(f64, Vec3)> {
        let (off, facing) = (sub(p, n.point), self.near.facing(n));
        let over = dot(off, facing);
        if r.abs() > 1.5 * self.values.grid().h() {
            return Some((r.signum() * n.distance - r, scale(off, r.signum() / n.distance)));
        }
        (over.abs() >= 0.99 * n.distance).then_some((over - r, facing))
    }

    /// Outward normal of the level at a point on it, whose nearest point is given.
    fn normal(&self, p: Vec3, n: &Nearest, r: f64) -> Vec3 {
        let level = r.abs() > 0.05 * self.values.grid().h() && n.distance > 0.5 * r.abs();
        if level { scale(sub(p, n.point), r.signum() / n.distance) } else { self.near.facing(n) }
    }

    /// Outward normals of the level at points on it, unless those seen beside them tell that it is not creased there.
    fn normals(&self, corners: &[Vec3], seen: &[Option<Vec3>], r: f64) -> Option<Vec<Vec3>> {
        let pairs = || (0..corners.len()).flat_map(|i| (0..i).map(move |j| [i, j]));
        let smooth = |[i, j]: [usize; 2]| matches!((seen[i], seen[j]), (Some(m), Some(n)) if dot(m, n) > SMOOTH_COSINE);
        if pairs().all(smooth) {
            return None;
        }
        let normal = |&p: &Vec3| Some(self.normal(p, &self.near.nearest(p)?, r));
        let normals: Vec<Vec3> = corners.iter().map(normal).collect::<Option<_>>()?;
        // Outwards every convex edge is rounded and inwards every concave one: only the other kind is a crease.
        let opening: f64 = pairs().map(|[i, j]| dot(sub(corners[i], corners[j]), sub(normals[i], normals[j]))).sum();
        (opening * r <= 0.0).then_some(normals)
    }

    /// The point at distance |r| from the mesh on the line from the nearest mesh point through p, if p is near it.
    fn on_level(&self, p: Vec3, r: f64) -> Vec3 {
        let h = self.values.grid().h();
        match self.near.nearest(p) {
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

/// The root in [0, 1] of the cubic with given values, of different signs, and slopes at 0 and 1; sought from `t`.
fn root_of_cubic([a, b]: [f64; 2], [m, n]: [f64; 2], mut t: f64) -> f64 {
    let (square, cube) = (3.0 * (b - a) - 2.0 * m - n, 2.0 * (a - b) + m + n);
    for _ in 0..3 {
        let value = a + t * (m + t * (square + t * cube));
        t = (t - value / (m + t * (2.0 * square + t * 3.0 * cube))).clamp(0.0, 1.0);
    }
    t
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
        println!("20 mm cube - 3 mm: {:.6} of 2744", shape.mesh.signed_volume());
        // Creases run along edges; a corner may be off by the margin that a feature keeps from its cell.
        assert!((shape.mesh.signed_volume() / 14f64.powi(3) - 1.0).abs() < 1e-4, "{}", shape.mesh.signed_volume());
        assert!(offset(&cube(), Length::mm(-11.0), Length::mm(0.5)).unwrap().mesh.triangles.is_empty());
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
    fn opening_rounds_convex_edges_and_closing_leaves_a_convex_part_alone() {
        let r = 2.0;
        let open = open_by_ball(&cube(), Length::mm(r), Length::mm(0.4)).unwrap();
        let rounded = grown(20.0 - 2.0 * r, r);
        inside_bracket(&open, rounded);
        println!("cube opened by 2 mm: {} of {rounded}", open.mesh.signed_volume());
        assert!((open.mesh.signed_volume() / rounded - 1.0).abs() < 1e-3, "{}", open.mesh.signed_volume());
        let closed = close_by_ball(&cube(), Length::mm(r), Length::mm(0.4)).unwrap();
        inside_bracket(&closed, 8000.0);
        println!("cube closed by 2 mm: {} of 8000", closed.mesh.signed_volume());
        assert!((closed.mesh.signed_volume() / 8000.0 - 1.0).abs() < 1e-3, "{}", closed.mesh.signed_volume());
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
    fn the_root_of_a_cubic_is_found_from_the_linear_one() {
        // s = √(1 + x²) − c along a line past a ball's centre, and the plain line.
        let (f, slope) = (|x: f64| (1.0 + x * x).sqrt() - 1.1, |x: f64| x / (1.0 + x * x).sqrt());
        let (from, to) = (0.3, 0.6);
        let (a, b) = (f(from), f(to));
        let ends = [from, to].map(|x| (to - from) * slope(x));
        let x = from + (to - from) * root_of_cubic([a, b], ends, a / (a - b));
        assert!(f(x).abs() < 2e-5, "{}", f(x));
        assert_eq!(root_of_cubic([-1.0, 3.0], [4.0, 4.0], 0.25), 0.25);
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
