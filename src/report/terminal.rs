//! The summary on a terminal: at most 30 lines, worst first, with the next command to type.

use super::phrase::{self, Numbered, quoted, quoted_file};
use super::schema::{CheckReport, RefinedReport, Report};
use crate::check::{Basis, Budget, State};
use crate::error::{Error, byte_count, printable};
use crate::units::short;

/// Lines that the whole summary may take.
const LINES: usize = 30;

/// Columns that a line may take.
const WIDTH: usize = 120;

/// Lines that the summary's sentence may take, and each list of checks: the names of all of them, with what most measure.
const OF_SUMMARY: usize = 3;
const OF_CHECKS: usize = 4;

/// Whether the text carries colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Palette {
    /// Text alone: not a terminal, or `NO_COLOR` is set.
    Plain,
    /// With ANSI escape sequences.
    Ansi,
}

/// What the summary says beside the report: where the files are and how long it took.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outputs {
    /// The part as it was named on the command line; the commands to type next repeat it.
    pub part: String,
    /// The options that say what it is judged by, word for word; those commands repeat them, too.
    pub judged_by: Vec<String>,
    /// What was written: a word (`report`, `data`, `pictures`), the place, and its length in bytes.
    pub written: Vec<(String, String, u64)>,
    /// Notes on the folder: what it holds, or held, of another part.
    pub notes: Vec<String>,
    /// Wall-clock seconds of the run.
    pub seconds: Option<f64>,
}

impl Palette {
    /// The text in the colour of a state.
    pub(super) fn state(self, state: State, text: &str) -> String {
        let code = match state {
            State::Fail | State::Error => "1;31",
            State::Warn => "33",
            State::Undecided => "1;34",
            State::Pass => "32",
            State::NotRun | State::NotApplicable => "2",
        };
        self.wrap(code, text)
    }

    fn wrap(self, code: &str, text: &str) -> String {
        match self {
            Palette::Plain => text.to_string(),
            Palette::Ansi => format!("\u{1b}[{code}m{text}\u{1b}[0m"),
        }
    }
}

/// The summary: part, verdict, findings worst first with their fixes, passes, files and the next command.
///
/// At most 30 lines; findings that do not fit are counted and left to the report. Names from files are printed with
/// their control characters escaped.
pub fn summary(report: &Report, outputs: &Outputs, palette: Palette) -> String {
    let findings = phrase::numbered(report);
    let mut lines = header(report, palette);
    lines.extend([String::new(), verdict(report, outputs, palette)]);
    lines.extend(wrapped(&printable_sentence(&report.summary), OF_SUMMARY));
    lines.push(String::new());
    let rest = rest(report, outputs, &findings, palette);
    // Two lines each, and one that counts those left out.
    let room = LINES.saturating_sub(lines.len() + rest.len() + 1) / 2;
    let shown = chosen(&findings, room);
    for n in &shown {
        lines.extend(finding(n, palette));
    }
    let counting = findings.iter().filter(|n| n.finding.counts()).count();
    if counting > shown.len() {
        lines.push(palette.wrap("2", &format!("… {} more in the report", counting - shown.len())));
    }
    lines.extend(rest);
    lines.join("\n") + "\n"
}

/// The findings for which there is room, worst first: in each state, the worst of every check before the second of any.
fn chosen<'a, 'r>(findings: &'a [Numbered<'r>], room: usize) -> Vec<&'a Numbered<'r>> {
    let mut shown: Vec<&Numbered> = findings.iter().filter(|n| n.finding.counts()).collect();
    shown.sort_by_key(|n| (std::cmp::Reverse(n.finding.state), n.within, n.number));
    shown.truncate(room);
    shown.sort_by_key(|n| n.number);
    shown
}

/// The findings that somebody accepts, one line each, at most three.
fn accepted(findings: &[Numbered], palette: Palette) -> Vec<String> {
    let held: Vec<&Numbered> = findings.iter().filter(|n| n.finding.accepted.is_some()).collect();
    let line = |n: &&Numbered| {
        let why = phrase::acceptance(n.finding).unwrap_or_default();
        let name = format!("– {}[{}]", printable(&n.check.name), n.within);
        palette.wrap("2", &clipped(&format!("{name:<20} {:<10} {}", n.measured(), printable_sentence(&why))))
    };
    let mut lines: Vec<String> = held.iter().take(3).map(line).collect();
    if held.len() > 3 {
        lines.push(palette.wrap("2", &format!("… {} more accepted findings in the report", held.len() - 3)));
    }
    lines
}

