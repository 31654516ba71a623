//! The thinnest place of each sheet: sought on the features it was found on, until the limits are told from it or the budget ends.

use super::budget::Budget;
use super::sheet::Sheets;
use super::sheet_shape::{Ends, RUN_OUT, Scale, Sheet, below, blunt_sheet};
use crate::geometry::vector::{Vec3, add, distance, sub, unit};
use crate::medial::chord::PARALLEL;
use crate::medial::refine::thinnest_on;
use crate::medial::{Own, Question, Sample, runs_out, stays};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeSet;

/// Bound and ball that differ by less than this are one where every limit tells them the same, millimetres.
const TOUCH: f64 = 1e-3;
/// Sheets whose thinnest place is sought although every limit tells its bracket's ends the same; thinnest sheets first.
const REFINED: usize = 64;
/// Features of such a sheet that are searched, and what each search may cost, in evaluations.
const LOOKS: (usize, u64) = (16, 1 << 12);
/// What all of these searches may cost, in evaluations: each such sheet has an equal share.
const OF_ALL_TOLD: u64 = 1 << 18;
/// Times that a sheet is sought again because others speak for its thinnest place.
const TIMES: u32 = 4;
/// Where the known place does not count, this part of the budget goes to the thinnest of all.
const OF_ALL: u64 = 8;

/// What the thinnest places of all sheets of a kind are sought with.
pub(super) struct Seeking<'a> {
    pub question: &'a Question,
    pub scale: Scale,
    /// The limits between which samples make a sheet.
    pub levels: [f64; 2],
    /// What is farther from a sheet's samples is another place, millimetres.
    pub reach: f64,
    /// What a sheet that every limit tells may cost, in evaluations.
    pub told: u64,
}

/// What a sheet that every limit tells may cost, in evaluations, where so many are to be looked at.
pub(super) fn share_of_told(sheets: usize) -> u64 {
    OF_ALL_TOLD / sheets.clamp(1, REFINED) as u64
}

impl Seeking<'_> {
    fn level(&self, diameter: f64) -> usize {
        self.levels.iter().filter(|limit| diameter >= **limit).count()
    }

    /// The limit that a diameter reaches, or 0.
    fn least(&self, diameter: f64) -> f64 {
        self.levels.into_iter().filter(|limit| diameter >= *limit).fold(0.0, f64::max)
    }

    /// Whether a limit lies within a sheet's bracket.
    fn leaves_open(&self, sheet: &Sheet) -> bool {
        self.question.class(sheet.low) != self.question.class(sheet.thinnest.diameter)
    }
}

/// A sheet as it was grouped, and what was found of it.
pub(super) struct Sought {
    /// `None` for a wedge.
    pub sheet: Option<Sheet>,
    pub samples: Vec<Sample>,
    /// Finer looks, and what they took.
    pub budget: Budget,
}

impl Sought {
    fn thinnest(&self) -> f64 {
        self.sheet.as_ref().map_or(f64::INFINITY, |s| s.thinnest.diameter)
    }
}

/// A sheet that is looked at again.
struct Looked<'a> {
    how: &'a Seeking<'a>,
    samples: &'a [Sample],
    /// How many sheets are thinner, as far as is known.
    rank: usize,
    own_from: &'a dyn Fn(Vec3, f64, f64) -> f64,
}

