//! Openings and closings of meshes by a ball, from exact distances.

use super::bodies::{Bodies, Facets};
use super::level::Level;
use super::near::{EXACT, Near};
use super::offset::{HALF_DIAGONAL, Measured, Shaped, ball_in_cube};
use super::places::{Places, TOO_MANY_LOOKS};
use super::traced::Traced;
use super::walls::{Distances, REACH_IN, Walls};
use super::within::{Side, drawn_back};
use crate::distance::squared_distance;
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::geometry::vector::Vec3;
use crate::geometry::{MeshDistance, TriangleMesh};
use crate::units::{Length, Volume};
use rayon::prelude::*;

/// The opening of a solid by a ball: everything that a ball of the radius, moved about inside, covers.
///
/// Where the ball touches the part the surface is the part's own, exactly, and of what is thinner than the spacing some may be left out, along
/// rims and at corners; elsewhere it is at the radius from the surface of what the ball's centre reaches, or from its nearest place among the facets that stop it. A
/// wall as thick as the ball is wide stays, by 0.01 spacings. Where walls are thinner than the spacing, facets of both their sides
/// may cross.
///
/// # Errors
/// As [`super::offset()`]; a radius must not be negative.
///
/// # Cost
/// An offset, the ball's contacts (two distances to the part for each sample near it), and where it does not touch an
/// offset of the first one's surface.
pub fn open_by_ball(mesh: &TriangleMesh, radius: Length, spacing: Length) -> Result<Shaped> {
    roll(mesh, -check_radius(radius)?, spacing)
}

/// The closing of a solid by a ball: everything that a ball of the radius, moved about outside, cannot reach.
///
/// # Errors
/// As [`open_by_ball`].
pub fn close_by_ball(mesh: &TriangleMesh, radius: Length, spacing: Length) -> Result<Shaped> {
    roll(mesh, check_radius(radius)?, spacing)
}

/// Offset there and back.
fn roll(mesh: &TriangleMesh, there: Length, spacing: Length) -> Result<Shaped> {
    let Measured { of, sides, shell2 } = {
        let mut part = Measured::around(mesh, there, spacing)?;
        if there.as_mm() < 0.0 {
            part.refuse_buried_facets(mesh)?;
        } else {
            part.of.bodies = Bodies::overlapping(mesh, spacing);
        }
        part
    };
    let (values, near) = Near::of(of, &sides.centres, &shell2, there.as_mm(), None)?;
    let covered = Covered::of(&values, there, near.mesh(), &sides.centres)?;
    let (between, of) = reached(values, near, there)?;
    let (distances, walls) = Walls::of(of, &sides.centres, &shell2, there, &covered)?;
    drop(shell2);
    let volume = covered.bracket(&distances, &walls, there);
    let traced = back(&between, (distances, walls, &covered), there)?;
    let mut surface = traced.surface()?;
    if let Some(walls) = &traced.walls {
        let side = if there.as_mm() < 0.0 { Side::Within } else { Side::Outside };
        drawn_back(&mut surface, mesh, walls.level().near.mesh(), spacing.as_mm(), side);
    }
    Ok(Shaped { mesh: surface, volume, field: traced.values })
}

/// The surface of what the ball's centre reaches, from the offset field there; and the distances to the part.
fn reached(values: Field<f32>, near: Near, there: Length) -> Result<(TriangleMesh, Facets)> {
    let traced = Traced { values, level: Some(Level { near, r: there.as_mm() }), walls: None };
    let surface = traced.between()?;
    let level = traced.level.ok_or_else(|| Error::Internal { problem: "an offset without its level".into() })?;
    Ok((surface, level.near.into_facets()))
}

/// The field on the way back: distances to walls where the ball touches them, elsewhere to the surface of what its centre
/// reaches.
fn back(
    between: &TriangleMesh,
    (distances, mut walls, covered): (Distances, Walls, &Covered),
    there: Length,
) -> Result<Traced> {
    let grid = *distances.grid();
    let (mut values, level) = if between.triangles.is_empty() {
        // Its centre reaches nothing (or everything) by these samples: the ball covers no sample but at walls.
        let far = 2.0 * grid.h() as f32;
        let values = vec![far.copysign(-there.as_mm() as f32); grid.samples()];
        (Field::from_values(grid, values, f32::MAX)?, None)
    } else {
        let body = Measured::on(between, &grid)?;
        let r = -there.as_mm();
        let (values, near) = Near::of(body.of, &body.sides.centres, &body.shell2, r, Some(walls.held()))?;
        (values, Some(Level { near, r }))
    };
    let words = walls.held().words_per_row();
    let rows = values.values_mut().par_chunks_mut(grid.dims()[0]).zip(distances.values().par_chunks(grid.dims()[0]));
    rows.zip(walls.held().words().par_chunks(words)).for_each(|((values, distances), bits)| {
        for (i, (value, &distance)) in values.iter_mut().zip(distances).enumerate() {
            if bits[i / 64] >> (i % 64) & 1 == 1 {
                *value = distance;
            }
        }
    });
    walls.press(&mut values, &distances, covered);
    Ok(Traced { values, level, walls: Some(walls) })
}

