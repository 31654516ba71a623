//! The triangulation of a facet by points and segments in it, exactly.

use super::exact::{Exact, turn};
use rustc_hash::FxHashMap;
use std::cmp::Ordering;
use std::collections::VecDeque;

/// A triangulation of points, counter-clockwise in two axes.
pub(super) struct Net<'a> {
    points: &'a [Exact],
    axes: [usize; 2],
    triangles: Vec<[u32; 3]>,
    /// The triangle to the left of each edge from point to point.
    left_of: FxHashMap<[u32; 2], u32>,
    /// A triangle at each point.
    at: FxHashMap<u32, u32>,
    /// Where the next search starts, and what chooses its turns.
    last: u32,
    chance: u32,
}

/// Where a point lies in a triangulation.
enum Found {
    Within(u32),
    /// On an edge of the triangle to its left.
    On([u32; 2]),
    AtVertex,
}

impl<'a> Net<'a> {
    /// The triangulation of a triangle of points, counter-clockwise, by points within it or on its border and segments between any of
    /// them that cross each other nowhere else; `None` if they do, or if a point lies outside.
    ///
    /// # Cost
    /// A walk for each point, from the one before, and for each segment the edges that it crosses, more than once where they are in each
    /// other's way.
    ///
    /// # Source
    /// O. Devillers, S. Pion, M. Teillaud, Walking in a triangulation, 2002; S. W. Sloan, A fast algorithm for generating constrained
    /// Delaunay triangulations, 1993, for segments by flips.
    pub(super) fn of(
        (points, axes): (&'a [Exact], [usize; 2]),
        corners: [u32; 3],
        within: &[u32],
        segments: &[[u32; 2]],
    ) -> Option<Vec<[u32; 3]>> {
        let (triangles, left_of, at) = Default::default();
        let mut net = Net { points, axes, triangles, left_of, at, last: 0, chance: 1 };
        net.add(corners);
        within.iter().try_for_each(|&p| net.insert(p))?;
        segments.iter().try_for_each(|&ends| net.draw(ends))?;
        Some(net.triangles)
    }

    fn turn(&self, [a, b, c]: [u32; 3]) -> Ordering {
        let point = |p: u32| self.points.get(p as usize);
        match (point(a), point(b), point(c)) {
            (Some(a), Some(b), Some(c)) => turn(self.axes, [a, b, c]),
            _ => Ordering::Equal,
        }
    }

    fn add(&mut self, triangle: [u32; 3]) {
        self.triangles.push(triangle);
        self.put(self.triangles.len() as u32 - 1, triangle);
    }

    /// Takes a triangle in the place of another.
    fn put(&mut self, place: u32, [a, b, c]: [u32; 3]) {
        if let Some(known) = self.triangles.get_mut(place as usize) {
            *known = [a, b, c];
        }
        [[a, b], [b, c], [c, a]].into_iter().for_each(|edge| _ = self.left_of.insert(edge, place));
        [a, b, c].into_iter().for_each(|p| _ = self.at.insert(p, place));
        self.last = place;
    }

    /// The corner of the triangle to the left of an edge that is not on it.
    fn apex(&self, [a, b]: [u32; 2]) -> Option<u32> {
        let triangle = self.triangles.get(*self.left_of.get(&[a, b])? as usize)?;
        triangle.iter().copied().find(|&p| p != a && p != b)
    }

    fn insert(&mut self, p: u32) -> Option<()> {
        match self.find(p)? {
            Found::AtVertex => {}
            Found::Within(triangle) => {
                let [a, b, c] = *self.triangles.get(triangle as usize)?;
                self.put(triangle, [a, b, p]);
                self.add([b, c, p]);
                self.add([c, a, p]);
            }
            Found::On([a, b]) => {
                for [a, b] in [[a, b], [b, a]] {
                    let Some(&place) = self.left_of.get(&[a, b]) else { continue };
                    let apex = self.apex([a, b])?;
                    self.left_of.remove(&[a, b]);
                    self.put(place, [a, p, apex]);
                    self.add([p, b, apex]);
                }
            }
        }
        Some(())
    }

    /// Where a point lies: a walk towards it that turns by chance where it may turn either way, and so ends.
    fn find(&mut self, p: u32) -> Option<Found> {
        let mut place = self.last;
        loop {
            let [a, b, c] = *self.triangles.get(place as usize)?;
            self.chance = self.chance.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let mut edges = [[a, b], [b, c], [c, a]];
            edges.rotate_left((self.chance >> 16) as usize % 3);
            let sides = edges.map(|[a, b]| self.turn([a, b, p]));
            if let Some(out) = (0..3).find(|&i| sides[i].is_lt()) {
                let [a, b] = edges[out];
                place = *self.left_of.get(&[b, a])?;
                continue;
            }
            let on: Vec<[u32; 2]> = (0..3).filter(|&i| sides[i].is_eq()).map(|i| edges[i]).collect();
            return Some(match on[..] {
                [] => Found::Within(place),
                [edge] => Found::On(edge),
                _ => Found::AtVertex,
            });
        }
    }

    /// Makes a segment a chain of edges.
    fn draw(&mut self, [mut from, to]: [u32; 2]) -> Option<()> {
        while from != to {
            from = self.draw_on(from, to)?;
        }
        Some(())
    }

    /// Makes what a segment has before the next point on it an edge; returns that point.
    fn draw_on(&mut self, from: u32, to: u32) -> Option<u32> {
        let mut crossed = VecDeque::new();
        let end = match self.ahead(from, to)? {
            Ahead::Point(p) => p,
            Ahead::Edge([mut a, mut b]) => loop {
                crossed.push_back([a, b]);
                // Beyond the edge, a to the right of the segment and b to the left.
                let apex = self.apex([b, a])?;
                match self.turn([from, to, apex]) {
                    Ordering::Equal => break apex,
                    Ordering::Greater => b = apex,
                    Ordering::Less => a = apex,
                }
            },
        };
        self.flip_away(crossed, [from, end])?;
        Some(end)
    }

    /// What is met first on the way from a point to another.
    fn ahead(&self, from: u32, to: u32) -> Option<Ahead> {
        let start = *self.at.get(&from)?;
        for step in [Self::next_left, Self::next_right] {
            let mut place = Some(start);
            while let Some(now) = place {
                let [a, b] = self.opposite(now, from)?;
                for p in [a, b] {
                    if p == to || self.turn([from, to, p]).is_eq() && self.is_between(from, p, to) {
                        return Some(Ahead::Point(p));
                    }
                }
                if self.turn([from, to, a]).is_lt() && self.turn([from, to, b]).is_gt() {
                    return Some(Ahead::Edge([a, b]));
                }
                place = step(self, from, [a, b]).filter(|&next| next != start);
            }
        }
        None
    }

    fn next_left(&self, from: u32, [_, b]: [u32; 2]) -> Option<u32> {
        self.left_of.get(&[from, b]).copied()
    }

    fn next_right(&self, from: u32, [a, _]: [u32; 2]) -> Option<u32> {
        self.left_of.get(&[a, from]).copied()
    }

    /// The edge of a triangle that is opposite to a corner of it.
    fn opposite(&self, place: u32, corner: u32) -> Option<[u32; 2]> {
        let [a, b, c] = *self.triangles.get(place as usize)?;
        [(a, [b, c]), (b, [c, a]), (c, [a, b])].into_iter().find(|(p, _)| *p == corner).map(|(_, edge)| edge)
    }

    /// Whether a point on the line through two others lies between them.
    fn is_between(&self, from: u32, p: u32, to: u32) -> bool {
        let point = |p: u32| self.points.get(p as usize);
        let (Some(from), Some(p), Some(to)) = (point(from), point(p), point(to)) else { return false };
        let axis = if from.compare(to, self.axes[0]).is_ne() { self.axes[0] } else { self.axes[1] };
        p.compare(from, axis) == to.compare(from, axis) && p.compare(to, axis) == from.compare(to, axis)
    }

    /// Flips edges until none crosses a segment any more; each has its right end first.
    fn flip_away(&mut self, mut crossed: VecDeque<[u32; 2]>, [from, to]: [u32; 2]) -> Option<()> {
        let mut passed_over = 0;
        let mut flips = 16 * (crossed.len() + 2) * (crossed.len() + 2);
        while let Some([a, b]) = crossed.pop_front() {
            let (p, q) = (self.apex([a, b])?, self.apex([b, a])?);
            // The quadrilateral a q b p: what it is cut along instead has to lie within it.
            if !(self.turn([p, q, a]).is_lt() && self.turn([p, q, b]).is_gt()) {
                crossed.push_back([a, b]);
                passed_over += 1;
                if passed_over > crossed.len() {
                    return None;
                }
                continue;
            }
            (passed_over, flips) = (0, flips.checked_sub(1)?);
            let places = [*self.left_of.get(&[a, b])?, *self.left_of.get(&[b, a])?];
            [[a, b], [b, a]].iter().for_each(|edge| _ = self.left_of.remove(edge));
            self.put(places[0], [p, q, b]);
            self.put(places[1], [q, p, a]);
            let sides = [p, q].map(|x| if x == from || x == to { Ordering::Equal } else { self.turn([from, to, x]) });
            match sides {
                [Ordering::Less, Ordering::Greater] => crossed.push_back([p, q]),
                [Ordering::Greater, Ordering::Less] => crossed.push_back([q, p]),
                _ => {}
            }
        }
        Some(())
    }
}

/// What is met first on a way through a triangulation: a point, or an edge with its right end first.
enum Ahead {
    Point(u32),
    Edge([u32; 2]),
}

#[cfg(test)]
mod tests {
    use super::super::contact::crossing;
    use super::*;
    use crate::random::Lcg;

