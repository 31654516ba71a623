//! The outline of a coaxial tool: its radius over the height above the tip.

use crate::geometry::vector::Vec3;

/// What a piece of a tool may do to the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It may touch, and does the work.
    Cutter,
    /// It must not touch; it carries the cutter.
    Neck,
    /// It must not touch; it is held, and goes on beyond the part.
    Holder,
}

impl Role {
    /// The word for it in files and messages.
    pub fn word(self) -> &'static str {
        match self {
            Role::Cutter => "cutter",
            Role::Neck => "neck",
            Role::Holder => "holder",
        }
    }
}

/// How the radius of a piece runs from its lower to its upper end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// Straight: a cylinder, a cone or a frustum.
    Straight { lower: f64, upper: f64 },
    /// The lower half of a ball.
    LowerBall { radius: f64 },
    /// A ball from its lowest point up to where it has the radius of the stem, beyond its middle.
    Ball { radius: f64 },
}

/// A piece of a coaxial tool: `{ (x, y, z) : from ≤ z ≤ to, √(x² + y²) ≤ r(z) }`, millimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    pub role: Role,
    pub from: f64,
    pub to: f64,
    pub outline: Outline,
}

impl Piece {
    /// Radius at a height between its ends.
    pub fn radius(&self, z: f64) -> f64 {
        let z = z.clamp(self.from, self.to);
        match self.outline {
            Outline::Straight { lower, upper } if self.to > self.from => {
                lower + (upper - lower) * ((z - self.from) / (self.to - self.from))
            }
            Outline::Straight { lower, .. } => lower,
            Outline::LowerBall { radius } | Outline::Ball { radius } => {
                let below = radius - (z - self.from);
                (radius * radius - below * below).max(0.0).sqrt()
            }
        }
    }

    /// Largest radius between two heights.
    fn largest(&self, lo: f64, hi: f64) -> f64 {
        let middle = match self.outline {
            Outline::Ball { radius } => Some(self.from + radius).filter(|m| (lo..=hi).contains(m)),
            _ => None,
        };
        middle.map_or(0.0, |m| self.radius(m)).max(self.radius(lo)).max(self.radius(hi))
    }
}

/// Pieces from the tip upwards, each beginning where the one before ends; the tip is at height 0.
///
/// The last piece is where the tool is held: it goes on upwards without end, as a hand or a machine does.
#[derive(Debug, Clone, PartialEq)]
pub struct Meridian {
    pieces: Vec<Piece>,
}

/// A point of the cutter's outline that touches first: radius and height, and how far the contact extends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    pub radius: f64,
    pub height: f64,
    /// The cutter touches along a flat end: every radius up to this one at the same height.
    pub flat: f64,
    /// The cutter touches along its flank: every height up to this one at the same radius.
    pub flank: f64,
}

impl Meridian {
    /// An outline from its pieces, which must follow each other.
    pub(super) fn new(pieces: Vec<Piece>) -> Self {
        Meridian { pieces }
    }

    /// The pieces from the tip upwards.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Height up to which it is described; beyond, the last radius goes on.
    pub fn length(&self) -> f64 {
        self.pieces.last().map_or(0.0, |p| p.to)
    }

    /// Largest radius of all.
    pub fn widest(&self) -> f64 {
        self.pieces.iter().map(|p| p.largest(p.from, p.to)).fold(0.0, f64::max)
    }

    /// Largest radius of the pieces that may touch.
    pub fn cutter_radius(&self) -> f64 {
        self.cutter().map(|p| p.largest(p.from, p.to)).fold(0.0, f64::max)
    }

    /// Height at which the pieces that may touch end.
    pub fn cutter_length(&self) -> f64 {
        self.cutter().map(|p| p.to).fold(0.0, f64::max)
    }

    /// Radius and height at both ends of each piece that may touch.
    pub fn cutter_corners(&self) -> Vec<[f64; 2]> {
        self.cutter().flat_map(|p| [p.from, p.to].map(|z| [p.radius(z), z])).collect()
    }

