//! The report as data: the keys that pipelines rely on.

use super::thickness::ThicknessReport;
use crate::check::{Bracket, Budget, Finding, Sense, State};
use crate::error::Result;
use crate::geometry::vector::{bounds, corners_of};
use crate::notice::Notice;
use crate::part::Part;
use crate::process::{Bound, LimitBasis, Process, rule};
use crate::units::report_digits;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Name and major version of the schema; keys are added within a major version, never changed.
pub const SCHEMA: &str = "amcheck-report/1";

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    Pass,
    Warn,
    Undecided,
    Fail,
}

/// Three numbers along x, y, z.
pub type Axis3 = [f64; 3];

/// The tool that wrote the report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tool {
    pub name: String,
    pub version: String,
}

/// One body of the part, in the frame of the input file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyReport {
    pub box_mm: [Axis3; 2],
    pub volume_mm3: f64,
}

/// Most bodies that a report lists one by one.
const MOST_BODIES: usize = 1000;

impl BodyReport {
    /// The bodies of a part that has several; none of one that has too many to list.
    pub fn each(part: &Part) -> Vec<Self> {
        let bodies = &part.health().bodies;
        if !(2..=MOST_BODIES).contains(&bodies.len()) {
            return Vec::new();
        }
        let boxes = part.body_boxes_in_file().into_iter().map(|b| b.map(|corner| corner.map(report_digits)));
        let volumes = bodies.iter().map(|b| report_digits(b.volume_mm3));
        boxes.zip(volumes).map(|(box_mm, volume_mm3)| BodyReport { box_mm, volume_mm3 }).collect()
    }
}

/// The part as it was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartReport {
    /// File name without its folders.
    pub file: String,
    pub sha256: String,
    pub triangles: u64,
    pub bodies: u64,
    /// Each of them in the order of their numbers, where there are several and not too many to list.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub each_body: Vec<BodyReport>,
    pub box_mm: [Axis3; 2],
    pub volume_mm3: Bracket,
    pub area_mm2: f64,
    /// Unit of the file's numbers.
    pub units: String,
    /// How the unit is known: `assumed`, `option`, `file`.
    pub units_from: String,
    pub watertight: bool,
    /// Rows of the 4×4 matrix that poses the part for the build.
    pub pose: [[f64; 4]; 4],
}

impl PartReport {
    /// A part with its file's name and digest, and its unit with how that is known.
    ///
    /// # Errors
    /// As [`Part::solid`].
    pub fn of(part: &Part, (file, sha256): (&str, &str), (units, units_from): (&str, &str)) -> Result<Self> {
        let solid = part.solid()?;
        let (low, high) = (solid.inner.volume().as_mm3(), solid.outer.volume().as_mm3());
        let value = if part.is_plain() { part.mesh().signed_volume() } else { solid.density.volume().as_mm3() };
        let (lo, hi) = bounds(part.mesh().vertices.iter().map(|&p| part.to_file(p))).unwrap_or_default();
        Ok(PartReport {
            file: file.into(),
            sha256: sha256.into(),
            triangles: part.health_as_read().facet_body.len() as u64,
            bodies: part.health().bodies.len() as u64,
            each_body: BodyReport::each(part),
            box_mm: [lo, hi].map(|corner| corner.map(report_digits)),
            volume_mm3: Bracket::new(value, low, high).rounded(),
            area_mm2: report_digits(part.mesh().area()),
            units: units.into(),
            units_from: units_from.into(),
            watertight: part.health_as_read().is_watertight(),
            pose: part.pose().map(|row| row.map(report_digits)),
        })
    }

    /// A place of the input frame in the frame of the build, millimetres.
    pub fn posed(&self, at_mm: Axis3) -> Axis3 {
        [0, 1, 2].map(|r| {
            let row = self.pose[r];
            row[0] * at_mm[0] + row[1] * at_mm[1] + row[2] * at_mm[2] + row[3]
        })
    }

    /// A box in the frame of the build that holds the part, millimetres: its own where the pose turns by right angles.
    pub fn posed_box(&self) -> [Axis3; 2] {
        let [lo, hi] = self.box_mm;
        let (lo, hi) = bounds(corners_of((lo, hi)).map(|p| self.posed(p))).unwrap_or((lo, hi));
        [lo, hi]
    }
}