/// What follows the findings: other checks, a note, the files, the next command.
fn rest(report: &Report, outputs: &Outputs, findings: &[Numbered], palette: Palette) -> Vec<String> {
    let mut lines = accepted(findings, palette);
    lines.extend(other_checks(report, palette));
    lines.extend(refined(report).map(|line| palette.wrap("2", &clipped(&line))));
    lines.extend(report.thickness.as_ref().and_then(|t| t.sentence()).map(|s| clipped(&format!("thickness: {s}"))));
    // The head has said already that the unit is assumed.
    let mut notes = report.warnings.iter().filter(|w| w.code != "units-assumed");
    if let Some(first) = notes.next() {
        let more = notes.count();
        let more = if more > 0 { format!(" (and {more} more in the report)") } else { String::new() };
        lines.push(clipped(&format!("note: {}{more}", printable_sentence(&first.message))));
    }
    lines.extend(outputs.notes.iter().map(|text| note(text)));
    lines.push(String::new());
    for (what, place, length) in outputs.written.iter().take(3) {
        lines.push(format!("{what:<8}{} ({})", printable(place), byte_count((*length).into())));
    }
    lines.extend(next_command(report, findings, outputs));
    lines
}

/// A note of one line.
pub fn note(text: &str) -> String {
    clipped(&format!("note: {text}"))
}

/// What deciding took beyond the first looks, in one line: the checks that took most first.
fn refined(report: &Report) -> Option<String> {
    let not_taken = |r: &RefinedReport| r.lacking.is_some() || r.too_large > 0;
    let each = report.checks.iter().filter_map(|c| Some((c, c.refined?)));
    let mut took: Vec<(&CheckReport, RefinedReport)> =
        each.filter(|(c, r)| r.looks > 0 || (is_open(c) && not_taken(r))).collect();
    took.sort_by_key(|(_, r)| std::cmp::Reverse(r.samples));
    let each = |(c, r): &(&CheckReport, RefinedReport)| {
        let [took, left] = [r.samples, r.left].map(millions);
        let looks = if r.looks == 1 { "look" } else { "looks" };
        let lacking = r.lacking.filter(|_| is_open(c));
        let lacking = lacking.map_or(String::new(), |n| format!(", a look of {} not taken", millions(n)));
        let large = match r.too_large {
            n if n > 0 && is_open(c) => format!(", {n} too large for memory"),
            _ => String::new(),
        };
        format!("{} {} {looks}, {took} samples, {left} left{lacking}{large}", printable(&c.name), r.looks)
    };
    (!took.is_empty()).then(|| format!("refined: {}", took.iter().map(each).collect::<Vec<_>>().join("; ")))
}

/// Whether anything that the check found is not decided.
fn is_open(check: &CheckReport) -> bool {
    check.findings.iter().any(|f| !f.decided)
}

/// A number of samples as `1.7M`, or in full where that would be `0M`.
fn millions(samples: u64) -> String {
    match samples {
        0..50_000 => phrase::thousands(samples),
        _ => format!("{}M", short((samples as f64 / 1e5).round() / 10.0)),
    }
}

/// The verdict alone, for `--quiet`.
pub fn verdict_line(report: &Report, palette: Palette) -> String {
    verdict(report, &Outputs::default(), palette) + "\n"
}

