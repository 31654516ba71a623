//! Bodies of one part that are one body of another: a joint that was closed, which no check of the other part tells.

use super::schema::{Axis3, BodyReport, PartReport};
use crate::check::Finding;
use std::cmp::Ordering;

/// Kinds of finding that are about two bodies and are gone where these are one.
const BETWEEN: [&str; 4] = ["gap-between-bodies", "fused", "hole-closed", "merged"];
/// Bodies whose boxes have less than this share in common, times the ratio of their volumes, are different ones.
const STILL: f64 = 0.25;

/// The bodies of an old part, moved to where the new one lies, and those of the new one.
pub(super) struct Bodies {
    old: Vec<BodyReport>,
    new: Vec<BodyReport>,
    /// For each new body the old one that it still is, if it is one.
    still: Vec<Option<usize>>,
    are_fewer: bool,
    tolerance: f64,
}

impl Bodies {
    /// # Cost
    /// O(m·n) for m and n bodies.
    pub fn of(old: &PartReport, new: &PartReport, by: Axis3, tolerance: f64) -> Self {
        let are_fewer = new.bodies < old.bodies;
        let (old, new) = (listed(old), listed(new));
        let moved = |b: BodyReport| BodyReport { box_mm: b.box_mm.map(|p| [0, 1, 2].map(|a| p[a] + by[a])), ..b };
        let old: Vec<BodyReport> = old.into_iter().map(moved).collect();
        let still = paired(&old, &new, tolerance);
        Bodies { old, new, still, are_fewer, tolerance }
    }

    /// The bodies that a finding of the old part is between and that are one body now, by their numbers; none where it is between none, or these are apart
    /// or were taken out.
    ///
    /// A new body is several old ones if its box covers theirs, none of them is another body now, and it holds as much as one of them and half
    /// of another: a block keeps its box, and not the volume of its pin, when the pin is taken out.
    pub fn now_one(&self, f: &Finding) -> Option<Vec<u64>> {
        let numbers = f.bodies.as_ref().filter(|_| BETWEEN.contains(&f.kind.as_str()))?;
        let between: Vec<usize> = numbers.iter().filter_map(|n| usize::try_from(n.checked_sub(1)?).ok()).collect();
        let mut found = (0..self.new.len()).filter_map(|n| self.joined_in(n, &between));
        found.next().map(|members| members.into_iter().map(|i| i as u64 + 1).collect())
    }

    /// Whether a finding is between bodies of which nobody knows what became: there are fewer, and a report lists none of them.
    pub fn may_be_one(&self, f: &Finding) -> bool {
        BETWEEN.contains(&f.kind.as_str()) && self.are_fewer && (self.old.is_empty() || self.new.is_empty())
    }

    /// Those of some old bodies that a new one is made of, if there are several.
    fn joined_in(&self, new: usize, between: &[usize]) -> Option<Vec<usize>> {
        let whole = self.new.get(new)?;
        let own = self.still[new];
        let is_another = |i: usize| self.still.iter().enumerate().any(|(n, s)| n != new && *s == Some(i));
        let covered = |i: &usize| self.old.get(*i).is_some_and(|b| covers(whole, b, self.tolerance));
        let members: Vec<usize> = between.iter().copied().filter(|i| covered(i) && !is_another(*i)).collect();
        let volume = |i: usize| self.old.get(i).map_or(0.0, |b| b.volume_mm3);
        let largest = || members.iter().copied().max_by(|a, b| volume(*a).total_cmp(&volume(*b)));
        let first = own.filter(|i| members.contains(i)).or_else(largest)?;
        let others = members.iter().copied().filter(|i| *i != first);
        let least = others.min_by(|a, b| volume(*a).total_cmp(&volume(*b)))?;
        let beside = own.filter(|i| *i != first).map_or(0.0, volume);
        (whole.volume_mm3 >= beside + volume(first) + 0.5 * volume(least)).then_some(members)
    }
}

/// The bodies of a part, where its report tells them.
fn listed(part: &PartReport) -> Vec<BodyReport> {
    match part.bodies {
        1 => vec![BodyReport { box_mm: part.box_mm, volume_mm3: part.volume_mm3.value }],
        _ => part.each_body.clone(),
    }
}

fn covers(whole: &BodyReport, of: &BodyReport, tolerance: f64) -> bool {
    let ([lo, hi], [from, to]) = (whole.box_mm, of.box_mm);
    (0..3).all(|a| lo[a] <= from[a] + tolerance && to[a] <= hi[a] + tolerance)
}