    fn cutter(&self) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().filter(|p| p.role == Role::Cutter)
    }

    /// sup { r(z) : lo < z < hi }, or `None` where the tool has no inside between these heights.
    pub fn largest_within(&self, lo: f64, hi: f64) -> Option<f64> {
        let last = self.pieces.len().checked_sub(1)?;
        let radii = self.pieces.iter().enumerate().filter_map(|(i, p)| {
            let end = if i == last { f64::INFINITY } else { p.to };
            let (a, b) = (lo.max(p.from), hi.min(end));
            (a < b).then(|| p.largest(a.min(p.to), b.min(p.to)))
        });
        radii.fold(None, |most: Option<f64>, r| Some(most.map_or(r, |m| m.max(r)))).filter(|r| *r > 0.0)
    }

    /// The least and the largest radius at which the surface of what may touch lies between two heights, ends and steps
    /// included; `None` where there is none of it.
    pub fn surface_between(&self, lo: f64, hi: f64) -> Option<[f64; 2]> {
        let met = self.cutter().filter(|p| p.from <= hi && p.to >= lo);
        let radii = met.map(|p| {
            let (a, b) = (lo.max(p.from), hi.min(p.to));
            [p.radius(a).min(p.radius(b)), p.largest(a, b)]
        });
        let [least, most] = radii.reduce(|x, y| [x[0].min(y[0]), x[1].max(y[1])])?;
        let ended = lo <= 0.0 || hi >= self.cutter_length();
        Some([if ended { 0.0 } else { least }, most])
    }

    /// The lesser of the radii just below and just above a height: 0 beside an end.
    pub fn least_beside(&self, z: f64) -> f64 {
        let last = self.pieces.len().saturating_sub(1);
        let (mut below, mut above) = (0.0f64, 0.0f64);
        for (i, p) in self.pieces.iter().enumerate() {
            if p.from < z && (z <= p.to || i == last) {
                below = p.radius(z);
            }
            if p.from <= z && (z < p.to || i == last) {
                above = p.radius(z);
            }
        }
        below.min(above)
    }

    /// Which piece a height belongs to.
    pub fn role_at(&self, z: f64) -> Role {
        self.pieces.iter().find(|p| z < p.to).or(self.pieces.last()).map_or(Role::Holder, |p| p.role)
    }

    /// Whether the radius never falls on the way up: then a tool that fits can be drawn out along its axis.
    pub fn widens_upwards(&self) -> bool {
        let falls = |p: &Piece| match p.outline {
            Outline::Straight { lower, upper } => upper < lower,
            Outline::LowerBall { .. } => false,
            Outline::Ball { radius } => p.to > p.from + radius,
        };
        let steps = self.pieces.windows(2).all(|w| w[0].radius(w[0].to) <= w[1].radius(w[1].from) + 1e-12);
        steps && !self.pieces.iter().any(falls)
    }

    /// Whether the pieces that may touch form one convex body: then it touches a plane only where [`Meridian::support`] says.
    pub fn cutter_is_convex(&self) -> bool {
        // r(z) is concave: its chords over equal steps never turn outwards, and it has no steps.
        const STEPS: usize = 256;
        let (top, wide) = (self.cutter_length(), self.cutter_radius());
        let pieces: Vec<&Piece> = self.cutter().collect();
        let joined = pieces.windows(2).all(|w| (w[0].radius(w[0].to) - w[1].radius(w[1].from)).abs() <= 1e-9 * wide);
        let at = |i: usize| {
            let z = top * i as f64 / STEPS as f64;
            pieces.iter().find(|p| z <= p.to).map_or(0.0, |p| p.radius(z))
        };
        joined && (1..STEPS).all(|i| at(i - 1) + at(i + 1) - 2.0 * at(i) <= 1e-9 * wide)
    }

    /// Where the cutter touches a plane whose normal, out of the material, rises by `rise` = n·axis and has the horizontal
    /// length `level` = √(1 − rise²): the point of the outline that lies furthest along (−level … outwards, −rise).
    pub fn support(&self, level: f64, rise: f64) -> Option<Support> {
        let mut best: Option<(f64, Support)> = None;
        let mut offer = |r: f64, z: f64| {
            let value = r * level - z * rise;
            // Upwards, so the lowest of equal ones stays.
            if best.is_none_or(|(b, _)| value > b + 1e-12) {
                best = Some((value, Support { radius: r, height: z, flat: 0.0, flank: z }));
            }
        };
        for p in self.cutter() {
            offer(p.radius(p.from), p.from);
            if let Outline::LowerBall { radius } | Outline::Ball { radius } = p.outline {
                let z = p.from + radius * (1.0 - rise);
                if z <= p.to {
                    offer(p.radius(z), z);
                }
            }
            offer(p.radius(p.to), p.to);
        }
        let (value, mut found) = best?;
        // A face that lies in the plane touches all along.
        for p in self.cutter() {
            let end = (p.radius(p.to), p.to);
            if (end.0 * level - end.1 * rise - value).abs() <= 1e-9 && end.1 > found.height {
                found.flank = end.1;
            }
        }
        if level < 1e-9 {
            found.flat = found.radius;
        }
        Some(found)
    }
}