impl Sheets<'_> {
    /// Each sheet with its thinnest place; `sheets` are in order of what is known of them, thinnest first.
    ///
    /// Each is first sought by itself. A place that then lies nearer to the samples of a sheet at least as thin stands
    /// for that one: the other is sought again without the balls that such a sheet already speaks for, so that no place is
    /// told twice and none is lost. What is left of the budget goes to those that are still open, thinnest first.
    pub(super) fn thinnest_of(&self, how: &Seeking, sheets: Vec<(Sheet, Vec<Sample>)>) -> Vec<Sought> {
        let share = how.question.budget / sheets.iter().filter(|(s, _)| how.leaves_open(s)).count().max(1) as u64;
        let alone = |(rank, (sheet, samples)): (usize, &(Sheet, Vec<Sample>))| {
            let mut budget = Budget::of(share);
            let sheet = self.sought(how, sheet, samples, rank, &mut budget, &|_, _, low| low);
            (sheet, budget)
        };
        let found: Vec<(Option<Sheet>, Budget)> = sheets.par_iter().enumerate().with_max_len(1).map(alone).collect();
        let (known, all): (Vec<Sheet>, Vec<Sought>) = sheets
            .into_iter()
            .zip(found)
            .map(|((known, samples), (sheet, budget))| (known, Sought { sheet, samples, budget }))
            .unzip();
        let all = self.each_place_once(how, &known, all);
        all.into_iter().zip(known).flat_map(|(sought, known)| self.parted(how, sought, known)).collect()
    }

    /// A sheet that was known between the limits and is thinner at some place: what of it may be so, and the others as they were known.
    fn parted(&self, how: &Seeking, sought: Sought, known: Sheet) -> Vec<Sought> {
        let level = |s: &Sheet| how.level(s.thinnest.diameter);
        let thinner = sought.sheet.as_ref().filter(|s| level(s) < level(&known));
        let limit = thinner.and_then(|s| how.levels.get(level(s)));
        let (Some(sheet), Some(&limit)) = (thinner, limit) else { return vec![sought] };
        let thin = below(sheet, &sought.samples, limit);
        let others = match self.ends(&known.thinnest, how) {
            true => blunt_sheet(&sought.samples, how.least(known.thinnest.diameter), how.scale, self),
            false => Some(known),
        };
        let others = others.map(|s| Sheet { low: s.low.max(limit), ..s });
        let (samples, budget) = (sought.samples.clone(), Budget::of(0));
        vec![Sought { sheet: Some(thin), ..sought }, Sought { sheet: others, samples, budget }]
    }

    /// Settles the sheets one by one, thinnest first, and seeks again what lies where a settled one speaks for it.
    fn each_place_once(&self, how: &Seeking, known: &[Sheet], mut all: Vec<Sought>) -> Vec<Sought> {
        let near = Nearest::of(&all, how.reach);
        let (mut settled, mut places) = (vec![f64::INFINITY; all.len()], Vec::<Sample>::new());
        // Diameters are positive: their bits are in their order.
        let mut waiting: BTreeSet<(u64, usize)> =
            all.iter().enumerate().map(|(rank, s)| (s.thinnest().to_bits(), rank)).collect();
        let (mut again, mut longer) = (vec![(0, 0); all.len()], vec![true; all.len()]);
        while let Some((_, rank)) = waiting.pop_first() {
            let Some(sheet) = &all[rank].sheet else { continue };
            let level = |rank: usize| how.level(known[rank].thinnest.diameter);
            let body = |rank: usize| self.body(known[rank].thinnest.facet);
            let own_from = |at: Vec3, within: f64, low: f64| {
                let claim = |other: usize| match settled[other] <= low && body(other) == body(rank) {
                    true if level(other) != level(rank) && level(other) == how.level(low) => Claim::OfItsKind,
                    true => Claim::Nearest,
                    false => Claim::None,
                };
                match near.claimed(at, within, rank, claim) {
                    Claim::OfItsKind => how.levels[how.level(low).min(1)].max(low),
                    Claim::Nearest => f64::INFINITY,
                    Claim::None => low,
                }
            };
            let spoken_for = |s: &Sample| own_from(s.centre, 0.0, s.diameter) > s.diameter;
            // Only one that was settled since may speak for more than when it was last sought.
            let (times, before) = again[rank];
            let may_differ = times == 0 || times < TIMES && places.len() > before;
            let (start, mut budget) = if may_differ && spoken_for(&sheet.thinnest) {
                again[rank] = (times + 1, places.len());
                (&known[rank], all[rank].budget)
            } else if longer[rank] && how.leaves_open(sheet) {
                longer[rank] = false;
                let of_others: u64 = all.iter().map(|s| s.budget.spent).sum();
                (sheet, Budget { left: how.question.budget.saturating_sub(of_others), ..all[rank].budget })
            } else {
                settled[rank] = sheet.thinnest.diameter;
                let (here, known) = (sheet.thinnest, &known[rank]);
                let is_here = |t: &Sample| distance(t.centre, here.centre) < 0.5 * here.diameter;
                // What another sheet tells already leaves this one what it was known for.
                if places.iter().any(is_here) && how.level(here.diameter) < level(rank) {
                    let limit = how.levels.get(how.level(here.diameter)).copied().unwrap_or_default();
                    all[rank].sheet = Some(Sheet { low: known.low.max(limit), ..known.clone() });
                }
                places.push(here);
                continue;
            };
            let sheet = self.sought(how, start, &all[rank].samples, rank, &mut budget, &own_from);
            all[rank] = Sought { sheet, budget, samples: std::mem::take(&mut all[rank].samples) };
            waiting.insert((all[rank].thinnest().to_bits(), rank));
        }
        all
    }

    /// A sheet with its thinnest place, or what of it is parallel if it runs out to an edge; `None` for a wedge.
    ///
    /// Balls where a sheet runs out to an edge do not count. Where no other is known the thinnest of all is sought first:
    /// that may lie on the rim of a wall.
    fn sought(
        &self,
        how: &Seeking,
        sheet: &Sheet,
        samples: &[Sample],
        rank: usize,
        budget: &mut Budget,
        own_from: &dyn Fn(Vec3, f64, f64) -> f64,
    ) -> Option<Sheet> {
        let looked = Looked { how, samples, rank, own_from };
        let other = |s: &Sample| own_from(s.centre, 0.0, s.diameter) <= s.diameter;
        let known = if self.ends(&sheet.thinnest, how) {
            let mut first = Budget::of(budget.left / OF_ALL);
            let rim = self.thinnest(&looked, sheet.clone(), &mut first, &other);
            budget.note(first.looks, first.spent);
            let from = how.least(sheet.thinnest.diameter);
            let blunt = || blunt_sheet(samples, from, how.scale, self);
            Some(rim).filter(|s| !self.ends(&s.thinnest, how)).or_else(blunt)?
        } else {
            sheet.clone()
        };
        let counts = |s: &Sample| other(s) && !self.ends(s, how);
        Some(self.thinnest(&looked, known, budget, &counts))
    }

    /// The sheet with its thinnest place that counts, sought on every feature where the bound leaves room for one.
    ///
    /// What no search has excluded stays in the bracket. A sheet with a limit within its bracket is looked at until its
    /// budget is spent.
    fn thinnest(
        &self,
        looked: &Looked,
        mut sheet: Sheet,
        budget: &mut Budget,
        counts: &dyn Fn(&Sample) -> bool,
    ) -> Sheet {
        let Looked { how, samples, rank, own_from } = *looked;
        let (q, tree, features) = (how.question, self.part.distance(), self.part.features(self.side));
        let (lo, hi) = (sheet.extent.0.map(|x| x - how.reach), sheet.extent.1.map(|x| x + how.reach));
        let counts = |s: &Sample| (0..3).all(|a| lo[a] <= s.centre[a] && s.centre[a] <= hi[a]) && counts(s);
        let own = Own { counts: &counts, from: own_from };
        let (mut left, mut told_left) = (f64::INFINITY, how.told);
        for (looks, (low, feature)) in by_bound(samples).into_iter().enumerate() {
            let known = sheet.thinnest.diameter;
            let told = q.class(low.min(known)) == q.class(known);
            let most = match told {
                true if low >= known - TOUCH || rank >= REFINED || looks >= LOOKS.0 => 0,
                true => LOOKS.1.min(told_left),
                false => budget.left,
            };
            if most == 0 {
                left = left.min(low);
                break;
            }
            let found = thinnest_on(tree, features, q, feature, known, most, own);
            match told {
                true => told_left = told_left.saturating_sub(found.spent),
                false => budget.note(1, found.spent),
            }
            left = left.min(found.low.max(low));
            sheet.thinnest = found.sample.unwrap_or(sheet.thinnest);
        }
        sheet.low = left.min(sheet.thinnest.diameter);
        sheet
    }

    /// Whether a sheet runs out to an edge at a sample.
    fn ends(&self, s: &Sample, how: &Seeking) -> bool {
        self.runs_out(s, how.scale) || self.thins_out(s, how.least(s.diameter))
    }
}

