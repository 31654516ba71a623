//! The thinnest place of a sheet: sought on the features it was found on, until the limits are told from it or the budget ends.

use super::budget::{Budget, EVALUATION};
use super::sheet::Sheets;
use super::sheet_shape::{Sheet, runs_out};
use crate::geometry::vector::{Vec3, add, distance, sub, unit};
use crate::medial::chord::PARALLEL;
use crate::medial::refine::thinnest_on;
use crate::medial::{Question, Sample};
use rustc_hash::{FxHashMap, FxHashSet};

/// Bound and ball that differ by less than this are one where every limit tells them the same, millimetres.
const TOUCH: f64 = 1e-3;
/// Sheets whose thinnest place is sought although every limit tells its bracket's ends the same; thinnest sheets first.
const REFINED: usize = 64;
/// Features of such a sheet that are searched, and what each search may cost, in evaluations.
const LOOKS: (usize, u64) = (16, 1 << 12);

/// What the thinnest places of all sheets of a kind are sought with.
pub(super) struct Seeking<'a> {
    pub question: &'a Question,
    /// The widest limit, or the part if that is smaller.
    pub scale: f64,
    pub territory: &'a Territory,
    /// Evaluations that a sheet with a limit within its bracket may take.
    pub share: u64,
}

/// The samples of all sheets by the feature they were found on: each owns what is nearest to it there.
pub(super) struct Territory {
    by_feature: FxHashMap<u32, Vec<(Vec3, Option<usize>)>>,
}

impl Territory {
    /// That of sheets, which are counted from 0 in their order, and of samples in wedges, which are nobody's.
    pub fn of<'s>(sheets: impl Iterator<Item = &'s [Sample]>, wedges: &[Sample]) -> Self {
        let mut by_feature: FxHashMap<u32, Vec<(Vec3, Option<usize>)>> = FxHashMap::default();
        let mut claim = |s: &Sample, owner| by_feature.entry(s.feature).or_default().push((s.centre, owner));
        for (rank, samples) in sheets.enumerate() {
            samples.iter().for_each(|s| claim(s, Some(rank)));
        }
        wedges.iter().for_each(|s| claim(s, None));
        Territory { by_feature }
    }

    /// The sheet that a ball belongs to: that of the nearest sample on the same feature, the first of equals.
    pub fn owner(&self, ball: &Sample) -> Option<usize> {
        let apart = |claim: &(Vec3, Option<usize>)| distance(claim.0, ball.centre);
        let claims = self.by_feature.get(&ball.feature)?;
        claims.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)))?.1
    }
}

impl Sheets<'_> {
    /// The sheet with its thinnest place sought on every feature where the bound leaves room for one.
    ///
    /// What no search has excluded stays in the bracket; balls that belong to other sheets, or where the sheet runs out to
    /// an edge, are not its own. A sheet with a limit within its bracket is looked at until its share is spent.
    pub(super) fn thinnest(
        &self,
        how: &Seeking,
        mut sheet: Sheet,
        samples: &[Sample],
        rank: usize,
        budget: &mut Budget,
    ) -> Sheet {
        let mut open: Vec<(f64, u32)> = samples.iter().map(|s| (s.low, s.feature)).collect();
        open.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut seen = FxHashSet::default();
        open.retain(|o| seen.insert(o.1));
        let (q, tree, features) = (how.question, self.part.distance(), self.part.features(self.side));
        let own = |s: &Sample| how.territory.owner(s) == Some(rank) && !self.ends(s, how.scale);
        let (mut left, mut share) = (f64::INFINITY, how.share);
        for (looks, (low, feature)) in open.into_iter().enumerate() {
            let known = sheet.thinnest.diameter;
            let told = q.class(low) == q.class(known);
            let most = match told {
                true if low >= known - TOUCH || rank >= REFINED || looks >= LOOKS.0 => 0,
                true => LOOKS.1,
                false => share,
            };
            if most == 0 {
                left = left.min(low);
                break;
            }
            let found = thinnest_on(tree, features, q, feature, known, most, own);
            share -= if told { 0 } else { found.spent.min(share) };
            budget.note(u64::from(!told), EVALUATION * found.spent);
            left = left.min(found.low.max(low));
            sheet.thinnest = found.sample.unwrap_or(sheet.thinnest);
        }
        sheet.low = left.min(sheet.thinnest.diameter);
        sheet
    }

    /// Whether a sheet runs out to an edge at a sample.
    pub(super) fn ends(&self, s: &Sample, scale: f64) -> bool {
        runs_out(s, scale) || self.thins_out(s)
    }

    /// Whether a sheet goes on thinning beyond its thinnest ball until its sides meet.
    ///
    /// Sides that taper by τ meet r / sin(τ/2) beyond the centre. A ray that way meets the flat rim of a wall after about
    /// r, and in a wedge nothing until its edge.
    fn thins_out(&self, s: &Sample) -> bool {
        if s.separation >= PARALLEL {
            return false;
        }
        let taper = std::f64::consts::PI - s.separation;
        let apex = 0.5 * s.diameter / (0.5 * taper).sin();
        let outward = s.contacts.map(|c| sub(c, s.centre));
        let towards = unit(add(outward[0], outward[1]));
        self.part.distance().first_hit(s.centre, towards, 0.0, 0.6 * apex).is_none()
    }
}