/// An error in at most five lines: what, where, what to try, and how to learn more.
///
/// ```
/// use amcheck::{Error, error::Place, report::terminal::{self, Palette}};
/// let e = Error::Damaged { format: "STL", place: Place::Byte(84), problem: "17 facets are missing".into(),
///                          remedy: "export the part again".into() };
/// assert_eq!(terminal::error(&e, Some("part.stl"), Palette::Plain),
///     "error[E011]: damaged STL: 17 facets are missing\n  --> part.stl: byte 84\n  help: export the part again\n  \
///      explain: amcheck explain E011\n");
/// ```
pub fn error(error: &Error, file: Option<&str>, palette: Palette) -> String {
    let head = palette.wrap("1;31", &format!("error[{}]:", error.code()));
    let mut out = format!("{head} {}\n", printable_sentence(&error.to_string()));
    let place = match (file.map(printable), error.place()) {
        (Some(file), Some(place)) => Some(format!("{file}: {place}")),
        (file, place) => file.or(place),
    };
    if let Some(place) = place {
        out.push_str(&format!("  --> {place}\n"));
    }
    out.push_str(&format!(
        "  help: {}\n  explain: amcheck explain {}\n",
        printable_sentence(&error.remedy()),
        error.code()
    ));
    out
}

/// Part and process, two lines.
fn header(report: &Report, palette: Palette) -> Vec<String> {
    let part = &report.part;
    let tight = if part.watertight { "watertight" } else { "not watertight" };
    let bodies = if part.bodies == 1 { "1 body".into() } else { format!("{} bodies", phrase::thousands(part.bodies)) };
    vec![
        format!(
            "amcheck {}  {}  {}, {} triangles, {bodies}, {tight}",
            printable(&report.tool.version),
            palette.wrap("1", &printable(&part.file)),
            phrase::extent(part.box_mm),
            phrase::thousands(part.triangles),
        ),
        format!(
            "process {} ({})   grid {}   units {} ({})",
            printable(&report.process.name),
            printable(&report.process.title),
            phrase::quantity(report.grid.spacing_mm, "mm"),
            printable(&part.units),
            printable(&part.units_from),
        ),
    ]
}

/// The verdict with its counts and the time it took.
fn verdict(report: &Report, outputs: &Outputs, palette: Palette) -> String {
    let state = phrase::verdict_state(report.verdict);
    let headline = format!("{} {}", state.glyph(), phrase::headline(report.verdict).to_uppercase());
    let mut out = palette.wrap("1", &palette.state(state, &headline));
    for (state, _, words) in phrase::counts(report) {
        out.push_str("   ");
        out.push_str(&palette.state(state, &words));
    }
    if let Some(seconds) = outputs.seconds {
        out.push_str(&palette.wrap("2", &format!("   {seconds:.1} s")));
    }
    out
}

/// One finding in two lines: value, bracket, limit, place; then what to change.
fn finding(n: &Numbered, palette: Palette) -> [String; 2] {
    let f = n.finding;
    let name = format!("{} {}[{}]", f.state.glyph(), printable(&n.check.name), n.within);
    let held = match (n.bracket(), f.basis) {
        (Some(bracket), Basis::Estimated) => format!("(est. {bracket})"),
        (Some(bracket), _) => format!("({bracket})"),
        (None, Basis::Estimated) => "(estimated)".into(),
        (None, _) => "(exact)".into(),
    };
    let mut line = format!(
        "{:<20} {:<10} {:<15} {:<17} at {}",
        name,
        n.measured(),
        held,
        phrase::deciding(f),
        phrase::point(f.at_mm)
    );
    for size in n.size() {
        let longer = format!("{line}   {size}");
        if longer.chars().count() <= WIDTH {
            line = longer;
        }
    }
    let word = if f.state == State::Undecided { "decide" } else { "fix" };
    let ended = phrase::acceptance(f).map_or(String::new(), |said| format!("{}; ", printable_sentence(&said)));
    let line = clipped(&line);
    [
        line.replacen(&name, &palette.state(f.state, &name), 1),
        clipped(&format!("    {ended}{word}: {}", printable_sentence(&f.fix))),
    ]
}

