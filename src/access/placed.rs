//! The facets of a part in a frame that a coaxial tool stands upright in, and whether it keeps clear of them from many poses.

use super::clearance::Meeting;
use super::meridian::Meridian;
use super::pose::Rotation;
use crate::geometry::MeshDistance;
use crate::geometry::bvh::Bvh;
use crate::geometry::vector::{Vec3, along, bounds, distance, dot, greatest, least, sub};
use rayon::prelude::*;
use std::ops::Range;

/// By so much boxes are taken higher, millimetres: what is level has a height too, and differences are rounded.
const HIGHER: f64 = 1e-9;

/// The facets of a part in a frame.
pub(super) struct Placed<'a> {
    tree: &'a Bvh,
    /// The box of each node of the tree, as tight as in the part's own frame.
    boxes: Vec<[Vec3; 2]>,
    /// In the order of the tree's leaves.
    facets: Vec<[Vec3; 3]>,
}

/// The tips on the ways to some from another, in steps of so much at most, without their ends: step by step from all of them, so that those that follow each
/// other lie near each other.
pub(super) fn ways(to: &[Vec3], from: Vec3, step: f64) -> Vec<Vec3> {
    let steps: Vec<usize> = to.iter().map(|tip| (distance(from, *tip) / step).ceil().max(1.0) as usize).collect();
    let at = |n: usize, tip: &Vec3, steps: usize| along(*tip, sub(from, *tip), n as f64 / steps as f64);
    let each = |n: usize| {
        to.iter().zip(&steps).filter(move |(_, steps)| n < **steps).map(move |(tip, steps)| at(n, tip, *steps))
    };
    (1..steps.iter().copied().max().unwrap_or(0)).flat_map(each).collect()
}

/// The facets that were in the way of poses before, the last ones: what is in the way of one is often in the way of the next.
#[derive(Default)]
pub(super) struct InTheWay {
    facets: [Option<usize>; 4],
    next: usize,
}

impl InTheWay {
    fn note(&mut self, facet: usize) {
        self.facets[self.next] = Some(facet);
        self.next = (self.next + 1) % self.facets.len();
    }
}

/// Tips, halved until each is alone: what is far from all of some need not be asked of each.
struct Halved<'a> {
    tips: &'a [Vec3],
    /// The whole first, then for each that holds more than one tip both halves.
    groups: Vec<Tips>,
}

/// Some of the tips, their box, and where their halves stand.
#[derive(Clone, Copy)]
struct Tips {
    extent: [Vec3; 2],
    from: usize,
    count: usize,
    halves: usize,
}

impl<'a> Halved<'a> {
    fn of(tips: &'a [Vec3]) -> Self {
        let mut groups = Vec::with_capacity(2 * tips.len());
        groups.push(Tips::of(tips, 0..tips.len()));
        let mut next = 0;
        while let Some(&Tips { from, count, .. }) = groups.get(next) {
            if count > 1 {
                groups[next].halves = groups.len();
                let middle = from + count / 2;
                groups.extend([Tips::of(tips, from..middle), Tips::of(tips, middle..from + count)]);
            }
            next += 1;
        }
        Halved { tips, groups }
    }

    fn halves(&self, of: &Tips) -> [usize; 2] {
        [of.halves, of.halves + 1]
    }
}

impl Tips {
    fn of(tips: &[Vec3], run: Range<usize>) -> Self {
        let (lo, hi) = bounds(tips[run.clone()].iter().copied()).unwrap_or_default();
        Tips { extent: [lo, hi], from: run.start, count: run.len(), halves: 0 }
    }
}

/// The longest side of a box.
fn longest([lo, hi]: &[Vec3; 2]) -> f64 {
    (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max)
}

impl<'a> Placed<'a> {
    /// The facets in a frame, whose rows are given.
    ///
    /// # Cost
    /// O(facets), and some 90 bytes for each.
    pub(super) fn of(view: &'a MeshDistance, frame: &Rotation) -> Self {
        let tree = view.tree();
        let place = |f: &u32| view.corners(*f).map(|p| frame.map(|row| dot(row, p)));
        let facets: Vec<[Vec3; 3]> = tree.order().par_iter().map(place).collect();
        let mut boxes = vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; tree.nodes().len()];
        // Children stand behind their parents.
        for (n, node) in tree.nodes().iter().enumerate().rev() {
            boxes[n] = match node.children() {
                Some([l, r]) => [least(boxes[l][0], boxes[r][0]), greatest(boxes[l][1], boxes[r][1])],
                None => {
                    let held = bounds(facets[node.run()].iter().flatten().copied()).unwrap_or_default();
                    [held.0, held.1]
                }
            };
        }
        Placed { tree, boxes, facets }
    }

    /// Whether no facet reaches into a tool that stands at some tips, those that follow each other near each other: what [`Meridian::is_clear`] says of
    /// each of them.
    ///
    /// What was in the way before is asked first.
    ///
    /// # Cost
    /// That of [`Meridian::is_clear`] for the tips near which something may be in the way, and of a few for all the others together.
    pub(super) fn is_clear(&self, (tool, step): (&Meridian, f64), tips: &[Vec3], before: &mut InTheWay) -> bool {
        if tips.is_empty() {
            return true;
        }
        let look = Look { placed: self, tool, widest2: tool.widest().powi(2), step, poses: Halved::of(tips) };
        if before.facets.iter().flatten().any(|&f| look.is_met(f, 0)) {
            return false;
        }
        let in_the_way = look.in_the_way();
        if let Some(Some(facet)) = in_the_way {
            before.note(facet);
        }
        in_the_way.is_none()
    }
}

