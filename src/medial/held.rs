//! The largest ball about a point of a plane that the surface holds from all sides of it: what is between two pieces that widen.

use crate::geometry::MeshDistance;
use crate::geometry::distance::Nearest;
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, add, along, angle, distance, dot, norm, scale, sub};

/// Ways in the plane that the surface is looked for along, from where the search starts.
const WAYS: usize = 12;
/// Balls that are tried before the search is given up.
const TRIES: usize = 16;
/// Determinant of three sides' normals below which they hold nothing.
const FLAT: f64 = 1e-9;

/// A ball that is held, and the facets that the sides of the section lie on.
#[derive(Debug, Clone)]
pub(super) struct Held {
    pub centre: Vec3,
    pub radius: f64,
    facets: Vec<u32>,
}

/// A side of the section: all centres x of balls of radius r that keep it have ⟨n, x⟩ ≥ offset + r.
#[derive(Clone, Copy)]
struct Line {
    normal: [f64; 2],
    offset: f64,
    facet: u32,
}

/// The search in a plane through a point with two unit vectors at right angles.
pub(super) struct Section<'a> {
    pub mesh: &'a MeshDistance,
    pub origin: Vec3,
    pub axes: [Vec3; 2],
    /// What a point of the surface may intrude into a ball, as a share of its radius and as a length.
    pub agree: [f64; 2],
}

impl Section<'_> {
    /// The largest ball about a point of the plane that touches sides all around it; `None` where the section is open or wider than `reach`
    /// from the origin.
    ///
    /// max r subject to ⟨n, x⟩ − r ≥ o for each side of the section: a linear program in three unknowns, whose sides are the surface's along
    /// twelve ways, and then those that are nearer to the ball found than its radius. Of a section that is not convex the ball is one of
    /// several.
    ///
    /// # Cost
    /// Twelve rays, and up to sixteen nearest points.
    pub fn held(&self, reach: f64) -> Option<Held> {
        let mut lines: Vec<Line> = Vec::with_capacity(WAYS + TRIES);
        // Ways that are far from each other first: most sections are open, and one way out is enough.
        for k in (0..WAYS).map(|k| 5 * k % WAYS) {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / WAYS as f64).sin_cos();
            let way = add(scale(self.axes[0], cos), scale(self.axes[1], sin));
            let (length, facet) = self.mesh.first_hit(self.origin, way, 0.0, reach)?;
            if lines.iter().all(|l| l.facet != facet) {
                lines.push(self.side(along(self.origin, way, length), way, facet)?);
            }
        }
        for _ in 0..TRIES {
            let (x, radius) = largest(&lines)?;
            let centre = along(along(self.origin, self.axes[0], x[0]), self.axes[1], x[1]);
            let agree = self.agree[1].max(self.agree[0] * radius);
            let Some(near) = self.mesh.nearest(centre, radius - agree) else {
                let facets = lines.iter().map(|l| l.facet).collect();
                return Some(Held { centre, radius, facets });
            };
            lines.push(self.beside(centre, &near)?);
        }
        None
    }

    fn flat(&self, v: Vec3) -> [f64; 2] {
        self.axes.map(|axis| dot(v, axis))
    }

    /// The side that a facet makes of the section, met at a point along a way.
    fn side(&self, at: Vec3, way: Vec3, facet: u32) -> Option<Line> {
        let n = self.mesh.normal(facet);
        let inward = scale(n, -dot(n, way).signum());
        self.line(at, inward, facet)
    }

    /// The side that lies nearest to a point.
    fn beside(&self, centre: Vec3, near: &Nearest) -> Option<Line> {
        self.line(near.point, sub(centre, near.point), near.facet)
    }

    fn line(&self, at: Vec3, inward: Vec3, facet: u32) -> Option<Line> {
        let [x, y] = self.flat(inward);
        let length = x.hypot(y);
        let [u, v] = self.flat(sub(at, self.origin));
        let normal = [x / length, y / length];
        (length > 1e-6 * norm(inward)).then_some(Line { normal, offset: normal[0] * u + normal[1] * v, facet })
    }

    /// The contact of a ball that is held which lies farthest round from another.
    pub fn opposite(&self, ball: &Held, from: Vec3) -> Option<Nearest> {
        let (reach, back) = (ball.radius + self.agree[1].max(self.agree[0] * ball.radius), sub(from, ball.centre));
        let contact = |&facet: &u32| {
            let point = closest_point(ball.centre, self.mesh.corners(facet));
            let distance = distance(point, ball.centre);
            (distance <= reach).then_some(Nearest { point, facet, distance })
        };
        let round = |c: &Nearest| angle(sub(c.point, ball.centre), back);
        let contacts = ball.facets.iter().filter_map(contact);
        contacts.max_by(|a, b| round(a).total_cmp(&round(b)).then(b.facet.cmp(&a.facet)))
    }
}