impl Ends for Sheets<'_> {
    fn runs_out(&self, s: &Sample, scale: Scale) -> bool {
        runs_out(self.part.distance(), s.centre, s.diameter, RUN_OUT * scale.wide)
    }

    /// Sides that taper by τ meet r / sin(τ/2) beyond the centre. A ray that way meets the flat rim of a wall after about
    /// r, and in a wedge nothing until its edge; nor does it in a skin between two rooms, which is thicker again beyond its thinnest place.
    fn thins_out(&self, s: &Sample, from: f64) -> bool {
        if s.separation >= PARALLEL {
            return false;
        }
        let taper = std::f64::consts::PI - s.separation;
        let apex = 0.5 * s.diameter / (0.5 * taper).sin();
        let outward = s.contacts.map(|c| sub(c, s.centre));
        let towards = unit(add(outward[0], outward[1]));
        self.part.distance().first_hit(s.centre, towards, 0.0, 0.6 * apex).is_none() && !self.stays(s, from)
    }

    fn stays(&self, s: &Sample, from: f64) -> bool {
        stays(self.part.distance(), s.centre, s.diameter, from)
    }
}

/// The features of a sheet, each with the least bound of its samples there, least first.
fn by_bound(samples: &[Sample]) -> Vec<(f64, u32)> {
    let mut open: Vec<(f64, u32)> = samples.iter().map(|s| (s.low, s.feature)).collect();
    open.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut seen = FxHashSet::default();
    open.retain(|o| seen.insert(o.1));
    open
}