/// For each new body the old one that it is most alike, each taken once, the most alike first.
fn paired(old: &[BodyReport], new: &[BodyReport], tolerance: f64) -> Vec<Option<usize>> {
    let mut pairs = Vec::new();
    for (i, a) in old.iter().enumerate() {
        let near = new.iter().enumerate().map(|(n, b)| (likeness(a, b, tolerance), i, n));
        pairs.extend(near.filter(|(alike, _, _)| *alike >= STILL));
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut still, mut taken) = (vec![None; new.len()], vec![false; old.len()]);
    for (_, i, n) in pairs {
        if still[n].is_none() && !taken[i] {
            (still[n], taken[i]) = (Some(i), true);
        }
    }
    still
}

/// How alike two bodies are, at most 1: the share that their boxes have in common, times the ratio of their volumes.
fn likeness(a: &BodyReport, b: &BodyReport, tolerance: f64) -> f64 {
    // Flat boxes have no volume to share.
    let length = |lo: f64, hi: f64| (hi - lo).max(0.0) + tolerance;
    let common: f64 = (0..3)
        .map(|x| {
            let (lo, hi) = (a.box_mm[0][x].max(b.box_mm[0][x]), a.box_mm[1][x].min(b.box_mm[1][x]));
            if lo > hi + tolerance { 0.0 } else { length(lo, hi) }
        })
        .product();
    let own = |b: &BodyReport| (0..3).map(|x| length(b.box_mm[0][x], b.box_mm[1][x])).product::<f64>();
    let [small, large] = match a.volume_mm3.partial_cmp(&b.volume_mm3) {
        Some(Ordering::Greater) => [b.volume_mm3, a.volume_mm3],
        _ => [a.volume_mm3, b.volume_mm3],
    };
    let ratio = if large > 0.0 { (small / large).max(0.0) } else { 1.0 };
    common / (own(a) + own(b) - common) * ratio
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Basis, Bracket, Limits, Sense};

    fn body(lo: Axis3, hi: Axis3, volume_mm3: f64) -> BodyReport {
        BodyReport { box_mm: [lo, hi], volume_mm3 }
    }

    /// A block with a bore, the pin in it, and a frame around both.
    fn old() -> Vec<BodyReport> {
        vec![
            body([0.0; 3], [20.0, 20.0, 10.0], 3000.0),
            body([5.0, 5.0, 0.0], [15.0, 15.0, 14.0], 900.0),
            body([-50.0; 3], [50.0; 3], 9000.0),
        ]
    }

    fn now_one(new: &[BodyReport], bodies: &[u64]) -> Option<Vec<u64>> {
        let limits = Limits { fail: Some(0.3), warn: None, sense: Sense::Min };
        let mut gap =
            Finding::judged("AM103", "gap-between-bodies", Bracket::exact(0.1), Basis::Exact, limits, "mm", 0.0);
        gap.bodies = Some(bodies.to_vec());
        let (old, new) = (old(), new.to_vec());
        let still = paired(&old, &new, 0.2);
        Bodies { old, new, still, are_fewer: true, tolerance: 0.2 }.now_one(&gap)
    }

    #[test]
    fn a_pin_that_is_welded_is_one_with_its_block_and_one_that_was_taken_out_is_not() {
        let [block, pin, frame] = [old()[0], old()[1], old()[2]];
        let welded = body([0.0; 3], [20.0, 20.0, 14.0], 3950.0);
        assert_eq!(now_one(&[welded, frame], &[1, 2]), Some(vec![1, 2]));
        assert_eq!(now_one(&[frame, welded], &[1, 2, 3]), Some(vec![1, 2]));
        assert_eq!(now_one(&[block, frame], &[1, 2]), None);
        assert_eq!(now_one(&[block, pin, frame], &[1, 2]), None);
        // The pin is thinner and the block larger.
        let larger = body([-5.0, -5.0, 0.0], [25.0, 25.0, 20.0], 9000.0);
        let thinner = body([5.4, 5.4, 0.0], [14.6, 14.6, 14.0], 760.0);
        assert_eq!(now_one(&[larger, thinner, frame], &[1, 2]), None);
        // Only the frame is left, and then all are one.
        assert_eq!(now_one(&[frame], &[1, 2]), None);
        assert_eq!(now_one(&[BodyReport { volume_mm3: 13_000.0, ..frame }], &[1, 2]), Some(vec![1, 2]));
    }
}