/// The checks without findings: passes with their worst values, what did not run and why.
fn other_checks(report: &Report, palette: Palette) -> Vec<String> {
    let named = |state: State| report.checks.iter().filter(move |c| c.state == state);
    let list = |state: State, words: &str, items: Vec<String>| -> Vec<String> {
        if items.is_empty() {
            return Vec::new();
        }
        let line = format!("{} {} {words}: {}", state.glyph(), items.len(), items.join(", "));
        wrapped(&line, OF_CHECKS).iter().map(|l| palette.state(state, l)).collect()
    };
    let passes = named(State::Pass).map(|c| printable(&c.name) + &phrase::beside_name(c));
    // Reasons fit for one or two; the page has all.
    let reasons = |state: State| {
        let few = named(state).count() <= 2;
        let why = |c: &CheckReport| printable(c.why.as_deref().unwrap_or("no reason given"));
        let one =
            |c: &CheckReport| if few { format!("{} ({})", printable(&c.name), why(c)) } else { printable(&c.name) };
        named(state).map(one).collect()
    };
    [
        list(State::Pass, "pass", passes.collect()),
        list(State::Error, "broke down", reasons(State::Error)),
        list(State::NotRun, "not run", reasons(State::NotRun)),
        list(State::NotApplicable, "not applicable", reasons(State::NotApplicable)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The command that helps most now: decide what is undecided, else explain the worst check.
fn next_command(report: &Report, findings: &[Numbered], outputs: &Outputs) -> Option<String> {
    let worst = findings.first().filter(|n| n.finding.counts())?;
    // More samples decide what is bracketed, not what is estimated.
    let open = findings
        .iter()
        .find(|n| n.finding.state == State::Undecided)
        .filter(|open| worst.finding.state == State::Undecided && open.finding.basis != Basis::Estimated);
    let command = match open.and_then(|open| Some((open, budget_that_helps(report, open.check)?))) {
        Some((open, budget)) => {
            let by: String = outputs.judged_by.iter().map(|word| format!(" {}", quoted(word))).collect();
            format!(
                "amcheck {}{by} --only {} --refine {budget}M",
                quoted_file(&outputs.part),
                printable(&open.check.name)
            )
        }
        None => format!("amcheck explain {}", printable(&worst.check.name)),
    };
    Some(format!("{:<8}{command}", "next"))
}

/// Checks whose lattice no budget makes finer.
const NO_FINER: [&str; 2] = ["support-access", "tool-access"];

/// Millions of samples with which a look would be taken that was not; `None` where samples are not what is lacking.
fn budget_that_helps(report: &Report, check: &CheckReport) -> Option<u64> {
    match check.refined {
        _ if NO_FINER.contains(&check.name.as_str()) => None,
        Some(RefinedReport { samples, lacking: Some(lacking), .. }) => Some((samples + lacking).div_ceil(1_000_000)),
        Some(RefinedReport { too_large, .. }) if too_large > 0 => None,
        _ => Some(Budget::more_than(report.grid.refine_budget)),
    }
}

/// A sentence with control characters escaped; unlike a name it may be long.
fn printable_sentence(text: &str) -> String {
    let escaped = |c: char| if c.is_control() { c.escape_default().collect() } else { String::from(c) };
    text.chars().map(escaped).collect()
}

/// A line cut to the width of the summary: between words, unless one of them is longer than that.
fn clipped(line: &str) -> String {
    if line.chars().count() <= WIDTH {
        return line.into();
    }
    let most: String = line.chars().take(WIDTH - 1).collect();
    // What a line of findings is indented by is no word.
    let words = most.rfind(' ').map(|end| most[..end].trim_end()).filter(|kept| 2 * kept.len() > WIDTH);
    words.map_or_else(|| format!("{most}…"), |kept| format!("{kept} …"))
}

/// A sentence in at most so many lines, broken between words; what does not fit is cut.
fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.last().map_or(0, |l| l.chars().count());
        if last > 0 && last + 1 + word.chars().count() > WIDTH && lines.len() < most {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.iter().map(|l| clipped(l)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_samples_are_told_in_full() {
        assert_eq!([0, 33_120, 50_000, 1_718_080].map(millions), ["0", "33,120", "0.1M", "1.7M"]);
    }

    #[test]
    fn lines_are_cut_between_words() {
        let words = vec!["ninechars"; 40].join(" ");
        let lines = wrapped(&words, 2);
        assert_eq!(lines[0], ["ninechars"; 12].join(" "));
        assert_eq!(lines[1], ["ninechars"; 11].join(" ") + " …");
        assert_eq!(wrapped(&words, 4).join(" "), words);
        // One word that is longer than a line is cut where the line ends.
        let long = clipped(&format!("name {}", "x".repeat(200)));
        assert_eq!((long.chars().count(), long.ends_with("x…")), (WIDTH, true));
    }
}