/// What balls cover whose centres are samples: for an opening cubes of the part, for a closing cubes of its complement.
pub(super) struct Covered {
    /// Cubes that balls surely cover.
    pub surely: Indicator,
    /// Cubes that they possibly touch.
    possibly: Indicator,
    /// Samples to whose values within a spacing of zero a ball may matter, also one that facets reach into by [`REACH_IN`].
    pub reached: Indicator,
    /// Those that a place between samples covers by [`EXACT`] spacings and more.
    pub deep: Indicator,
    /// Samples whose exact places are not sought, for that would take too long: those that `known` places are near, which stand for them.
    pub crowded: Indicator,
    pub known: Vec<Vec3>,
    /// Whether no exact places are sought at all.
    pub unsought: bool,
}

impl Covered {
    /// From the offset field `s` there: where `s ≤ 0` for an opening, `s ≥ 0` for a closing, a ball's centre may stand.
    ///
    /// A point x is in the opening by ρ iff some y with d(y) ≤ −ρ is no further than ρ. Sample y with s(y) ≤ 0 is such a
    /// point, so cubes within ρ − ε of it lie inside, and its own cube if s(y) ≤ −ε; and each such point lies in the cube of
    /// a sample with s ≤ ε, so the opening lies in cubes within ρ + 2ε of those. The closing is the same for the complement.
    ///
    /// A place that is found in the cube of a sample is no farther from it than ε.
    fn of(s: &Field<f32>, there: Length, mesh: &MeshDistance, centres: &Indicator) -> Result<Self> {
        let grid = *s.grid();
        let (rho, slack) = (there.as_mm().abs() / grid.h(), HALF_DIAGONAL);
        let outward = if there.as_mm() > 0.0 { -1.0 } else { 1.0 };
        let at_most = |level: f64| {
            let level = (level * grid.h()) as f32;
            Indicator::from_predicate(grid, |at| outward * s.values()[at] <= level)
        };
        let stands = at_most(-1e-6);
        let places = Places::of(at_most(slack + REACH_IN + 1e-6), &stands, (mesh, centres), there.as_mm())?;
        let reached = about(&places.possible, rho + slack + EXACT)?;
        let surely = about(&stands, rho - slack)?.union(&at_most(-slack - 1e-6))?;
        let mut covered = Covered {
            surely: surely.union(&about(&places.certain, rho - 2.0 * slack)?)?,
            possibly: about(&at_most(slack + 1e-6), rho + 2.0 * slack)?,
            deep: about(&places.beside, rho - slack - EXACT)?,
            reached,
            crowded: Indicator::empty(grid),
            known: Vec::new(),
            unsought: false,
        };
        let looks = places.looks(mesh, covered.reached.difference(&covered.surely)?.count());
        covered.unsought = looks > TOO_MANY_LOOKS;
        if places.stand_for_others(looks) {
            (covered.crowded, covered.known) = (about(&places.beside, rho + slack + EXACT)?, places.between);
        }
        Ok(covered)
    }