/// A tool that is looked at from some poses.
struct Look<'a> {
    placed: &'a Placed<'a>,
    tool: &'a Meridian,
    widest2: f64,
    step: f64,
    poses: Halved<'a>,
}

impl Look<'_> {
    /// Whether what is in a box reaches into the tool at tips of a box.
    fn meeting(&self, [lo, hi]: &[Vec3; 2], [first, last]: &[Vec3; 2]) -> Meeting {
        let near = [0, 1].map(|a| (lo[a] - last[a]).max(first[a] - hi[a]).max(0.0));
        let near2 = near[0] * near[0] + near[1] * near[1];
        if near2 >= self.widest2 {
            return Meeting::Never;
        }
        let far2 = || {
            let far = [0, 1].map(|a| (hi[a] - first[a]).max(last[a] - lo[a]));
            far[0] * far[0] + far[1] * far[1]
        };
        self.tool.meeting_between([lo[2] - last[2] - HIGHER, hi[2] - first[2] + HIGHER], near2, far2)
    }

    /// Whether a facet reaches into the tool at any of some tips.
    fn is_met(&self, facet: usize, group: usize) -> bool {
        let tips = &self.poses.groups[group];
        let corners = self.placed.facets[facet];
        let (lo, hi) = bounds(corners).unwrap_or_default();
        if self.meeting(&[lo, hi], &tips.extent) == Meeting::Never {
            return false;
        }
        if tips.count > 1 {
            return self.poses.halves(tips).into_iter().any(|half| self.is_met(facet, half));
        }
        let tip = self.poses.tips[tips.from];
        self.tool.meets(corners.map(|c| sub(c, tip)), self.step)
    }

    /// What reaches into the tool at any of its tips: a facet, where it is one that tells.
    fn in_the_way(&self) -> Option<Option<usize>> {
        let Placed { tree, boxes, .. } = self.placed;
        let mut open = Vec::with_capacity(64);
        open.push((0usize, 0usize));
        while let Some((at, group)) = open.pop() {
            let tips = &self.poses.groups[group];
            let Some((node, held)) = tree.nodes().get(at).zip(boxes.get(at)) else { continue };
            match self.meeting(held, &tips.extent) {
                Meeting::Never => continue,
                Meeting::Surely => return Some(None),
                Meeting::Perhaps => {}
            }
            let apart = tips.count > 1 && longest(&tips.extent) > longest(held);
            match node.children() {
                Some(children) if !apart => open.extend(children.map(|child| (child, group))),
                None if tips.count == 1 => {
                    if let Some(facet) = node.run().find(|&f| self.is_met(f, group)) {
                        return Some(Some(facet));
                    }
                }
                _ => open.extend(self.poses.halves(tips).map(|half| (at, half))),
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::meridian::{Outline, Piece, Role};
    use super::super::pose::{frame_of, lattice_directions};
    use super::*;
    use crate::geometry::Primitive;
    use crate::random::Lcg;
    use crate::units::Length;

    fn straight(role: Role, from: f64, to: f64, lower: f64, upper: f64) -> Piece {
        Piece { role, from, to, outline: Outline::Straight { lower, upper } }
    }

    #[test]
    fn many_poses_at_once_are_clear_where_each_is_by_itself() {
        let ball = |r: f64, to: f64| Piece { role: Role::Cutter, from: 0.0, to, outline: Outline::Ball { radius: r } };
        let probe = vec![ball(1.0, 1.8), straight(Role::Neck, 1.8, 6.0, 0.6, 0.6)];
        let probe = Meridian::new([probe, vec![straight(Role::Holder, 6.0, 9.0, 5.0, 5.0)]].concat());
        let cone = Meridian::new(vec![
            straight(Role::Cutter, 0.0, 2.0, 0.4, 1.5),
            straight(Role::Neck, 2.0, 6.0, 1.5, 1.5),
            straight(Role::Holder, 6.0, 9.0, 4.0, 4.0),
        ]);
        let shape = |r: &str, at: Vec3| {
            let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            Primitive::parse(r).unwrap().mesh(Length::mm(0.02)).transformed(still, at)
        };
        let part = shape("ball:4mm", [0.0; 3]).joined(&shape("box:14x3x2mm", [5.0, 1.0, -3.0]));
        let view = MeshDistance::new(&part);
        let (mut random, mut found) = (Lcg(3), [0; 4]);
        for direction in lattice_directions() {
            let frame = frame_of(direction);
            let placed = Placed::of(&view, &frame);
            for tool in [&probe, &cone] {
                let mut before = InTheWay::default();
                for _ in 0..60 {
                    let to = random.point(-6.5, 6.5);
                    let ends = [to, along(to, random.point(-1.0, 1.0), 0.1)];
                    let between = ways(&ends, along(to, random.point(-1.0, 1.0), 1.5), 0.05);
                    let each = |tip: &Vec3| tool.is_clear(&view, (&frame, *tip), 0.02);
                    for (n, tips) in [&ends[..], &between[..]].into_iter().enumerate() {
                        let want = tips.iter().all(each);
                        assert_eq!(placed.is_clear((tool, 0.02), tips, &mut before), want, "{to:?} {n}");
                        found[usize::from(want) + 2 * n] += 1;
                    }
                }
            }
        }
        assert!(found.iter().all(|&n| n > 300), "{found:?}");
    }
}
