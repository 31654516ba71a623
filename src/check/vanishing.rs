//! Whole bodies and closed voids that an offset takes away: those in which no ball of its radius has room.

use super::contract::Context;
use super::finding::{Basis, Bracket, Finding, Limits, Spot, Witness};
use super::place::{locate, reported};
use crate::geometry::distance::Nearest;
use crate::geometry::health::Role;
use crate::geometry::vector::{Vec3, scale};
use crate::medial::Side;
use crate::medial::inscribed::{Largest, Place, Region, Until, largest_ball};
use crate::part::Part;
use rayon::prelude::*;

/// Facets of a piece, largest first, from which a ball of the offset's radius is tried before the piece is searched.
const TRIED: usize = 64;
/// Bound and ball that differ by less than this share of the offset are one.
const AGREE: f64 = 0.01;
/// Points that a search may look at.
const MOST: usize = 1 << 14;
/// A place that goes at less than this share of the offset that takes the whole piece is another one.
const SAME: f64 = 1.0 - AGREE;

/// A piece that an offset takes away.
pub(super) struct Vanishing {
    /// Material for a body, void for a closed void.
    pub side: Side,
    /// The body that it is, or lies in, from 0.
    pub body: u32,
    /// The largest ball in it.
    pub ball: Largest,
    pub extent: (Vec3, Vec3),
    shell: u32,
}

/// What was measured.
#[derive(Default)]
pub(super) struct Vanished {
    pub pieces: Vec<Vanishing>,
    /// How many bodies and voids there are, and how many of them are too large for their width to be decided.
    pub all: usize,
    pub open: usize,
}

impl Vanishing {
    /// Whether a finding of the same offset lies in the piece, and speaks for it.
    pub fn is_known(&self, part: &Part, findings: &[Finding]) -> bool {
        let kind = if self.side == Side::Material { "lost" } else { "closed" };
        findings.iter().filter(|f| f.kind == kind).flat_map(|f| &f.places).any(|spot| self.goes_at(part, spot))
    }

    /// Whether a place of a finding on its side lies in the piece, and goes at about the same offset.
    pub fn goes_at(&self, part: &Part, spot: &Spot) -> bool {
        let nearest = || part.distance().nearest(part.to_build(spot.at_mm), f64::INFINITY);
        spot.high >= SAME * self.ball.radius && nearest().is_some_and(|n| self.is_of(part, n.facet))
    }

    /// Whether a facet bounds the piece.
    fn is_of(&self, part: &Part, facet: u32) -> bool {
        let of = |labels: &[u32]| labels.get(facet as usize).copied();
        match self.side {
            Side::Material => of(&part.health().facet_body) == Some(self.body),
            Side::Void => of(&part.health().facet_shell) == Some(self.shell),
        }
    }
}

/// The bodies that shrinking by an offset takes away as a whole, and the closed voids that growing by it fills: those with no ball
/// as large, for certain.
///
/// A point of the material lies in the body whose surface is nearest to it, a point of the void in the closed void whose shell is; so
/// the largest ball of each is sought among balls that really touch it, by [`largest_ball`].
///
/// # Limits
/// Nothing where the surface is open or meets itself. What is as thin over a large area, a sheet or a lattice, is left open: it has
/// places that are found as sheets.
///
/// # Cost
/// A ball for most pieces; up to 16,384 nearest points for each that has no room for one on any of its largest facets.
pub(super) fn vanishing(part: &Part, offset: f64) -> Option<Vanished> {
    if !part.is_plain() {
        return None;
    }
    let health = part.health();
    let shells: Vec<u32> = (0..health.shells.len() as u32).collect();
    let mut facets: Vec<Vec<u32>> = vec![Vec::new(); shells.len()];
    for (f, &shell) in health.facet_shell.iter().enumerate() {
        facets.get_mut(shell as usize).into_iter().for_each(|of| of.push(f as u32));
    }
    let looked_at = |(shell, mut facets): (u32, Vec<u32>)| {
        let of = health.shells.get(shell as usize)?;
        let side = match of.role {
            Role::Body => Side::Material,
            Role::Cavity => Side::Void,
            _ => return None,
        };
        if takes(part, side, &mut facets, offset) {
            return Some(Ok(None));
        }
        let piece = |ball| Vanishing { side, body: of.body, ball, extent: (of.box_mm[0], of.box_mm[1]), shell };
        let until = Until { enough: offset - part.tie(), agree: AGREE * offset, most: MOST };
        let found = largest_ball(part.distance(), Region::between(of.box_mm[0], of.box_mm[1]), until, |p, nearest| {
            place(part, side, shell, (p, nearest))
        });
        let Some(ball) = found else { return Some(Err(())) };
        Some(match (ball.high < offset - part.tie(), ball.radius < offset - part.tie()) {
            (true, _) => Ok(Some(piece(ball))),
            (false, true) => Err(()),
            (false, false) => Ok(None),
        })
    };
    let all: Vec<Result<Option<Vanishing>, ()>> =
        shells.into_par_iter().zip(facets).with_max_len(1).filter_map(looked_at).collect();
    let (count, open) = (all.len(), all.iter().filter(|found| found.is_err()).count());
    Some(Vanished { pieces: all.into_iter().flatten().flatten().collect(), all: count, open })
}

