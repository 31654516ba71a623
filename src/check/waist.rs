//! Waists: what is thin from all sides and joins two pieces that are thicker, of material or of void.

use super::sheet::{Sheets, TOUCH};
use super::sheet_shape::{Scale, Sheet, sheet_of, waist_of};
use super::sheet_thinnest::Sought;
use crate::geometry::vector::{Vec3, add, bounds, cross, distance, scale, sub, unit};
use crate::medial::cluster::principal_extents;
use crate::medial::section::across;
use crate::medial::{Cover, Sample, Shape};
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Balls whose centres extend by more than so many diameters of the largest go along a wall.
const WIDTHS: f64 = 1.5;
/// Ways across a ball's contacts that it may be held along.
const ASIDE: usize = 12;

impl Sheets<'_> {
    /// What is thin where edges go round and thinner than all sheets beside it; a wedge beside it is none.
    pub(super) fn waists(
        &self,
        cover: &Cover,
        sheets: &[(Sheet, Vec<Sample>)],
        levels: [f64; 2],
    ) -> Vec<(Sheet, Vec<Sample>)> {
        let [found, _] = self.thinner_than(sheets, cover, Shape::Waist);
        let waist = |samples: Vec<Sample>| Some((waist_of(&samples).filter(|s| self.is_waist(s))?, samples));
        between(levels).into_iter().flat_map(|level| self.grouped(&found, &level)).filter_map(waist).collect()
    }

    /// Adds the walls whose sides bend towards their balls everywhere and that are thinner than all sheets beside them; what lies beside a
    /// known sheet is more of it, and if it is no thinner more of its area.
    pub(super) fn add_bent_walls(
        &self,
        cover: &Cover,
        sheets: &mut Vec<(Sheet, Vec<Sample>)>,
        (levels, scale): ([f64; 2], Scale),
    ) {
        let ([found, others], known) = (self.thinner_than(sheets, cover, Shape::Bent), sheets.len());
        for level in between(levels) {
            for more in self.grouped(&others, &level) {
                let is_beside = |(sheet, of): &&mut (Sheet, Vec<Sample>)| {
                    level.contains(&sheet.thinnest.diameter) && self.lie_beside(of, &more)
                };
                if let Some((sheet, _)) = sheets.iter_mut().take(known).find(is_beside) {
                    sheet.add_area(&more);
                }
            }
            for wall in self.grouped(&found, &level).into_iter().filter_map(wall_of) {
                let is_more = |(sheet, of): &&mut (Sheet, Vec<Sample>)| {
                    level.contains(&sheet.thinnest.diameter) && self.lie_beside(of, &wall)
                };
                match sheets.iter_mut().take(known).find(is_more) {
                    Some((sheet, of)) => {
                        of.extend(wall);
                        *sheet = sheet_of(of, level.start, scale, self).unwrap_or(sheet.clone());
                    }
                    None => sheets.extend(sheet_of(&wall, level.start, scale, self).map(|sheet| (sheet, wall))),
                }
            }
        }
    }

    /// The samples of a shape that are thinner than all sheets beside them, and the others.
    fn thinner_than(&self, sheets: &[(Sheet, Vec<Sample>)], cover: &Cover, shape: Shape) -> [Vec<Sample>; 2] {
        let beside = sheets.iter().flat_map(|(_, samples)| samples);
        thinner(self.own(cover, shape), beside, 1.5 * self.resolution())
    }

    fn grouped(&self, found: &[Sample], level: &Range<f64>) -> Vec<Vec<Sample>> {
        let level: Vec<Sample> = found.iter().filter(|s| level.contains(&s.diameter)).copied().collect();
        self.groups(&level)
    }

    /// Whether some of two sheets' samples lie side by side in one body.
    fn lie_beside(&self, of: &[Sample], others: &[Sample]) -> bool {
        let (reach, body) = (1.5 * self.resolution(), |s: &Sample| self.body(s.facet));
        let Some((lo, hi)) = bounds(others.iter().map(|s| s.centre)) else { return false };
        let near = |s: &&Sample| (0..3).all(|a| s.centre[a] >= lo[a] - reach && s.centre[a] <= hi[a] + reach);
        let is_beside = |s: &Sample| others.iter().any(|o| body(o) == body(s) && distance(o.centre, s.centre) <= reach);
        of.iter().filter(near).any(is_beside)
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

/// From nothing to the lower limit, and from there to the upper one.
fn between([fail, warn]: [f64; 2]) -> [Range<f64>; 2] {
    [0.0..fail, fail.max(0.0)..warn]
}

/// Balls at edges as samples of a wall, if they lie side by side.
fn wall_of(samples: Vec<Sample>) -> Option<Vec<Sample>> {
    let thickest = samples.iter().map(|s| s.diameter).fold(0.0, f64::max);
    let [long, ..] = principal_extents(&samples.iter().map(|s| s.centre).collect::<Vec<_>>());
    let of_wall = |s: Sample| Sample { shape: Shape::Sheet, area: s.thin, ..s };
    (long > WIDTHS * thickest).then(|| samples.into_iter().map(of_wall).collect())
}

/// The samples that are thinner than all others within about a distance, and those that are not.
fn thinner<'s>(samples: Vec<Sample>, others: impl Iterator<Item = &'s Sample>, distance: f64) -> [Vec<Sample>; 2] {
    if samples.is_empty() {
        return [Vec::new(), Vec::new()];
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
    samples.into_iter().partition::<Vec<Sample>, _>(is_thinner).into()
}
