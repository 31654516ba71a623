//! Which places of one report are places of another.

use super::schema::Axis3;
use crate::check::{Finding, Spot};
use std::collections::BTreeMap;

/// The check whose findings count over the whole mesh, and stand at the worst of what they count, whichever of equals that is.
const OVER_ALL: &str = "AM001";

/// A finding with the name of its check.
pub(super) type Named<'a> = (&'a str, &'a Finding);

/// The places of one list of findings, each with the one that it is of the other list.
pub(super) struct Places {
    /// For each finding the places it stands for.
    pub spots: Vec<Vec<Spot>>,
    /// For each of these the finding of the other list, and its place.
    pub of: Vec<Vec<Option<(usize, usize)>>>,
}

/// Two lists of findings, place by place.
///
/// Places of findings of the same check and kind are taken in pairs, nearest first, if they lie within a tolerance of each other, or one lies in
/// the other's box grown by as much; those of equal fingerprints of which none does, those of counts over the whole mesh, and
/// then those that name no box of their own and lie in the box of all of the other finding, in their order. Each is taken once.
pub(super) struct Matched {
    pub old: Places,
    pub new: Places,
}

impl Places {
    fn of(list: &[Named]) -> Self {
        let spots: Vec<Vec<Spot>> = list.iter().map(|(_, f)| f.spots()).collect();
        Places { of: spots.iter().map(|s| vec![None; s.len()]).collect(), spots }
    }

    /// Places of a finding that are of none yet and name no box, in the box of another finding.
    fn unboxed_within(&self, finding: usize, f: &Finding, of: [Axis3; 2], tolerance: f64) -> Vec<usize> {
        let spots = self.spots[finding].iter().zip(&self.of[finding]).enumerate();
        let left = spots.filter(|(_, (s, of))| of.is_none() && f.box_of(s).is_none());
        left.filter(|(_, (s, _))| is_within(s, of, tolerance)).map(|(k, _)| k).collect()
    }

    /// The finding of the other list that most of a finding's places are of, if one is; the first of equals.
    pub fn most(&self, finding: usize) -> Option<usize> {
        let mut times: BTreeMap<usize, usize> = BTreeMap::new();
        self.of[finding].iter().flatten().for_each(|(i, _)| *times.entry(*i).or_default() += 1);
        let most = *times.values().max()?;
        times.into_iter().find(|(_, n)| *n == most).map(|(i, _)| i)
    }

    /// Places of a finding that are of none of the other list.
    pub fn alone(&self, finding: usize) -> impl Iterator<Item = &Spot> {
        self.spots[finding].iter().zip(&self.of[finding]).filter(|(_, of)| of.is_none()).map(|(s, _)| s)
    }

    /// The places of a finding with those of the other list that they are.
    pub fn with<'a>(&'a self, finding: usize, other: &'a Places) -> impl Iterator<Item = (&'a Spot, &'a Spot)> {
        let pairs = self.spots[finding].iter().zip(&self.of[finding]);
        pairs.filter_map(|(s, of)| of.map(|(i, k)| (s, &other.spots[i][k])))
    }
}

impl Matched {
    /// # Cost
    /// O(m·n) for m and n places of one check.
    pub fn of(before: &[Named], after: &[Named], tolerance: f64) -> Self {
        let [mut old, mut new] = [before, after].map(Places::of);
        let mut pairs = Vec::new();
        for (i, (check, a)) in before.iter().enumerate() {
            for (j, (other, b)) in after.iter().enumerate() {
                if check == other && a.kind == b.kind {
                    let near = nearnesses((a, &old.spots[i]), (b, &new.spots[j]), tolerance);
                    pairs.extend(near.into_iter().map(|(d, k, l)| (d, (i, k), (j, l))));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        for (_, (i, k), (j, l)) in pairs {
            if old.of[i][k].is_none() && new.of[j][l].is_none() {
                (old.of[i][k], new.of[j][l]) = (Some((j, l)), Some((i, k)));
            }
        }
        for (i, (check, a)) in before.iter().enumerate() {
            for (j, (other, b)) in after.iter().enumerate() {
                if check == other && a.kind == b.kind {
                    let left = [(a, &old, i, b), (b, &new, j, a)]
                        .map(|(f, own, n, of)| own.unboxed_within(n, f, of.box_mm, tolerance));
                    for (k, l) in left[0].iter().copied().zip(left[1].iter().copied()) {
                        (old.of[i][k], new.of[j][l]) = (Some((j, l)), Some((i, k)));
                    }
                }
            }
        }
        Matched { old, new }
    }
}

/// Whether a place lies in a box grown by a tolerance.
fn is_within(p: &Spot, [lo, hi]: [Axis3; 2], tolerance: f64) -> bool {
    (0..3).all(|x| p.at_mm[x] >= lo[x] - tolerance && p.at_mm[x] <= hi[x] + tolerance)
}

/// Pairs of places of two findings that may be the same, each with its distance.
fn nearnesses(
    (a, olds): (&Finding, &[Spot]),
    (b, news): (&Finding, &[Spot]),
    tolerance: f64,
) -> Vec<(f64, usize, usize)> {
    let mut found = Vec::new();
    for (k, s) in olds.iter().enumerate() {
        for (l, t) in news.iter().enumerate() {
            let distance = (0..3).map(|x| (s.at_mm[x] - t.at_mm[x]).powi(2)).sum::<f64>().sqrt();
            let in_box = |p: &Spot, f: &Finding, of: &Spot| f.box_of(of).is_some_and(|b| is_within(p, b, tolerance));
            if distance <= tolerance || in_box(t, a, s) || in_box(s, b, t) {
                found.push((distance, k, l));
            }
        }
    }
    // A finding that was moved as a whole has its places in the same order; a count has one.
    let named = !a.fingerprint.is_empty() && a.fingerprint == b.fingerprint || a.code == OVER_ALL;
    if found.is_empty() && named && olds.len() == news.len() {
        found.extend((0..olds.len()).map(|k| (f64::INFINITY, k, k)));
    }
    found
}