    const AXES: [usize; 2] = [0, 1];

    #[test]
    fn segments_become_edges_and_the_triangles_cover_the_facet_once() {
        let mut random = Lcg(51);
        for round in 0..60 {
            let corner = [[0, 0, 0], [1 << 20, 0, 1 << 18], [0, 1 << 20, 0]];
            let mut points: Vec<Exact> = corner.into_iter().map(Exact::on_lattice).collect();
            for _ in 0..4 + round / 4 {
                // Within, and every third on the border.
                let weights = [0; 3].map(|_| 1 + random.below(9) as u32);
                let weights = if random.below(3) == 0 { [weights[0], weights[1], 0] } else { weights };
                let made = Exact::mean([&points[0], &points[1], &points[2]], weights);
                if !points.contains(&made) {
                    points.push(made);
                }
            }
            let count = points.len() as u32;
            let ends =
                |random: &mut Lcg| [random.below(u64::from(count)) as u32, random.below(u64::from(count)) as u32];
            let segments: Vec<[u32; 2]> = (0..6).map(|_| ends(&mut random)).filter(|[a, b]| a != b).collect();
            for (n, of) in segments.iter().enumerate() {
                for other in &segments[..n] {
                    let at = |[a, b]: [u32; 2]| [points[a as usize].clone(), points[b as usize].clone()];
                    let ([a, b], [c, d]) = (at(*of), at(*other));
                    if let Some(met) = crossing(AXES, [&a, &b], [&c, &d]).filter(|p| !points.contains(p)) {
                        points.push(met);
                    }
                }
            }
            let within: Vec<u32> = (3..points.len() as u32).collect();
            let made = Net::of((&points, AXES), [0, 1, 2], &within, &segments).expect("a triangulation");
            let near = |p: u32| points[p as usize].near();
            let area = |[a, b, c]: [u32; 3]| {
                let [p, q, r] = [near(a), near(b), near(c)];
                0.5 * ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))
            };
            let sum: f64 = made.iter().map(|t| area(*t)).sum();
            assert!((sum / area([0, 1, 2]) - 1.0).abs() < 1e-9, "{sum}");
            assert!(made.iter().all(|&[a, b, c]| { turn(AXES, [a, b, c].map(|p| &points[p as usize])).is_gt() }));
            // Nothing of a triangle lies on both sides of a segment.
            for &[a, b] in &segments {
                let (from, to) = (&points[a as usize], &points[b as usize]);
                let crosses =
                    |[p, q]: [u32; 2]| crossing(AXES, [from, to], [&points[p as usize], &points[q as usize]]).is_some();
                assert!(!made.iter().any(|&[p, q, r]| crosses([p, q]) || crosses([q, r]) || crosses([r, p])));
            }
        }
    }
}
