//! Whether a coaxial tool at a pose keeps clear of the facets of a part, exactly.

use super::meridian::{Meridian, Outline, Piece};
use super::pose::Rotation;
use crate::geometry::MeshDistance;
use crate::geometry::bvh::Node;
use crate::geometry::triangle::closest_point;
use crate::geometry::vector::{Vec3, along, dot, norm, sub};

/// Slices of a cone, at most.
const SLICES: f64 = 64.0;

/// Whether what is in a box reaches into a tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meeting {
    Never,
    Perhaps,
    Surely,
}

impl Meridian {
    /// The tool thinner by so much all round: what reaches into it by less keeps clear of it.
    pub(super) fn thinner(&self, by: f64) -> Meridian {
        let pieces = self.pieces();
        let radius_at = |p: Option<&Piece>, z: fn(&Piece) -> f64| p.map_or(0.0, |p| p.radius(z(p)));
        let thin = |(n, p): (usize, &Piece)| {
            let below = n.checked_sub(1).and_then(|n| pieces.get(n));
            let widens = radius_at(Some(p), |p| p.from) > radius_at(below, |p| p.to);
            let narrows = pieces.get(n + 1).is_some_and(|next| next.radius(next.from) < p.radius(p.to));
            let less = |r: f64| (r - by).max(0.0);
            let (outline, is_round) = match p.outline {
                Outline::Straight { lower, upper } => {
                    (Outline::Straight { lower: less(lower), upper: less(upper) }, false)
                }
                Outline::LowerBall { radius } => (Outline::LowerBall { radius: less(radius) }, true),
                Outline::Ball { radius } => (Outline::Ball { radius: less(radius) }, true),
            };
            let from = if n == 0 || widens || is_round { p.from + by } else { p.from };
            let to = if narrows { p.to - by } else { p.to };
            Piece { from: from.min(p.to), to: to.max(from.min(p.to)), outline, ..*p }
        };
        Meridian::new(pieces.iter().enumerate().map(thin).collect())
    }

