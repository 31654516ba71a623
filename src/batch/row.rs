//! One line of a batch: what became of a part.

use crate::error::Error;
use crate::report::{Report, Verdict, conclusion};
use crate::units::report_digits;
use serde::{Deserialize, Serialize};

/// Exit codes of parts from best to worst.
const ORDER: [u8; 7] = [0, 3, 1, 4, 5, 6, 70];

/// What became of a part. Everything but `seconds`, `peak_mib` and `reused` follows from the part and what was asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its name in the batch.
    pub part: String,
    /// The exit code it would end with alone.
    pub code: u8,
    /// The verdict; none where there is no report.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub verdict: Option<Verdict>,
    /// What is worst and what mends it, or what was refused and where.
    pub line: String,
    /// What was refused; none where there is a report.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub error: Option<Refusal>,
    /// Findings that fail, are undecided, and warn.
    pub findings: [u64; 3],
    /// Warnings about the file and how it was read.
    pub warnings: u64,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub triangles: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub bodies: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub size_mm: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub volume_mm3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub sha256: Option<String>,
    /// What was asked, as the start of a digest of all options and the version.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub asked: Option<String>,
    /// The start of a digest of the names of all parts of the batch that this is a share of.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub among: Option<String>,
    /// Folder of the results, below the folder of the table.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub folder: Option<String>,
    /// Wall-clock seconds when it was computed.
    pub seconds: f64,
    /// The most memory that the process held while the part was in work, MiB; where the system tells.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub peak_mib: Option<f64>,
    /// Whether the result is that of an earlier run.
    #[serde(default)]
    pub reused: bool,
}

/// An error as a table holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// `E011`.
    pub code: String,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub place: Option<String>,
    pub remedy: String,
}

impl Row {
    /// The line of a part that was judged.
    pub fn judged(part: &str, report: &Report, code: u8) -> Self {
        use crate::check::State;
        let count = |state: State| report.findings().iter().filter(|f| f.state == state).count() as u64;
        let [lo, hi] = report.part.box_mm;
        Row {
            verdict: Some(report.verdict),
            line: conclusion::alone(report),
            findings: [State::Fail, State::Undecided, State::Warn].map(count),
            warnings: report.warnings.len() as u64,
            triangles: Some(report.part.triangles),
            bodies: Some(report.part.bodies),
            size_mm: Some([0, 1, 2].map(|a| report_digits(hi[a] - lo[a]))),
            volume_mm3: Some(report.part.volume_mm3.value),
            sha256: Some(report.part.sha256.clone()),
            ..Row::empty(part, code)
        }
    }

    /// The line of a part that was refused.
    pub fn refused(part: &str, error: &Error) -> Self {
        let place = error.place();
        let line = match &place {
            Some(place) => format!("{error} ({place})"),
            None => error.to_string(),
        };
        Row {
            line,
            error: Some(Refusal { code: error.code().into(), place, remedy: error.remedy() }),
            ..Row::empty(part, error.exit_code())
        }
    }

    fn empty(part: &str, code: u8) -> Self {
        Row {
            part: part.into(),
            code,
            verdict: None,
            line: String::new(),
            error: None,
            findings: [0; 3],
            warnings: 0,
            triangles: None,
            bodies: None,
            size_mm: None,
            volume_mm3: None,
            sha256: None,
            asked: None,
            among: None,
            folder: None,
            seconds: 0.0,
            peak_mib: None,
            reused: false,
        }
    }

    /// How bad the line is, for a list that begins with the worst: what was not judged by its exit code, then parts by their verdict, whatever the exit
    /// code makes of it, and by how many findings there are of that state.
    pub fn badness(&self) -> impl Ord + use<> {
        let refused = self.verdict.is_none().then(|| rank(self.code));
        let [fails, undecided, warns] = self.findings;
        let count = match self.verdict {
            Some(Verdict::Fail) => fails,
            Some(Verdict::Undecided) => undecided,
            Some(Verdict::Warn) => warns,
            Some(Verdict::Pass) | None => 0,
        };
        (refused, self.verdict, count)
    }
}

fn rank(code: u8) -> usize {
    ORDER.iter().position(|c| *c == code).unwrap_or(ORDER.len())
}

/// The worst of exit codes in the order 0 3 1 4 5 6 70; 0 for none.
///
/// ```
/// assert_eq!(amcheck::batch::worst_code([0, 1, 3]), 1);
/// assert_eq!(amcheck::batch::worst_code([1, 5, 4]), 5);
/// ```
pub fn worst_code(codes: impl IntoIterator<Item = u8>) -> u8 {
    codes.into_iter().max_by_key(|c| rank(*c)).unwrap_or(0)
}