    /// Bounds on the volume of the result.
    ///
    /// A ball of radius |d| about a sample lies on the sample's side of the part. On the ball's side it is covered where the
    /// sample was measured to a wall and no facet reaches into the ball: it touches the wall at the same point, from inside
    /// the ball that rolls there, or is larger than that.
    fn bracket(&self, distances: &Distances, walls: &Walls, there: Length) -> [Volume; 2] {
        let grid = *distances.grid();
        let ([nx, ny, nz], h) = (grid.dims(), grid.h());
        let rolls_inside = there.as_mm() < 0.0;
        let of_row = |row: usize| {
            let (j, k) = (row % ny, row / ny);
            (0..nx).fold([0.0, 0.0], |[low, high], i| {
                let d = f64::from(distances.values()[row * nx + i]);
                let balls_side = (d < 0.0) == rolls_inside;
                let clear = balls_side && walls.clear().contains([i, j, k]);
                let within = if clear { ball_in_cube(d.abs() / h) } else { 0.0 };
                let beyond = if balls_side { 0.0 } else { ball_in_cube(d.abs() / h) };
                let surely = if self.surely.contains([i, j, k]) { 1.0 } else { within };
                let possibly = if self.possibly.contains([i, j, k]) || clear { 1.0 - beyond } else { 0.0 };
                [low + surely, high + possibly.max(surely)]
            })
        };
        let rows: Vec<[f64; 2]> = (0..ny * nz).into_par_iter().map(of_row).collect();
        let [low, high] = [0, 1].map(|side| rows.iter().map(|row| row[side]).sum::<f64>());
        // A closing is what is left.
        let all = grid.samples() as f64;
        let cubes = if rolls_inside { [low, high] } else { [all - high, all - low] };
        cubes.map(|n| grid.sample_volume() * n)
    }
}

