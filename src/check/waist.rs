//! Waists: what is thin from all sides and joins two pieces that are thicker, of material or of void.

use super::sheet::{Sheets, TOUCH};
use super::sheet_shape::{Sheet, waist_of};
use super::sheet_thinnest::Sought;
use crate::geometry::vector::{Vec3, add, bounds, cross, distance, scale, sub, unit};
use crate::medial::cluster::principal_extents;
use crate::medial::section::across;
use crate::medial::{Cover, Sample, Shape};
use rustc_hash::FxHashMap;

/// Balls whose centres extend by more than so many diameters of the largest go along a wall.
const WIDTHS: f64 = 1.5;
/// Ways across a ball's contacts that it may be held along.
const ASIDE: usize = 12;

impl Sheets<'_> {
    /// What was found where edges go round, parted into walls and what may be waists: the balls of a wall whose sides bend towards them
    /// everywhere touch edges alone, and lie side by side; those around a waist are as good as one.
    pub(super) fn at_edges(&self, cover: &Cover, below: f64) -> [Vec<Sample>; 2] {
        let found: Vec<Sample> = self.own(cover, Shape::Waist).into_iter().filter(|s| s.diameter < below).collect();
        let [mut walls, mut waists] = [Vec::new(), Vec::new()];
        for samples in self.groups(&found) {
            let thickest = samples.iter().map(|s| s.diameter).fold(0.0, f64::max);
            let [long, ..] = principal_extents(&samples.iter().map(|s| s.centre).collect::<Vec<_>>());
            match long > WIDTHS * thickest {
                true => walls.extend(samples.into_iter().map(|s| Sample { shape: Shape::Sheet, ..s })),
                false => waists.extend(samples),
            }
        }
        [walls, waists]
    }

    /// The waists that are thinner than all sheets beside them; a wedge beside one is none.
    pub(super) fn waists(
        &self,
        found: Vec<Sample>,
        sheets: &[(Sheet, Vec<Sample>)],
        [fail, warn]: [f64; 2],
    ) -> Vec<(Sheet, Vec<Sample>)> {
        let beside = sheets.iter().flat_map(|(_, samples)| samples);
        let waists = thinner(found, beside, 1.5 * self.resolution());
        let mut found = Vec::new();
        for (from, to) in [(0.0, fail), (fail.max(0.0), warn)] {
            let level: Vec<Sample> = waists.iter().filter(|s| s.diameter >= from && s.diameter < to).copied().collect();
            for samples in self.groups(&level) {
                let waist = waist_of(&samples).filter(|s| self.is_waist(s));
                found.extend(waist.map(|sheet| (sheet, samples)));
            }
        }
        found
    }

    /// Leaves out waists beside a sheet that is as thin, once that is known: they are places of it.
    pub(super) fn leave_known_waists(&self, sought: &mut Vec<Sought>) {
        let is_waist = |s: &Sought| s.samples.first().is_some_and(|s| s.shape == Shape::Waist);
        let sheets = sought.iter().filter(|s| !is_waist(s)).filter_map(|s| s.sheet.as_ref());
        let known: Vec<Sample> = sheets.map(|sheet| sheet.thinnest).collect();
        let is_known = |s: &Sheet| {
            let at = s.thinnest;
            known
                .iter()
                .any(|k| k.diameter < at.diameter + TOUCH && distance(k.centre, at.centre) <= 1.5 * self.resolution())
        };
        sought.retain(|s| !(is_waist(s) && s.sheet.as_ref().is_some_and(is_known)));
    }

    /// Whether what is thin from all sides joins two pieces that are thicker, of material or of void: it goes on along its axis by more than it is wide.
    pub(super) fn is_waist(&self, Sheet { thinnest, axis, .. }: &Sheet) -> bool {
        let is_free = |way: Vec3| !self.ends_within(thinnest.centre, way, thinnest.diameter);
        let goes_on = |axis: Vec3| is_free(axis) && is_free(scale(axis, -1.0));
        match axis {
            Some(axis) => goes_on(*axis),
            // Where one ball alone has opposite contacts, the surface holds it aside too.
            None => {
                let way = unit(sub(thinnest.contacts[1], thinnest.contacts[0]));
                let [u, v] = across(way);
                let aside = (0..ASIDE).map(|k| {
                    let (s, c) = (std::f64::consts::PI * k as f64 / ASIDE as f64).sin_cos();
                    add(scale(u, c), scale(v, s))
                });
                let narrow =
                    |w: Vec3| [w, scale(w, -1.0)].iter().all(|&w| self.ends_within(thinnest.centre, w, self.widest()));
                aside.into_iter().any(|w| narrow(w) && goes_on(cross(way, w)))
            }
        }
    }

    fn ends_within(&self, from: Vec3, way: Vec3, far: f64) -> bool {
        self.part.distance().first_hit(from, way, 0.0, far).is_some()
    }
}

/// The samples that are thinner than all others within about a distance.
fn thinner<'s>(mut samples: Vec<Sample>, others: impl Iterator<Item = &'s Sample>, distance: f64) -> Vec<Sample> {
    if samples.is_empty() {
        return samples;
    }
    let cell = |p: Vec3| p.map(|x| (x / distance).floor() as i64);
    let mut least: FxHashMap<[i64; 3], f64> = FxHashMap::default();
    for other in others {
        // A long patch is one sample: its ball rolls all along it.
        let sides = bounds([other.sides.0, other.sides.1, other.centre]).unwrap_or((other.centre, other.centre));
        let (lo, hi) = (cell(sides.0), cell(sides.1));
        for x in lo[0]..=hi[0] {
            for (y, z) in (lo[1]..=hi[1]).flat_map(|y| (lo[2]..=hi[2]).map(move |z| (y, z))) {
                let known = least.entry([x, y, z]).or_insert(f64::INFINITY);
                *known = known.min(other.diameter);
            }
        }
    }
    let is_thinner = |s: &Sample| {
        let [x, y, z] = cell(s.centre);
        let beside = (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        beside.into_iter().all(|c| least.get(&c).is_none_or(|&d| s.diameter < d - TOUCH))
    };
    samples.retain(is_thinner);
    samples
}
