//! Facets clipped to columns.

use crate::geometry::vector::Vec3;

/// A convex polygon, x and y in columns, z in millimetres.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Polygon {
    corners: [Vec3; 8],
    len: usize,
}

impl Polygon {
    pub(super) fn push(&mut self, p: Vec3) {
        if let Some(corner) = self.corners.get_mut(self.len) {
            *corner = p;
            self.len += 1;
        }
    }

    pub(super) fn points(&self) -> &[Vec3] {
        &self.corners[..self.len]
    }

    pub(super) fn span(&self, axis: usize) -> (f64, f64) {
        let along = |p: &Vec3| p[axis];
        let low = self.points().iter().map(along).fold(f64::INFINITY, f64::min);
        (low, self.points().iter().map(along).fold(f64::NEG_INFINITY, f64::max))
    }

    /// Signed area of the shadow.
    pub(super) fn area(&self) -> f64 {
        self.fan().map(|(area, _)| area).sum()
    }

    /// Mean height over the shadow.
    pub(super) fn mean_height(&self) -> f64 {
        let (area, moment) = self.fan().fold((0.0, 0.0), |(a, m), (area, z)| (a + area, m + area * z));
        if area == 0.0 { f64::NAN } else { moment / area }
    }

    /// Triangles from the first corner: signed area and mean height.
    fn fan(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let p = self.points();
        (1..self.len.saturating_sub(1)).map(move |i| {
            let (a, b, c) = (p[0], p[i], p[i + 1]);
            let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            (0.5 * twice, (a[2] + b[2] + c[2]) / 3.0)
        })
    }

    /// The part on one side of a plane across an axis: `sign` 1 keeps what lies above.
    fn clipped(&self, axis: usize, at: f64, sign: f64) -> Self {
        let mut out = Polygon::default();
        let p = self.points();
        for (i, &a) in p.iter().enumerate() {
            let b = p[(i + 1) % p.len()];
            let (da, db) = (sign * (a[axis] - at), sign * (b[axis] - at));
            if da >= 0.0 {
                out.push(a);
            }
            if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
                let t = da / (da - db);
                let mut cut = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])];
                cut[axis] = at;
                out.push(cut);
            }
        }
        out
    }

    /// The slices [n, n+1] across an axis that the polygon meets.
    pub(super) fn slices(&self, axis: usize, count: usize) -> std::ops::RangeInclusive<usize> {
        let (low, high) = self.span(axis);
        // A cast cuts off what is behind the point, and what is below zero: no call rounds.
        let whole = high as usize;
        let above = if whole as f64 >= high { whole.saturating_sub(1) } else { whole };
        let last = above.min(count - 1);
        (low as usize).min(last)..=last
    }

    /// Calls back with each of its slices across an axis, and what of it lies there.
    pub(super) fn each_slice(&self, axis: usize, count: usize, mut found: impl FnMut(usize, &Polygon)) {
        let (first, last) = self.slices(axis, count).into_inner();
        if first == last {
            return found(first, self);
        }
        let mut rest = *self;
        for n in first..last {
            let at = (n + 1) as f64;
            found(n, &rest.clipped(axis, at, -1.0));
            rest = rest.clipped(axis, at, 1.0);
        }
        found(last, &rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_are_those_between_rounded_ends() {
        let ends = [-3.5, -1.0, -0.25, 0.0, 0.5, 1.0, 1.5, 2.0, 2.0f64.next_down(), 2.0f64.next_up(), 6.75, 7.0, 9.0];
        for low in ends {
            for high in ends.into_iter().filter(|h| *h >= low) {
                let mut polygon = Polygon::default();
                [[low, 0.0, 0.0], [high, 0.0, 0.0], [low, 1.0, 0.0]].into_iter().for_each(|p| polygon.push(p));
                let last = ((high.ceil() - 1.0).max(0.0) as usize).min(7);
                let plain = (low.floor().max(0.0) as usize).min(last)..=last;
                assert_eq!(polygon.slices(0, 8), plain, "{low} {high}");
            }
        }
    }
}