/// One limit of the process as it was applied.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LimitReport {
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub fail: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub warn: Option<f64>,
    pub sense: Sense,
    pub unit: String,
    /// `sourced`, `convention` or `user`.
    pub basis: String,
    pub source: String,
    pub overridden: bool,
}

/// The process in full.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProcessReport {
    pub name: String,
    pub title: String,
    pub layer_height_mm: f64,
    pub build_volume_mm: Axis3,
    pub prints_supports: bool,
    /// Keyed by the name of the check, or `check/kind` where a check has several.
    pub limits: BTreeMap<String, LimitReport>,
}

/// The grid that the fields were sampled on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GridReport {
    pub spacing_mm: f64,
    pub dims: [u64; 3],
    pub samples: u64,
    /// Bytes that the fields were allowed to take, known before they were taken.
    pub memory_bytes: u64,
    /// Samples that all checks together took to decide what the grid left open.
    pub refined: u64,
    /// What each of them may take for that.
    pub refine_budget: u64,
}

/// The worst value a check met.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorstReport {
    pub value: f64,
    pub low: f64,
    pub high: f64,
    pub unit: String,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub at_mm: Option<Axis3>,
}

/// One check's answer, passes too.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CheckReport {
    pub code: String,
    pub name: String,
    /// What is measured, one line.
    pub title: String,
    pub state: State,
    /// Why it is not applicable, not run or broken.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub why: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub worst: Option<WorstReport>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub limit: Option<LimitReport>,
    /// What was searched and how sure a pass is, one sentence.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub cover: Option<String>,
    /// What finer looks at places that the first left open took, and what is left for more.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub refined: Option<RefinedReport>,
    pub findings: Vec<Finding>,
}

impl CheckReport {
    /// Puts the worst finding that counts in the place of the worst value, beside the limit that it is judged by: it decides the state.
    pub fn told_by_worst(&mut self, process: &Process) {
        let Some(f) = self.findings.iter().find(|f| f.counts()) else { return };
        let worst =
            WorstReport { value: f.value, low: f.low, high: f.high, unit: f.unit.clone(), at_mm: Some(f.at_mm) };
        self.limit = judging(&ProcessReport::of(process).limits, &self.name, self.limit.as_ref(), f).cloned();
        self.worst = Some(worst);
    }

    /// Whether its state is known: a warning none of whose findings is certain may be a pass.
    pub fn is_decided(&self) -> bool {
        match self.state {
            State::Pass | State::Fail => true,
            State::Warn => self.findings.iter().any(|f| f.counts() && f.decided),
            _ => false,
        }
    }
}

/// Finer looks of one check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct RefinedReport {
    /// Windows, features and ceilings that were looked at again.
    pub looks: u64,
    /// Samples that they took.
    pub samples: u64,
    /// Samples left of the budget.
    pub left: u64,
    /// The least samples that a look would have taken for which too few were left.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub lacking: Option<u64>,
    /// Looks that were not taken because they need more memory than a window may take.
    #[serde(skip_serializing_if = "is_zero", default)]
    pub too_large: u64,
}

impl From<Budget> for RefinedReport {
    fn from(Budget { looks, spent, left, lacking, too_large }: Budget) -> Self {
        RefinedReport { looks, samples: spent, left, lacking, too_large }
    }
}

fn is_zero(n: &u64) -> bool {
    *n == 0
}

impl LimitReport {
    /// The limit that a process sets for a rule.
    pub fn of(process: &Process, key: &str) -> Option<Self> {
        let limit = process.limit(key)?;
        let rule = rule(key).ok()?;
        Some(LimitReport {
            fail: limit.fail,
            warn: limit.warn,
            sense: if rule.bound == Bound::Least { Sense::Min } else { Sense::Max },
            unit: rule.dimension.unit().into(),
            basis: limit.basis.word().into(),
            source: limit.source,
            overridden: limit.overridden,
        })
    }
}

/// The limit that a finding of a check is judged by: the check's own, or the one of the check's rules that has the finding's numbers.
fn judging<'a>(
    limits: &'a BTreeMap<String, LimitReport>,
    check: &str,
    own: Option<&'a LimitReport>,
    f: &Finding,
) -> Option<&'a LimitReport> {
    let same = |l: &&LimitReport| l.fail == f.fail && l.warn == f.warn;
    let rule = |key: &str| key.strip_prefix(check).is_some_and(|rest| rest.starts_with('.'));
    let others = || limits.iter().filter(|(key, _)| rule(key)).map(|(_, l)| l);
    own.filter(same).or_else(|| others().find(same)).or(own)
}