/// The samples of all sheets, in cubes of an edge beyond which none is near.
struct Nearest {
    edge: f64,
    cubes: FxHashMap<[i64; 3], Vec<(Vec3, usize)>>,
}

impl Nearest {
    fn of(all: &[Sought], edge: f64) -> Self {
        let mut near = Nearest { edge, cubes: FxHashMap::default() };
        for (rank, sought) in all.iter().enumerate() {
            for s in &sought.samples {
                near.cubes.entry(near.cube(s.centre)).or_default().push((s.centre, rank));
            }
        }
        near
    }

    fn cube(&self, p: Vec3) -> [i64; 3] {
        p.map(|x| (x / self.edge).floor() as i64)
    }

    /// What other sheets than `rank` claim of all that lies within a radius of a point, by what each may claim.
    fn claimed(&self, p: Vec3, within: f64, rank: usize, claim: impl Fn(usize) -> Claim) -> Claim {
        let [x, y, z] = self.cube(p);
        let (mut own, mut other) = (f64::INFINITY, f64::INFINITY);
        for (dx, dy, dz) in (0..27).map(|n| (n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) {
            for &(centre, of) in self.cubes.get(&[x + dx, y + dy, z + dz]).into_iter().flatten() {
                let apart = distance(centre, p);
                if of == rank {
                    own = own.min(apart);
                } else if apart < other {
                    match claim(of) {
                        Claim::OfItsKind if apart + within <= self.edge => return Claim::OfItsKind,
                        Claim::None => {}
                        _ => other = apart,
                    }
                }
            }
        }
        if other + within < own - within { Claim::Nearest } else { Claim::None }
    }
}

/// What a sheet may claim of what was found in another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Claim {
    /// Not yet known, or known to be thicker.
    None,
    /// What lies nearer to its samples.
    Nearest,
    /// What lies beside them: between the same limits as they are, and the other sheet's are not.
    OfItsKind,
}

#[cfg(test)]
mod tests {
    use super::super::contract::{Check, Context, Outcome};
    use super::super::for_good::Told;
    use super::super::room::Beside;
    use super::super::search;
    use super::super::sheet_shape::tests::plate;
    use super::super::sheet_shape::{Form, sheet_of};
    use super::super::thin_wall::ThinWall;
    use super::*;
    use crate::geometry::{cuboid, extruded};
    use crate::medial::Side;
    use crate::part::{Part, Up};
    use crate::process::Process;