    /// Whether no facet reaches into the tool that stands with its tip at a point of a frame, whose rows are given; its last piece goes on upwards without end.
    ///
    /// Cones are taken in slices that differ in radius by `step` at most. For many poses in one frame [`super::placed::Placed`] tells it faster.
    ///
    /// # Cost
    /// O(log facets) and an exact distance for each facet beside the tool; where something is in the way, often that of one facet.
    pub(super) fn is_clear(&self, view: &MeshDistance, (frame, tip): (&Rotation, Vec3), step: f64) -> bool {
        let placed = |p: Vec3| sub(frame.map(|row| dot(row, p)), tip);
        let (tree, nodes) = (view.tree(), view.tree().nodes());
        let mut open = vec![0usize];
        while let Some(at) = open.pop() {
            let Some(node) = nodes.get(at) else { continue };
            match self.meeting(node, frame, tip) {
                Meeting::Never => continue,
                Meeting::Surely => return false,
                Meeting::Perhaps => {}
            }
            match node.children() {
                Some(children) => open.extend(children),
                None => {
                    let mut facets = tree.order()[node.run()].iter();
                    if facets.any(|f| self.meets(view.corners(*f).map(placed), step)) {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Whether what is in a box of the part's frame reaches into the tool.
    fn meeting(&self, node: &Node, frame: &Rotation, tip: Vec3) -> Meeting {
        let (lo, hi) = node.extent();
        let half = [0, 1, 2].map(|a| 0.5 * (hi[a] - lo[a]));
        let middle = [0, 1, 2].map(|a| 0.5 * (hi[a] + lo[a]));
        let at = sub(frame.map(|row| dot(row, middle)), tip);
        let reach = frame.map(|row| row[0].abs() * half[0] + row[1].abs() * half[1] + row[2].abs() * half[2]);
        let squared = |way: f64| {
            let off = [0, 1].map(|a| (at[a].abs() + way * reach[a]).max(0.0));
            off[0] * off[0] + off[1] * off[1]
        };
        self.meeting_between([at[2] - reach[2], at[2] + reach[2]], squared(-1.0), || squared(1.0))
    }

    /// Whether what is between two heights reaches into the tool, of which the squared distance of the nearest and of the farthest possible point from the axis
    /// is known.
    #[inline]
    pub(super) fn meeting_between(&self, [low, high]: [f64; 2], near2: f64, far2: impl Fn() -> f64) -> Meeting {
        match self.largest_within(low, high) {
            Some(r) if near2 < r * r => {
                // None of it is wider than that.
                let far2 = far2();
                let least = if far2 < r * r { self.least_within(low, high) } else { 0.0 };
                if far2 < least * least { Meeting::Surely } else { Meeting::Perhaps }
            }
            _ => Meeting::Never,
        }
    }

    /// The least radius at which the tool is between two heights, 0 where it is not all the way.
    fn least_within(&self, lo: f64, hi: f64) -> f64 {
        let (mut known, mut least) = (lo, f64::INFINITY);
        for (n, p) in self.pieces().iter().enumerate() {
            let to = if n + 1 == self.pieces().len() { f64::INFINITY } else { p.to };
            if known >= p.from && known < to {
                least = least.min(p.radius(known)).min(p.radius(hi.min(to)));
                known = to;
            }
            if known >= hi {
                return least;
            }
        }
        0.0
    }

    /// The corners of facets that may reach into the tool at a tip, from there.
    pub(super) fn facets_beside(&self, view: &MeshDistance, (frame, tip): (&Rotation, Vec3)) -> Vec<[Vec3; 3]> {
        let placed = |p: Vec3| sub(frame.map(|row| dot(row, p)), tip);
        let (tree, nodes) = (view.tree(), view.tree().nodes());
        let (mut open, mut found) = (vec![0usize], Vec::new());
        while let Some(at) = open.pop() {
            let Some(node) = nodes.get(at) else { continue };
            match (self.meeting(node, frame, tip), node.children()) {
                (Meeting::Never, _) => {}
                (_, Some(children)) => open.extend(children),
                (_, None) => found.extend(tree.order()[node.run()].iter().map(|f| view.corners(*f).map(placed))),
            }
        }
        found
    }

    /// Whether a triangle in the tool's frame reaches into it.
    pub(super) fn meets(&self, corners: [Vec3; 3], step: f64) -> bool {
        (0..self.pieces().len()).any(|n| self.piece_meets(n, &corners, step))
    }

    /// Whether a triangle in the tool's frame reaches into one of its pieces.
    pub(super) fn piece_meets(&self, n: usize, corners: &[Vec3; 3], step: f64) -> bool {
        let Some(p) = self.pieces().get(n) else { return false };
        let (lo, hi) = corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c[2]), h.max(c[2])));
        let to = if n + 1 == self.pieces().len() { f64::INFINITY } else { p.to };
        if lo >= to || hi <= p.from {
            return false;
        }
        match p.outline {
            Outline::LowerBall { radius } | Outline::Ball { radius } => {
                is_in_ball(corners, [p.from, p.to], ([0.0, 0.0, p.from + radius], radius))
                    || to > p.to && is_about_axis(corners, [p.to, to], p.radius(p.to))
            }
            Outline::Straight { lower, upper } => {
                let slices = ((upper - lower).abs() / step).ceil().clamp(1.0, SLICES);
                let at = |k: f64| p.from + (p.to - p.from) * k / slices;
                (0..slices as usize)
                    .map(|k| k as f64)
                    .any(|k| is_about_axis(corners, [at(k), at(k + 1.0)], p.radius(0.5 * (at(k) + at(k + 1.0)))))
                    || to > p.to && is_about_axis(corners, [p.to, to], upper)
            }
        }
    }
}

/// Corners of a triangle cut twice, at most: one that is cut so obliquely that its corners seem to alternate counts too.
const MOST_CORNERS: usize = 6;

/// A convex polygon of few corners.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [Vec3; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    fn push(&mut self, p: Vec3) {
        if let Some(free) = self.corners.get_mut(self.count) {
            *free = p;
            self.count += 1;
        }
    }

    /// What of it lies where a height above something is not negative.
    fn cut(polygon: &[Vec3], height: impl Fn(Vec3) -> f64) -> Polygon {
        let mut left = Polygon { corners: [[0.0; 3]; MOST_CORNERS], count: 0 };
        for (n, &p) in polygon.iter().enumerate() {
            let q = polygon[(n + 1) % polygon.len()];
            let (a, b) = (height(p), height(q));
            if a >= 0.0 {
                left.push(p);
            }
            if (a < 0.0) != (b < 0.0) {
                left.push(along(p, sub(q, p), a / (a - b)));
            }
        }
        left
    }
}

/// What of a triangle lies between two heights; `None` where nothing does.
fn between(corners: &[Vec3; 3], lo: f64, hi: f64) -> Option<Polygon> {
    let above = Polygon::cut(corners, |p| p[2] - lo);
    let met = if hi.is_finite() { Polygon::cut(above.corners(), |p| hi - p[2]) } else { above };
    (met.count > 0).then_some(met)
}

/// Whether what of a triangle lies between two heights comes into a ball.
fn is_in_ball(corners: &[Vec3; 3], [lo, hi]: [f64; 2], (centre, radius): (Vec3, f64)) -> bool {
    let nearest = closest_point(centre, *corners);
    if norm(sub(nearest, centre)) >= radius {
        return false;
    }
    let distance_to = |polygon: Polygon| {
        let first = polygon.corners[0];
        let fan = polygon.corners().windows(2).map(|w| norm(sub(closest_point(centre, [first, w[0], w[1]]), centre)));
        fan.fold(norm(sub(first, centre)), f64::min)
    };
    (lo..=hi).contains(&nearest[2]) || between(corners, lo, hi).is_some_and(|met| distance_to(met) < radius)
}