impl ProcessReport {
    /// A process with all its limits.
    pub fn of(process: &Process) -> Self {
        ProcessReport {
            name: process.name.clone(),
            title: process.title.clone(),
            layer_height_mm: process.layer_height_mm,
            build_volume_mm: process.build_volume_mm,
            prints_supports: process.prints_supports,
            limits: process.limits.keys().filter_map(|k| Some((k.clone(), LimitReport::of(process, k)?))).collect(),
        }
    }
}

/// What a comparison with an earlier report says, as a report repeats it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BaselineReport {
    /// How many findings became what, and how many bodies there were and are where that differs: `1 new, 2 same; bodies 2 → 1`.
    pub words: String,
    /// Bodies before and now.
    pub bodies: [u64; 2],
    /// What was judged differently.
    pub judged_otherwise: Vec<String>,
    /// Checks that found something and that the earlier report did not run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_compared: Vec<String>,
    /// Everything that is not the same, new first.
    pub changes: Vec<ChangeReport>,
}

/// One finding that is not what it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChangeReport {
    /// `new`, `worse`, `unchecked`, `better` or `fixed`.
    pub delta: String,
    pub check: String,
    /// Values before and after, and the place.
    pub words: String,
}

/// Everything amcheck says about a part. Same input, same bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    pub schema: String,
    pub tool: Tool,
    pub verdict: Verdict,
    /// The verdict as a sentence: number, consequence, remedy.
    pub summary: String,
    pub part: PartReport,
    pub process: ProcessReport,
    pub grid: GridReport,
    /// In the order of the registry.
    pub checks: Vec<CheckReport>,
    /// How thick the part is all over, where that was asked.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub thickness: Option<ThicknessReport>,
    pub warnings: Vec<Notice>,
    /// What changed since an earlier report, where one was given.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub baseline: Option<BaselineReport>,
}

impl Report {
    /// All findings that are not passes, worst first; those that somebody accepts last.
    pub fn findings(&self) -> Vec<&Finding> {
        self.ranked().into_iter().map(|(_, f)| f).collect()
    }

    /// All findings that are not passes with their checks, worst first; of equal state, what breaks a sourced limit stands before what
    /// breaks a convention.
    pub fn ranked(&self) -> Vec<(&CheckReport, &Finding)> {
        let own = |c| move |f| (c, f);
        let mut all: Vec<(&CheckReport, &Finding)> = self
            .checks
            .iter()
            .flat_map(|c| c.findings.iter().map(own(c)))
            .filter(|(_, f)| f.state > State::Pass)
            .collect();
        let standing = |&(c, f): &(&CheckReport, &Finding)| {
            let convention = self.limit_of(c, f).is_some_and(|l| l.basis == LimitBasis::Convention.word());
            (f.accepted.is_some(), Reverse(f.state), convention)
        };
        all.sort_by(|a, b| standing(a).cmp(&standing(b)).then_with(|| Finding::worst_first(a.1, b.1)));
        all
    }

    /// The limit that a finding is judged by: its check's own, or the one of the check's rules that has the finding's numbers.
    pub fn limit_of<'a>(&'a self, check: &'a CheckReport, f: &Finding) -> Option<&'a LimitReport> {
        judging(&self.process.limits, &check.name, check.limit.as_ref(), f)
    }

    /// Number of findings that somebody accepts.
    pub fn accepted(&self) -> usize {
        self.checks.iter().flat_map(|c| &c.findings).filter(|f| f.accepted.is_some()).count()
    }

    /// Number of checks in a state.
    pub fn count(&self, state: State) -> usize {
        self.checks.iter().filter(|c| c.state == state).count()
    }

    /// How many checks came to an end without a verdict that is certain.
    pub fn undecided(&self) -> usize {
        let came_to_an_end = |c: &&CheckReport| matches!(c.state, State::Warn | State::Undecided) && !c.is_decided();
        self.checks.iter().filter(came_to_an_end).count()
    }
}
