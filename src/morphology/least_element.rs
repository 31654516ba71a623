//! The least that a process lays down, as a shape.

use crate::geometry::vector::Vec3;
use crate::units::Length;

/// Outline of an element across the build direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Footprint {
    /// A disc: a bead or a spot.
    Disc,
    /// A square along x and y: a pixel.
    Square,
}

/// The least that a process lays down: a prism of a width across and a height along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bead {
    pub footprint: Footprint,
    pub width: Length,
    pub height: Length,
}

impl Bead {
    /// What of a length is longer than half the width: a face moves no farther by the element that half of lies in the part.
    pub fn beyond_half(&self, length: Length) -> Length {
        Length::mm((length.as_mm() - 0.5 * self.width.as_mm()).max(0.0))
    }

    /// Width of the element along a unit vector: the distance of its two supporting planes.
    pub fn width_along(&self, direction: Vec3) -> Length {
        let [x, y, z] = direction.map(f64::abs);
        let across = match self.footprint {
            Footprint::Disc => x.hypot(y),
            Footprint::Square => x + y,
        };
        self.width * across + self.height * z
    }

    /// The largest of all its widths.
    pub fn widest(&self) -> Length {
        let across = match self.footprint {
            Footprint::Disc => self.width.as_mm(),
            Footprint::Square => std::f64::consts::SQRT_2 * self.width.as_mm(),
        };
        Length::mm(across.hypot(self.height.as_mm()))
    }

    /// How deep a plane across a unit vector cuts, counted from the element's outermost point, when it cuts off a share of its volume.
    ///
    /// The depth d with vol { x ∈ B : n·x > h_B(n) − d } = share · vol B; bisected to a billionth of the width.
    ///
    /// ```
    /// use amcheck::{morphology::{Bead, Footprint}, units::Length};
    /// let bead = Bead { footprint: Footprint::Square, width: Length::mm(0.4), height: Length::mm(0.2) };
    /// assert!((bead.depth_of([1.0, 0.0, 0.0], 0.25).as_mm() - 0.1).abs() < 1e-3);
    /// assert!((bead.depth_of([0.0, 0.0, 1.0], 0.25).as_mm() - 0.05).abs() < 1e-3);
    /// ```
    pub fn depth_of(&self, direction: Vec3, share: f64) -> Length {
        let beyond = self.beyond(direction);
        let (mut low, mut high) = (0.0, self.width_along(direction).as_mm());
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if beyond(middle) < share { low = middle } else { high = middle }
        }
        Length::mm(0.5 * (low + high))
    }

    /// The share of the element's volume beyond a plane across a unit vector, so deep below the outermost point: what
    /// [`Bead::depth_of`] inverts.
    pub fn share_beyond(&self, direction: Vec3, depth: Length) -> f64 {
        self.beyond(direction)(depth.as_mm())
    }

    fn beyond(&self, direction: Vec3) -> impl Fn(f64) -> f64 {
        let [x, y, z] = direction.map(f64::abs);
        let (w, footprint) = (self.width.as_mm(), self.footprint);
        // A side of nothing leaves no volume to cut; a ten-thousandth of the width changes the depth by less.
        let least = 1e-4 * self.width_along(direction).as_mm();
        let sides = [w * x, w * y, self.height.as_mm() * z].map(|side| side.max(least));
        let radius = (0.5 * w * x.hypot(y)).max(least);
        move |depth| match footprint {
            Footprint::Square => corner_share(sides, depth),
            // The mean over all heights of what lies beyond a chord of the disc.
            Footprint::Disc => {
                let chord = |depth: f64| segments(1.0 - depth / radius);
                (chord(depth) - chord(depth - sides[2])) * radius / sides[2]
            }
        }
    }
}

/// ∫ from u to ∞ of the share of the unit disc beyond a chord: (acos u − u √(1 − u²)) / π for |u| ≤ 1.
fn segments(u: f64) -> f64 {
    if u >= 1.0 {
        return 0.0;
    }
    let inside = u.max(-1.0);
    let root = (1.0 - inside * inside).sqrt();
    (root - inside * inside.acos() - root.powi(3) / 3.0) / std::f64::consts::PI + (inside - u)
}

/// The share of a box of three sides along a direction that a plane cuts off its corner at a depth: by inclusion and exclusion,
/// Σ ± max(0, d − Σ sides)³ / (6abc).
fn corner_share(sides: Vec3, depth: f64) -> f64 {
    let [a, b, c] = sides;
    let cut: f64 = (0..8u32)
        .map(|corner| {
            let passed: f64 = (0..3).filter(|i| corner >> i & 1 == 1).map(|i| sides[i as usize]).sum();
            let sign = if corner.count_ones() % 2 == 0 { 1.0 } else { -1.0 };
            sign * (depth - passed).max(0.0).powi(3)
        })
        .sum();
    (cut / (6.0 * a * b * c)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{dot, unit};

    #[test]
    fn the_depth_of_a_share_is_that_of_counted_points() {
        let mut random = crate::random::Lcg(3);
        for footprint in [Footprint::Disc, Footprint::Square] {
            let bead = Bead { footprint, width: Length::mm(0.4), height: Length::mm(0.15) };
            let points: Vec<Vec3> = (0..81 * 81 * 9)
                .map(|n| [n % 81, n / 81 % 81, n / (81 * 81)])
                .map(|[i, j, k]| {
                    [0.4 * (i as f64 / 80.0 - 0.5), 0.4 * (j as f64 / 80.0 - 0.5), 0.15 * (k as f64 / 8.0 - 0.5)]
                })
                .filter(|p| footprint == Footprint::Square || p[0].hypot(p[1]) <= 0.2)
                .collect();
            for _ in 0..20 {
                let n = unit([random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5]);
                let share = 0.1 + 0.8 * random.unit();
                let mut heights: Vec<f64> = points.iter().map(|p| dot(*p, n)).collect();
                heights.sort_by(|a, b| b.total_cmp(a));
                let counted = 0.5 * bead.width_along(n).as_mm() - heights[(share * heights.len() as f64) as usize];
                // Points lie 0.005 mm apart across and 0.019 mm along z.
                let depth = bead.depth_of(n, share).as_mm();
                assert!((depth - counted).abs() < 0.012, "{footprint:?} {n:?} {share}: {depth} {counted}");
            }
        }
    }

    #[test]
    fn the_middle_of_a_disc_holds_half_of_it_within_two_fifths_of_its_width() {
        let bead = Bead { footprint: Footprint::Disc, width: Length::mm(1.0), height: Length::mm(0.5) };
        // asin u + u √(1 − u²) = π/4 at u = 0.40397.
        let left = 1.0 - 2.0 * bead.depth_of([1.0, 0.0, 0.0], 0.25).as_mm();
        assert!((left - 0.40397).abs() < 1e-3, "{left}");
    }
}