/// The finding of a piece that an offset takes away.
pub(super) fn vanishing_finding(
    (part, context): (&Part, &Context),
    code: &str,
    piece: &Vanishing,
    limits: Limits,
) -> Finding {
    let kind = if piece.side == Side::Material { "lost" } else { "closed" };
    let bracket = Bracket::new(piece.ball.radius, piece.ball.radius, piece.ball.high);
    let mut f = Finding::judged(code, kind, bracket, Basis::Certified, limits, "mm", part.tie());
    locate(&mut f, part, context, piece.ball.centre, piece.extent);
    f.witness = Some(Witness { kind: "largest-ball".into(), points_mm: vec![reported(part, piece.ball.centre)] });
    if part.health().bodies.len() > 1 {
        f.bodies = Some(vec![u64::from(piece.body) + 1]);
    }
    f
}

/// Whether a ball of a radius that touches one of the largest facets has room.
fn takes(part: &Part, side: Side, facets: &mut [u32], radius: f64) -> bool {
    let area = |f: &u32| part.mesh().facet_area(*f as usize);
    let largest = facets.len().min(TRIED);
    if largest < facets.len() {
        facets.select_nth_unstable_by(largest, |a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
    }
    facets.iter().take(largest).any(|&f| {
        let into = scale(part.mesh().normal(f as usize), -side.sign());
        let (at, wanted) = (part.mesh().centroid(f as usize), radius + part.step());
        part.distance().touching_ball(at, into, 1.01 * wanted, part.step()).radius >= wanted
    })
}

/// Where a point lies, seen from the piece that a shell bounds.
pub(super) fn place(part: &Part, side: Side, shell: u32, (p, nearest): (Vec3, &Nearest)) -> Place {
    let health = part.health();
    let in_material = part.winding().at(p) > 0.5;
    if in_material != (side == Side::Material) {
        return Place::Off;
    }
    let met = health.facet_shell.get(nearest.facet as usize).copied();
    let Some(other) = met.and_then(|s| health.shells.get(s as usize)) else { return Place::Unknown };
    let Some(own) = health.shells.get(shell as usize) else { return Place::Unknown };
    match side {
        Side::Material if other.body == own.body => Place::Within,
        Side::Void if met == Some(shell) => Place::Within,
        // Beside a body that lies loose in the void.
        Side::Void if other.role == Role::Body && within(other.box_mm, own.box_mm) => Place::Unknown,
        _ => Place::Off,
    }
}

fn within(a: [Vec3; 2], b: [Vec3; 2]) -> bool {
    (0..3).all(|x| b[0][x] <= a[0][x] && a[1][x] <= b[1][x])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Primitive, TriangleMesh, cuboid};
    use crate::part::Up;
    use crate::units::Length;

    fn ball(radius: f64, at: Vec3) -> TriangleMesh {
        let mesh = Primitive::Ball { radius: Length::mm(radius) }.mesh(Length::mm(1e-3));
        mesh.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], at)
    }

    fn found(mesh: TriangleMesh, offset: f64) -> Vanished {
        vanishing(&Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap(), offset).unwrap()
    }

    #[test]
    fn a_small_ball_and_a_small_void_go_and_what_is_larger_stays() {
        let block = || cuboid([-2.0; 3], [2.0; 3]);
        let parts = block().joined(&ball(0.25, [4.0, 0.0, 0.0])).joined(&ball(0.25, [0.3, 0.2, 0.1]).flipped());
        let all = found(parts.clone(), 0.3);
        let of = |side: Side| all.pieces.iter().filter(|p| p.side == side).count();
        assert!(all.all == 3 && all.open == 0 && of(Side::Material) == 1 && of(Side::Void) == 1);
        for p in &all.pieces {
            assert!(p.ball.radius <= 0.25 && p.ball.radius > 0.248 && p.ball.high < 0.254, "{:?}", p.ball);
        }
        assert!(found(parts, 0.24).pieces.is_empty());
    }

    #[test]
    fn a_void_around_a_loose_body_is_as_wide_as_the_gap_between() {
        let nested = cuboid([-3.0; 3], [3.0; 3]).joined(&cuboid([-1.0; 3], [1.0; 3]).flipped());
        let rattle = nested.joined(&cuboid([-0.8, -0.8, -0.8], [0.9, 0.9, 0.9]));
        let all = found(rattle, 0.3);
        let voids: Vec<&Vanishing> = all.pieces.iter().filter(|p| p.side == Side::Void).collect();
        assert!(voids.iter().all(|p| p.ball.high >= 0.1 && p.ball.radius < 0.3), "{}", all.open);
        assert!(all.pieces.iter().all(|p| p.side == Side::Void));
    }
}