    #[test]
    fn a_sheet_with_a_thinner_spot_is_told_by_both() {
        let part = Part::new(cuboid([-1.0, -1.0, -0.45], [11.0, 3.0, 0.45]), Up::PlusZ, 1e-6, 1.0).unwrap();
        let (process, context) = (Process::named("fdm").unwrap(), Context { refine: 1 << 20, spacing_mm: 0.1 });
        let sheets = Sheets {
            part: &part,
            process: &process,
            context: &context,
            code: "AM101",
            side: Side::Material,
            kinds: Vec::new(),
            rods: Vec::new(),
            necks: Vec::new(),
            beside: Beside::Limit,
            told: Told::AsThin,
        };
        let question = search::question(&part, &process, &context, Side::Material, &[0.8, 1.2]);
        let scale = Scale { wide: 1.2, tight: 0.8 };
        let how = Seeking { question: &question, scale, levels: [0.8, 1.2], reach: 1.0, told: 0 };
        let samples = plate(0);
        let known = sheet_of(&samples, 0.8, scale, &sheets).unwrap();
        let parted = |diameter: f64| {
            let thinnest = Sample { diameter, low: diameter, ..known.thinnest };
            let sheet = Some(Sheet { thinnest, low: diameter, ..known.clone() });
            let sought = Sought { sheet, samples: samples.clone(), budget: Budget::of(0) };
            let told = sheets.parted(&how, sought, known.clone()).into_iter().filter_map(|s| s.sheet);
            told.map(|s| (s.thinnest.diameter, s.low, s.area, s.form)).collect::<Vec<_>>()
        };
        assert_eq!(parted(0.7), [(0.7, 0.7, 0.0, Form::Spot), (0.9, known.low, known.area, Form::Plate)]);
        assert_eq!(parted(0.85), [(0.85, 0.85, known.area, Form::Plate)]);
    }

    #[test]
    fn what_tapers_to_its_edge_is_no_wall_and_what_is_behind_is_as_thick_as_it_is() {
        // What a plane cuts off a rod of radius 8, 12 mm long, turned.
        let told = |edge: f64, turn: f64| {
            let arc = (0..=24).map(|k| edge * (1.0 - f64::from(k) / 12.0));
            let outline: Vec<[f64; 2]> = arc.map(|t| [8.0 * t.sin(), 8.0 * (t.cos() - edge.cos())]).collect();
            let fan: Vec<[usize; 3]> = (1..outline.len() - 1).map(|k| [0, k, k + 1]).collect();
            let (sin, cos) = turn.sin_cos();
            let rows = [[cos, -sin, 0.0], [0.6 * sin, 0.6 * cos, -0.8], [0.8 * sin, 0.8 * cos, 0.6]];
            let mesh = extruded(&outline, &fan, 12.0).transformed(rows, [turn, 0.1, 0.2]);
            let part = Part::new(mesh, Up::PlusZ, 1e-9, 1.0).unwrap();
            let (process, context) = (Process::named("fdm").unwrap(), Context { refine: 1 << 22, spacing_mm: 0.1 });
            let Outcome::Measured(found) = ThinWall.run(&part, &process, &context).unwrap() else { panic!() };
            found.findings.iter().map(|f| f.value).collect::<Vec<_>>()
        };
        for edge in [12.0, 28.0, 36.0, 50.0] {
            // The ball between the plane and the rod where they lean by 4 degrees; facets of up to 4 degrees tell where that is.
            let wide =
                |at: f64| 16.0 * (at.to_radians().cos() - f64::to_radians(edge).cos()) / (1.0 + at.to_radians().cos());
            for turn in [0.0, 0.7, 2.0] {
                match told(edge.to_radians(), turn)[..] {
                    [] => assert!(wide(4.0) > 1.2, "{edge} at {turn}"),
                    [value] => {
                        assert!(wide(4.0 + edge / 12.0) < value && value < wide(4.0 - edge / 12.0), "{edge}: {value}")
                    }
                    ref several => panic!("{edge} at {turn}: {several:?}"),
                }
            }
        }
    }
}