/// The largest circle that keeps all lines, where three of them hold it.
fn largest(lines: &[Line]) -> Option<([f64; 2], f64)> {
    let scale = lines.iter().map(|l| l.offset.abs()).fold(0.0, f64::max);
    let keeps = |(x, r): &([f64; 2], f64)| {
        lines.iter().all(|l| l.normal[0] * x[0] + l.normal[1] * x[1] - r >= l.offset - 1e-9 * scale)
    };
    let mut best: Option<([f64; 2], f64)> = None;
    for (k, c) in lines.iter().enumerate() {
        for (j, b) in lines[..k].iter().enumerate() {
            for a in &lines[..j] {
                let held = between([a, b, c]).filter(|held| best.is_none_or(|b| held.1 > b.1) && keeps(held));
                best = held.or(best);
            }
        }
    }
    best
}

/// The circle within three lines that hold it from all sides.
fn between([a, b, c]: [&Line; 3]) -> Option<([f64; 2], f64)> {
    let turn = |p: &Line, q: &Line| p.normal[0] * q.normal[1] - p.normal[1] * q.normal[0];
    // The normals' middle combination: 0 = λ a + μ b + ν c with weights of one sign, or they leave a way out.
    let weights = [turn(b, c), turn(c, a), turn(a, b)];
    let sum: f64 = weights.iter().sum();
    if sum.abs() < FLAT || weights.iter().any(|w| w * sum.signum() < -FLAT) {
        return None;
    }
    let offsets = [a, b, c].map(|l| l.offset);
    let radius = -(0..3).map(|i| weights[i] * offsets[i]).sum::<f64>() / sum;
    // Two of the lines that are not parallel give the centre.
    let (p, q, d) = [(a, b, turn(a, b)), (b, c, turn(b, c)), (c, a, turn(c, a))]
        .into_iter()
        .max_by(|l, m| l.2.abs().total_cmp(&m.2.abs()))?;
    let (s, t) = (p.offset + radius, q.offset + radius);
    let x = [(s * q.normal[1] - t * p.normal[1]) / d, (t * p.normal[0] - s * q.normal[0]) / d];
    (radius > 0.0).then_some((x, radius))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::extruded;

    /// The ball that a prism over a polygon holds in its middle section, started at a point.
    fn ball(outline: &[[f64; 2]], from: [f64; 2]) -> Option<(Vec3, f64)> {
        let caps: Vec<[usize; 3]> = (2..outline.len()).map(|i| [0, i - 1, i]).collect();
        let mesh = MeshDistance::new(&extruded(outline, &caps, 20.0));
        let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let section = Section { mesh: &mesh, origin: [from[0], 10.0, from[1]], axes, agree: [1e-6, 1e-9] };
        section.held(8.0).map(|held| (held.centre, held.radius))
    }

    #[test]
    fn a_polygon_holds_its_inscribed_circle_wherever_the_search_starts() {
        for sides in [3, 4, 5, 6, 7, 24] {
            let corner = |n: usize| {
                let (sin, cos) = (std::f64::consts::TAU * n as f64 / sides as f64 + 0.3).sin_cos();
                [2.0 * cos + 1.0, 2.0 * sin - 0.5]
            };
            let outline: Vec<[f64; 2]> = (0..sides).map(corner).collect();
            let wanted = 2.0 * (std::f64::consts::PI / sides as f64).cos();
            for from in [[1.0, -0.5], [1.4, -0.2], [0.6, -0.9]] {
                let (centre, radius) = ball(&outline, from).unwrap();
                assert!((radius - wanted).abs() < 1e-6, "{sides}: {radius} for {wanted}");
                assert!((centre[0] - 1.0).hypot(centre[2] + 0.5) < 1e-5, "{sides}: {centre:?}");
            }
        }
        // A right triangle of 3, 4 and 5: its circle has radius 1 and touches none of its sides in the middle.
        let (centre, radius) = ball(&[[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]], [0.4, 0.3]).unwrap();
        assert!((radius - 1.0).abs() < 1e-6 && (centre[0] - 1.0).hypot(centre[2] - 1.0) < 1e-5, "{centre:?}, {radius}");
        // Sides that are farther away hold nothing.
        assert!(ball(&[[0.0, 0.0], [30.0, 0.0], [30.0, 4.0], [0.0, 4.0]], [15.0, 1.0]).is_none());
    }
}
