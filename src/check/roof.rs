//! Roofs for lying holes before they are advised: how much material there is above the crown for a teardrop or a flat roof.

use super::contract::limits_of;
use super::hanging::BRIDGE;
use super::rods::plain;
use crate::access::support_angle;
use crate::geometry::vector::{Vec3, unit};
use crate::layer::{Ceiling, Point, lifted, stretch};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// Places along a hole that are tried.
const PLACES: usize = 9;

/// What trying roofs over a lying hole has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roof {
    /// How much higher than the crown the tip of a teardrop is.
    higher: f64,
    /// The least material above the crown; infinite where there is nothing beyond.
    above: f64,
    /// Width of a roof that is flat at the height of the crown, and the least material around its two edges.
    flat: f64,
    around: f64,
    /// How wide a flat roof may be.
    bridge: Option<f64>,
    /// What has to be left.
    wall: f64,
}

impl Roof {
    /// Lays both roofs over the crown of a hole: two planes as steep as the process holds up, from where its sides become flatter than
    /// that, to where they meet, or cut off flat at the crown. `None` without an overhang angle.
    ///
    /// # Cost
    /// Seven rays at each of nine places along the hole.
    pub fn of(part: &Part, process: &Process, hole: &Ceiling) -> Option<Self> {
        let angle = support_angle(process).filter(|a| *a > 0.0 && *a < 90.0)?;
        let ([from, to], round) = (hole.bridge?.ends, hole.crown?);
        let limit = |rule: &str| limits_of(process, rule).and_then(|l| l.fail.or(l.warn));
        let (chord, across) = (round.chord_mm, round.across);
        let middle: Point = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
        let crown = lifted(part.mesh(), &hole.facets, middle)[2] - 0.5 * (from[2] + to[2]);
        // A plane that climbs along the hole is less steep across it.
        let slope = (angle.to_radians().tan().powi(2) - round.grade * round.grade).max(0.0).sqrt();
        let flat = if slope > 0.0 { (chord - 2.0 * crown / slope).max(0.0) } else { 0.0 };
        let mut roof = Roof {
            higher: (0.5 * chord * slope - crown).max(0.0),
            above: f64::INFINITY,
            flat,
            around: f64::INFINITY,
            bridge: limit(BRIDGE),
            wall: limit("thin-wall").unwrap_or(0.0),
        };
        let [a, b] = stretch(part.mesh(), &hole.facets, middle, [-across[1], across[0]])?;
        for n in 0..PLACES {
            let t = (n as f64 + 0.5) / PLACES as f64;
            let top = lifted(part.mesh(), &hole.facets, [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            roof.above = roof.above.min(thickness(part, top, [0.0, 0.0, 1.0]));
            for side in [across, across.map(|x| -x)] {
                let edge = [0, 1, 2].map(|c| top[c] + 0.5 * flat * side[c]);
                let ways = [[0.0, 0.0, 1.0], side, unit([side[0], side[1], 1.0])];
                roof.around = ways.into_iter().map(|way| thickness(part, edge, way)).fold(roof.around, f64::min);
            }
        }
        Some(roof)
    }

    fn takes_teardrop(&self, part: &Part) -> bool {
        self.above >= self.higher + self.wall - part.tie()
    }

    fn takes_flat(&self, part: &Part) -> bool {
        self.bridge.is_some_and(|most| self.flat <= most + part.tie())
            && self.around.min(self.above) >= self.wall - part.tie()
    }

    pub fn has_room(&self, part: &Part) -> bool {
        self.takes_teardrop(part) || self.takes_flat(part)
    }

    /// In words, for a limit of lying holes.
    pub fn words(&self, part: &Part, limit: f64) -> String {
        let smaller = format!("make it {} mm or less", short(limit));
        let teardrop = format!("a teardrop {} mm higher than its crown", plain(self.higher));
        let flat = format!("a flat roof {} mm wide", plain(self.flat));
        let above = plain(self.above);
        match (self.takes_teardrop(part), self.takes_flat(part)) {
            (true, true) => {
                format!(
                    "{smaller}, or give it {teardrop} or {flat}: {above} mm of material are above it, checked on the surface"
                )
            }
            (true, false) => {
                format!("{smaller}, or give it {teardrop}: {above} mm of material are above it, checked on the surface")
            }
            (false, true) => format!(
                "{smaller}, or give it {flat}: there is room for that, checked on the surface, but not for {teardrop}: {above} mm of material \
                 are above it"
            ),
            (false, false) => {
                format!(
                    "{smaller}; there is no room for {teardrop} nor for {flat}: {above} mm of material are above it, checked on the surface"
                )
            }
        }
    }
}

/// How far the material goes from a place on or in it; infinite where nothing is met.
fn thickness(part: &Part, from: Vec3, way: Vec3) -> f64 {
    let far = part.extent().iter().sum();
    let hit = part.distance().first_hit(from, way, 4.0 * part.step() + 1e-4, far);
    hit.map_or(f64::INFINITY, |h| h.0)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::check::hanging::ceilings_of;
    use crate::geometry::TriangleMesh;
    use crate::part::Up;

    /// A block 24 mm wide and 12 mm deep with a lying hole of so many sides, 4 mm above its foot and under so much material.
    pub fn block(sides: usize, diameter: f64, above: f64) -> Part {
        let (radius, axis) = (0.5 * diameter, 0.5 * diameter + 4.0);
        let ring = |n: usize| {
            let (s, c) = (std::f64::consts::TAU * ((n % sides) as f64 + 0.5) / sides as f64).sin_cos();
            [radius * c, axis + radius * s]
        };
        let top = axis + radius + above;
        // A corner of the block for each quarter of the ring.
        let square = |n: usize| [[12.0, top], [-12.0, top], [-12.0, 0.0], [12.0, 0.0]][(n * 4 / sides) % 4];
        let mut facets = Vec::new();
        let at = |p: [f64; 2], y: f64| [p[0], y, p[1]];
        let mut quad = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| facets.extend([[a, b, c], [a, c, d]]);
        for n in 0..sides {
            let (p, q, r, s) = (ring(n), ring(n + 1), square(n), square(n + 1));
            quad(at(p, 0.0), at(q, 0.0), at(q, 12.0), at(p, 12.0));
            quad(at(p, 0.0), at(r, 0.0), at(s, 0.0), at(q, 0.0));
            quad(at(p, 12.0), at(q, 12.0), at(s, 12.0), at(r, 12.0));
            if r != s {
                quad(at(r, 0.0), at(r, 12.0), at(s, 12.0), at(s, 0.0));
            }
        }
        facets.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        let mesh = TriangleMesh::weld(facets);
        let mesh = if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh };
        Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap()
    }

    fn tried(above: f64) -> (Roof, Part) {
        let part = block(64, 8.0, above);
        assert!(part.health().is_watertight(), "{:?}", part.health().open_edges);
        let process = Process::named("fdm").unwrap();
        let all = ceilings_of(&part, &process, 0);
        let hole = all.iter().find(|c| c.crown.is_some()).unwrap();
        (Roof::of(&part, &process, hole).unwrap(), part)
    }

    #[test]
    fn a_teardrop_needs_its_height_and_a_wall_above() {
        let (roof, part) = tried(4.0);
        // 4·(√2 − 1) above the crown; eight sides of a circle of 4 mm cut off flat: 2·4·tan(22.5°).
        assert!((roof.higher - 4.0 * (2f64.sqrt() - 1.0)).abs() < 0.03, "{roof:?}");
        assert!(
            (roof.flat - 8.0 * 22.5f64.to_radians().tan()).abs() < 0.1 && (roof.above - 4.0).abs() < 0.01,
            "{roof:?}"
        );
        assert!(roof.takes_teardrop(&part) && roof.takes_flat(&part), "{roof:?}");
        assert!(roof.words(&part, 6.0).contains("a teardrop 1.6"), "{}", roof.words(&part, 6.0));
    }

    #[test]
    fn a_low_roof_leaves_room_for_a_flat_one_or_for_none() {
        let (roof, part) = tried(1.5);
        assert!(!roof.takes_teardrop(&part) && roof.takes_flat(&part), "{roof:?}");
        let (roof, part) = tried(0.5);
        assert!(!roof.has_room(&part), "{roof:?}");
        assert!(
            roof.words(&part, 6.0).starts_with("make it 6 mm or less; there is no room"),
            "{}",
            roof.words(&part, 6.0)
        );
    }
}