/// Nearly level counts as level, since coordinates are rounded.
pub(super) fn lies_flat(normal: Vec3) -> bool {
    normal[2] > 0.0 && normal[0].hypot(normal[1]) < 1e-3
}

/// The horizontal length of a normal, and its rise. Nearly level or upright counts as both, since coordinates are rounded.
pub(super) fn level_and_rise(normal: Vec3) -> [f64; 2] {
    [normal[0].hypot(normal[1]), normal[2]].map(|c| if c.abs() < 1e-3 { 0.0 } else { c })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(role: Role, from: f64, to: f64, lower: f64, upper: f64) -> Piece {
        Piece { role, from, to, outline: Outline::Straight { lower, upper } }
    }

    fn mill() -> Meridian {
        Meridian::new(vec![straight(Role::Cutter, 0.0, 10.0, 3.0, 3.0), straight(Role::Holder, 10.0, 20.0, 12.0, 12.0)])
    }

    #[test]
    fn radii_between_heights_and_beside_them() {
        let m = mill();
        assert_eq!(m.largest_within(-2.0, 0.0), None);
        assert_eq!(m.largest_within(-1.0, 1.0), Some(3.0));
        assert_eq!(m.largest_within(9.0, 10.0), Some(3.0), "the holder begins where the interval ends");
        assert_eq!(m.largest_within(9.5, 10.5), Some(12.0));
        assert_eq!(m.largest_within(100.0, 101.0), Some(12.0), "held from without");
        assert_eq!((m.least_beside(0.0), m.least_beside(5.0), m.least_beside(10.0)), (0.0, 3.0, 3.0));
        assert!(m.widens_upwards() && m.cutter_is_convex());
        assert_eq!((m.role_at(5.0), m.role_at(15.0), m.role_at(500.0)), (Role::Cutter, Role::Holder, Role::Holder));
    }

    #[test]
    fn the_surface_between_heights_has_its_ends_and_steps() {
        let stepped =
            Meridian::new(vec![straight(Role::Cutter, 0.0, 4.0, 1.0, 1.0), straight(Role::Cutter, 4.0, 9.0, 3.0, 2.0)]);
        assert_eq!(stepped.surface_between(1.0, 2.0), Some([1.0, 1.0]));
        assert_eq!(stepped.surface_between(0.0, 2.0), Some([0.0, 1.0]), "its lower end");
        assert_eq!(stepped.surface_between(3.0, 5.0), Some([1.0, 3.0]), "the step");
        assert_eq!(stepped.surface_between(8.0, 20.0), Some([0.0, 2.2]), "its upper end");
        assert_eq!(stepped.surface_between(10.0, 20.0), None);
    }

    #[test]
    fn a_flat_end_touches_floors_along_its_end_and_walls_along_its_flank() {
        let m = mill();
        let floor = m.support(0.0, 1.0).unwrap();
        assert_eq!((floor.radius, floor.height, floor.flat), (3.0, 0.0, 3.0));
        let wall = m.support(1.0, 0.0).unwrap();
        assert_eq!((wall.radius, wall.height, wall.flank), (3.0, 0.0, 10.0));
        let ceiling = m.support(0.0, -1.0).unwrap();
        assert_eq!(ceiling.height, 10.0);
    }

    #[test]
    fn a_ball_end_touches_a_slope_where_its_normal_is_the_slopes() {
        let ball = Piece { role: Role::Cutter, from: 0.0, to: 2.0, outline: Outline::LowerBall { radius: 2.0 } };
        let m = Meridian::new(vec![ball, straight(Role::Cutter, 2.0, 8.0, 2.0, 2.0)]);
        let s = m.support(0.6, 0.8).unwrap();
        assert!((s.height - 0.4).abs() < 1e-12 && (s.radius - 1.2).abs() < 1e-12, "{s:?}");
        assert!(m.widens_upwards() && m.cutter_is_convex());
    }

    #[test]
    fn a_probe_does_not_widen_upwards() {
        let ball = Piece { role: Role::Cutter, from: 0.0, to: 1.8, outline: Outline::Ball { radius: 1.0 } };
        let m = Meridian::new(vec![ball, straight(Role::Neck, 1.8, 20.0, 0.6, 0.6)]);
        assert!(!m.widens_upwards() && m.cutter_is_convex());
        assert_eq!(m.largest_within(0.5, 1.5), Some(1.0));
        let below = m.support(0.8, -0.6).unwrap();
        assert!((below.height - 1.6).abs() < 1e-12, "{below:?}");
    }
}