/// The samples no farther from those of a set than so many spacings.
fn about(set: &Indicator, reach: f64) -> Result<Indicator> {
    if reach < 0.0 || set.is_empty() {
        return Ok(Indicator::empty(*set.grid()));
    }
    let near = (reach * reach).floor();
    let d2 = squared_distance(set)?;
    Ok(Indicator::from_predicate(*set.grid(), |at| f64::from(d2.values()[at]) <= near))
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
    use super::super::walls::REACH_IN;
    use super::*;
    use crate::geometry::generate::extruded;
    use crate::geometry::vector::Vec3;
    use crate::geometry::{MeshDistance, Primitive, Winding, cuboid};
    use crate::random::Lcg;
    use std::f64::consts::PI;

    /// Steiner's volume of a box grown by r.
    fn steiner([a, b, c]: [f64; 3], r: f64) -> f64 {
        a * b * c + 2.0 * (a * b + b * c + c * a) * r + PI * (a + b + c) * r * r + 4.0 / 3.0 * PI * r * r * r
    }

    fn inside_bracket(shape: &Shaped, volume: f64) {
        let [low, high] = shape.volume.map(|v| v.as_mm3());
        assert!(low <= volume && volume <= high, "{volume} not in {low} … {high}");
    }

    #[test]
    fn opening_rounds_convex_edges_and_closing_leaves_a_convex_part_alone() {
        let r = 2.0;
        let cube = Primitive::parse("box:20x20x20mm").unwrap().mesh(Length::mm(1.0));
        let open = open_by_ball(&cube, Length::mm(r), Length::mm(0.4)).unwrap();
        let rounded = steiner([20.0 - 2.0 * r; 3], r);
        inside_bracket(&open, rounded);
        println!("cube opened by 2 mm: {} of {rounded}", open.mesh.signed_volume());
        assert!((open.mesh.signed_volume() / rounded - 1.0).abs() < 1e-3, "{}", open.mesh.signed_volume());
        let closed = close_by_ball(&cube, Length::mm(r), Length::mm(0.4)).unwrap();
        inside_bracket(&closed, 8000.0);
        println!("cube closed by 2 mm: {} of 8000", closed.mesh.signed_volume());
        assert!((closed.mesh.signed_volume() / 8000.0 - 1.0).abs() < 1e-3, "{}", closed.mesh.signed_volume());
    }

    #[test]
    fn a_plate_whose_middle_is_thinner_than_the_samples_is_opened_to_what_it_is() {
        let (sides, r) = ([12.0, 8.0, 1.2], 0.5);
        let plate = Primitive::parse("box:12x8x1.2mm").unwrap().mesh(Length::mm(1.0));
        let truth = steiner(sides.map(|s: f64| s - 2.0 * r), r);
        for h in [0.6, 0.45, 0.3, 0.17] {
            let open = open_by_ball(&plate, Length::mm(r), Length::mm(h)).unwrap();
            inside_bracket(&open, truth);
            let missing = truth - open.mesh.signed_volume();
            println!("plate at {h}: {missing:.3} of {truth:.3} missing, {:?}", open.volume);
            // Rims are rounded where two or three samples lie across the ball: chords of a quarter circle.
            assert!(missing.abs() < 40.0 * 0.25 * h * h, "{missing}");
        }
    }

    #[test]
    fn an_opening_lies_in_the_part_and_a_closing_holds_it_however_thin_it_is() {
        let mut random = Lcg(8);
        // A plate of 0.4 mm with a rib of 0.4 mm.
        let profile = [[0.0, 0.0], [9.0, 0.0], [9.0, 0.4], [4.4, 0.4], [4.4, 3.0], [4.0, 3.0], [4.0, 0.4], [0.0, 0.4]];
        let plate = extruded(&profile, &[[0, 6, 7], [0, 1, 6], [1, 3, 6], [1, 2, 3], [3, 4, 5], [3, 5, 6]], 7.0);
        for _ in 0..6 {
            let part = plate.transformed(random.rotation(), random.point(-2.0, 2.0));
            let (exact, winding, h) = (MeshDistance::new(&part), Winding::new(&part), 0.5);
            let off_side = |made: TriangleMesh, inside: bool| {
                assert!(!made.triangles.is_empty());
                let wrong = made.vertices.iter().filter(|&&p| (winding.at(p) > 0.5) == inside);
                wrong.map(|&p| exact.nearest(p, f64::INFINITY).unwrap().distance).fold(0.0, f64::max)
            };
            let open = off_side(open_by_ball(&part, Length::mm(0.15), Length::mm(h)).unwrap().mesh, false);
            let closed = off_side(close_by_ball(&part, Length::mm(0.15), Length::mm(h)).unwrap().mesh, true);
            assert!(open < 0.01 * h && closed < 0.01 * h, "{open} {closed}");
        }
    }

    #[test]
    fn a_slot_in_which_the_ball_just_fits_stays_open() {
        // Two blocks 1.2 mm apart on a base, joined as one profile.
        let profile = [[0.0, 0.0], [9.2, 0.0], [9.2, 6.0], [5.2, 6.0], [5.2, 2.0], [4.0, 2.0], [4.0, 6.0], [0.0, 6.0]];
        let r = 0.5;
        let caps = [[1, 2, 3], [1, 3, 4], [0, 5, 6], [0, 6, 7], [0, 1, 4], [0, 4, 5]];
        let part = extruded(&profile, &caps, 10.0);
        let truth: f64 = 10.0 * (9.2 * 6.0 - 1.2 * 4.0 + 2.0 * r * r * (1.0 - PI / 4.0));
        for h in [0.6, 0.45, 0.3, 0.17] {
            let closed = close_by_ball(&part, Length::mm(r), Length::mm(h)).unwrap();
            inside_bracket(&closed, truth);
            let filled = closed.mesh.signed_volume() - truth;
            println!("slot at {h}: {filled:.3} mm³ too much, {:?}", closed.volume);
            // Two grooves of 10 mm, and 34 mm of mouth that is left sharp.
            assert!(filled.abs() < 44.0 * 0.25 * h * h, "{filled}");
        }
    }

    #[test]
    fn a_round_void_is_filled_by_a_ball_that_does_not_fit_into_it() {
        let round = |r: f64| Primitive::Ball { radius: Length::mm(r) }.mesh(Length::mm(0.005));
        let (whole, void) = (round(5.0), round(4.0));
        let hollow = whole.clone().joined(&void.flipped());
        for (r, filled) in [(3.5, false), (4.3, true), (6.0, true), (8.5, true)] {
            let closed = close_by_ball(&hollow, Length::mm(r), Length::mm(0.3)).unwrap();
            let truth = whole.signed_volume() - if filled { 0.0 } else { void.signed_volume() };
            inside_bracket(&closed, truth);
            assert!((closed.mesh.signed_volume() / truth - 1.0).abs() < 0.003, "{r}: {}", closed.mesh.signed_volume());
        }
    }

    #[test]
    fn sharp_wedges_and_grooves_are_opened_and_closed_to_their_ends() {
        let (r, h) = (1.0, 0.2);
        for degrees in [40.0f64, 18.0, 12.0, 8.0] {
            let half = 0.5 * degrees.to_radians();
            let (far, y) = (3.0 / half.sin(), 3.0 / half.cos());
            let wedge = extruded(&[[0.0, 0.0], [far, -y], [far, y]], &[[0, 1, 2]], 6.0);
            let open = open_by_ball(&wedge, Length::mm(r), Length::mm(h)).unwrap();
            let (tip, want) = (open.mesh.bounds().unwrap().0[0], r / half.sin() - r);
            // Facets may reach a little into the ball, which lets it that much farther along the wedge.
            let allowed = (1.5 * REACH_IN / half.sin()).max(0.02) * h;
            assert!((tip - want).abs() < allowed, "{degrees}°: ends at {tip}, not {want}");
            // A groove as sharp; at its two ends the ball comes in from beyond, however long it is.
            let back =
                [[-2.0, -y - 2.0], [far, -y - 2.0], [far, -y], [0.0, 0.0], [far, y], [far, y + 2.0], [-2.0, y + 2.0]];
            let [less, more] = [4.0, 7.0].map(|long| {
                let block = extruded(&back, &[[0, 1, 3], [1, 2, 3], [3, 4, 5], [3, 5, 6], [0, 3, 6]], long);
                let closed = close_by_ball(&block, Length::mm(r), Length::mm(h)).unwrap();
                closed.mesh.signed_volume() - block.signed_volume()
            });
            let (filled, want) = ((more - less) / 3.0, r * r * (1.0 / half.tan() - (0.5 * PI - half)));
            assert!((filled / want - 1.0).abs() < 0.01, "{degrees}°: {filled} mm² filled, not {want}");
        }
    }

    #[test]
    fn a_part_of_another_size_is_opened_alike() {
        let half = 10f64.to_radians();
        let wedge = extruded(&[[0.0, 0.0], [9.0, -9.0 * half.tan()], [9.0, 9.0 * half.tan()]], &[[0, 1, 2]], 5.0);
        let opened = |size: f64| {
            let open = open_by_ball(&wedge.scaled(size), Length::mm(0.7 * size), Length::mm(0.3 * size)).unwrap();
            open.mesh.scaled(1.0 / size)
        };
        // By powers of two nothing is rounded.
        for size in [1024.0, 1.0 / 1024.0] {
            assert!(opened(size) == opened(1.0), "{size}");
        }
    }

    #[test]
    fn an_opening_leaves_concave_edges_as_they_are() {
        // Walls that end a hair before samples, and coordinates that come from f32 as those of files do.
        let face = f64::from(27.6f32);
        let profile = [[0.0, 0.0], [40.0, 0.0], [40.0, 4.0], [face, 4.0], [face, 14.0], [0.0, 14.0]];
        let part = extruded(&profile, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 12.0);
        let exact = MeshDistance::new(&part);
        for h in [0.5, 0.4, 0.3] {
            let open = open_by_ball(&part, Length::mm(0.5), Length::mm(h)).unwrap();
            let beside = |p: &&Vec3| (p[0] - face).abs() < 2.0 && (p[1] - 4.0).abs() < 2.0 && (p[2] - 6.0).abs() < 4.0;
            let off = |p: &Vec3| exact.nearest(*p, f64::INFINITY).unwrap().distance;
            let worst = open.mesh.vertices.iter().filter(beside).map(off).fold(0.0, f64::max);
            println!("a concave edge opened at {h}: vertices {worst} mm off at most");
            // Crossings end within a hundredth of a spacing, vertices of the crease on it.
            assert!(worst < 0.01 * h, "{worst}");
        }
    }

    #[test]
    fn turned_plates_and_blocks_are_opened_to_their_closed_forms() {
        let mut random = Lcg(5);
        for case in 0..60 {
            let r = 0.3 + 0.7 * random.unit();
            let room = [random.unit() * 4.0, 2.0 + random.unit() * 4.0, 2.0 + random.unit() * 4.0].map(|x| x + 1e-3);
            let room = if case % 2 == 0 { [0.3 * random.unit() * r + 1e-3, room[1], room[2]] } else { room };
            let sides = room.map(|x| 0.5 * x + r);
            let part = cuboid(sides.map(|x| -x), sides).transformed(random.rotation(), [0.0; 3]);
            let h = r * (0.3 + 0.7 * random.unit());
            let open = open_by_ball(&part, Length::mm(r), Length::mm(h)).unwrap();
            let (truth, perimeter) = (steiner(room, r), 4.0 * room.iter().sum::<f64>());
            inside_bracket(&open, truth);
            // Rims are chords of quarter circles on cells of the spacing: sagittas of h²/8r, twice for the cells' diagonals,
            // and the facets that may reach into the ball.
            let off = (open.mesh.signed_volume() - truth).abs();
            let rims = (perimeter + 8.0 * r) * 1.6 * r * (h * h / (4.0 * r) + 0.01 * h);
            assert!(off < rims, "case {case}: r {r}, h {h}, {room:?}: off by {off} of {truth}, allowed {rims}");
        }
    }
}