/// Whether a triangle, where it lies between two heights, comes nearer to the axis than a radius.
fn is_about_axis(corners: &[Vec3; 3], [lo, hi]: [f64; 2], radius: f64) -> bool {
    let off = [0, 1].map(|a| {
        let (least, most) =
            corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), c| (l.min(c[a]), m.max(c[a])));
        least.max(-most).max(0.0)
    });
    if off[0] * off[0] + off[1] * off[1] >= radius * radius {
        return false;
    }
    let Some(met) = between(corners, lo, hi) else { return false };
    let flat = met.corners();
    let next = |n: usize| flat[(n + 1) % flat.len()];
    let turn = |n: usize| flat[n][0] * next(n)[1] - flat[n][1] * next(n)[0];
    let turns = || (0..flat.len()).map(turn);
    if flat.len() > 2 && (turns().all(|t| t > 0.0) || turns().all(|t| t < 0.0)) {
        return radius > 0.0;
    }
    let level = |p: Vec3| [p[0], p[1]];
    (0..flat.len()).any(|n| to_origin(level(flat[n]), level(next(n))) < radius * radius)
}

/// The squared distance of a segment in the plane to the origin.
fn to_origin(a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length2 = along[0] * along[0] + along[1] * along[1];
    let t = if length2 > 0.0 { (-(a[0] * along[0] + a[1] * along[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let [x, y] = [a[0] + t * along[0], a[1] + t * along[1]];
    x * x + y * y
}

#[cfg(test)]
mod tests {
    use super::super::meridian::Role;
    use super::*;
    use crate::geometry::cuboid;
    use crate::random::Lcg;

    const UPRIGHT: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn straight(role: Role, from: f64, to: f64, lower: f64, upper: f64) -> Piece {
        Piece { role, from, to, outline: Outline::Straight { lower, upper } }
    }

    /// A ball end of 2 mm, a cone from there, and a holder.
    fn tool() -> Meridian {
        let ball = Piece { role: Role::Cutter, from: 0.0, to: 2.0, outline: Outline::LowerBall { radius: 2.0 } };
        let cone = straight(Role::Neck, 2.0, 8.0, 2.0, 4.0);
        Meridian::new(vec![ball, cone, straight(Role::Holder, 8.0, 12.0, 7.0, 7.0)])
    }

    #[test]
    fn a_tool_is_clear_where_no_point_of_a_facet_lies_in_it() {
        let mut random = Lcg(5);
        let (tool, mut met) = (tool(), [0; 2]);
        for _ in 0..3000 {
            let corners = [0; 3].map(|_| {
                let [x, y, z] = random.point(-9.0, 9.0);
                [x, y, z + 6.0]
            });
            // By points: a 40th of the way from one to the next is 0.6 mm at most.
            let inside = |p: Vec3, by: f64| {
                let z = p[2].min(12.0);
                tool.pieces().iter().any(|q| (q.from..=q.to).contains(&z) && p[0].hypot(p[1]) < q.radius(z) - by)
            };
            let points = (0..=40).flat_map(|i| (0..=40 - i).map(move |j| [f64::from(i) / 40.0, f64::from(j) / 40.0]));
            let points: Vec<Vec3> = points
                .map(|[u, v]| [0, 1, 2].map(|a| (1.0 - u - v) * corners[0][a] + u * corners[1][a] + v * corners[2][a]))
                .collect();
            let told = tool.meets(corners, 0.02);
            met[usize::from(told)] += 1;
            assert!(told || !points.iter().any(|p| inside(*p, 0.02)), "{corners:?}");
            // What is told to be met is, but for what slips between the points.
            assert!(!told || points.iter().any(|p| inside(*p, -0.62)), "{corners:?}");
        }
        assert!(met[0] > 300 && met[1] > 300, "{met:?}");
    }

    #[test]
    fn what_reaches_in_by_less_than_it_is_thinner_keeps_clear() {
        let block = MeshDistance::new(&cuboid([0.0; 3], [20.0, 20.0, 10.0]));
        let thin = tool().thinner(0.05);
        // On the top, beside the wall with the ball's side, and with the holder over the edge.
        for (tip, clear) in [
            ([10.0, 10.0, 10.0], true),
            ([10.0, 10.0, 9.96], true),
            ([10.0, 10.0, 9.94], false),
            ([-2.34, 10.0, 7.0], true),
            ([-2.2, 10.0, 7.0], false),
            ([-6.96, 10.0, 1.0], true),
            ([-6.94, 10.0, 1.0], false),
            ([-5.0, 10.0, 2.03], true),
            ([-5.0, 10.0, 1.9], false),
        ] {
            assert_eq!(thin.is_clear(&block, (&UPRIGHT, tip), 0.01), clear, "{tip:?}");
        }
    }
}
