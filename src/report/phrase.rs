//! Numbers, limits and verdicts as people read them; terminal, page and Markdown say the same words.

use super::schema::{CheckReport, RefinedReport, Report, Verdict};
use crate::check::{Accepted, Basis, Finding, Sense, State};
use crate::error::escaped;
use crate::units::{coarse, decimals_above_zero, decimals_of, hundredths, short, told};

/// The sign of a unit of the schema: `mm2` is `mm²`, a pure number has none.
pub fn unit_sign(unit: &str) -> &str {
    match unit {
        "deg" => "°",
        "mm2" => "mm²",
        "mm3" => "mm³",
        "1" => "",
        other => other,
    }
}

/// A value with its unit: `0.45 mm`, `45°`, `0.31`.
pub fn quantity(value: f64, unit: &str) -> String {
    with_unit(&short(value), unit)
}

/// A value above 0 in two digits, rounded up: what is said to be at most so much is.
pub fn at_most(value: f64, unit: &str) -> String {
    let decimals = 1.0 - value.max(1e-4).log10().floor();
    with_unit(&outward(value, decimals.clamp(0.0, 4.0) as usize, Direction::Up), unit)
}

/// A number already in digits, with its unit behind it.
fn with_unit(digits: &str, unit: &str) -> String {
    match unit_sign(unit) {
        "" => digits.to_string(),
        "°" => format!("{digits}°"),
        sign => format!("{digits} {sign}"),
    }
}

/// A number with fixed decimals, rounded down or up as `outward` says, never `-0`.
fn outward(value: f64, decimals: usize, direction: Direction) -> String {
    let scale = 10f64.powi(decimals as i32);
    // 1e-6 keeps 0.49 · 100 = 49.000000000000004 from being pushed to 0.50.
    let ticks = match direction {
        Direction::Down => (value * scale + 1e-6).floor(),
        Direction::Up => (value * scale - 1e-6).ceil(),
    };
    short(if ticks == 0.0 { 0.0 } else { ticks / scale })
}

/// Where a bracket's end is rounded to, so that the printed bracket still holds the truth.
#[derive(Clone, Copy)]
enum Direction {
    Down,
    Up,
}

/// The ends of a bracket, rounded outwards: `0.42–0.49`; `None` where value and bracket are one number.
///
/// A lower end above 0 keeps a digit that says so: what is there for certain is told from what may be nothing.
pub fn bracket(low: f64, high: f64) -> Option<String> {
    let width = high - low;
    (width > 1e-6).then(|| {
        let decimals = decimals_of(width);
        let lower = outward(low, decimals.max(decimals_above_zero(low)), Direction::Down);
        format!("{lower}–{}", outward(high, decimals, Direction::Up))
    })
}

/// Half of the last digit that is told: what is exact has no bracket that is narrower.
const ROUNDING: f64 = 0.5e-4;

/// The bracket that is told beside a finding's value, or the value of one of its places; none where it is rounding only.
pub fn bracket_of(f: &Finding, [low, high]: [f64; 2]) -> Option<String> {
    let is_rounding = f.basis == Basis::Exact && f.decided && high - low < ROUNDING;
    if is_rounding { None } else { bracket(low, high) }
}

/// A value at the digits its bracket supports, with its unit.
pub fn measured(value: f64, low: f64, high: f64, unit: &str) -> String {
    quantity(told(value, low, high), unit)
}

/// The worst value of a check that passes, for a list of names, and whether somebody accepts what is beyond its limits; no value where it has no unit, because a
/// bare number says nothing there.
pub fn beside_name(c: &CheckReport) -> String {
    let worst = c.worst.as_ref().filter(|w| !unit_sign(&w.unit).is_empty());
    let value = worst.map_or(String::new(), |w| format!(" {}", measured(w.value, w.low, w.high, &w.unit)));
    if accepted(c) > 0 { value + " (accepted)" } else { value }
}

/// How many findings of a check that are no passes somebody accepts.
pub fn accepted(c: &CheckReport) -> usize {
    c.findings.iter().filter(|f| f.state > State::Pass && f.accepted.is_some()).count()
}

/// How a value is known, in words for the page.
pub fn known(basis: Basis) -> &'static str {
    match basis {
        Basis::Exact => "exact",
        Basis::Certified => "certified",
        Basis::Estimated => "estimated",
    }
}

/// The relation a good value has to its limit.
pub fn relation(sense: Sense) -> &'static str {
    match sense {
        Sense::Min => "≥",
        Sense::Max => "≤",
    }
}

/// Both limits as one phrase: `must ≥ 0.5 mm, should ≥ 0.8 mm`; `no limit` without any.
pub fn limits(fail: Option<f64>, warn: Option<f64>, sense: Sense, unit: &str) -> String {
    let one =
        |word: &str, limit: Option<f64>| limit.map(|l| format!("{word} {} {}", relation(sense), quantity(l, unit)));
    let parts: Vec<String> = [one("must", fail), one("should", warn)].into_iter().flatten().collect();
    if parts.is_empty() { "no limit".into() } else { parts.join(", ") }
}

/// The limit a finding is judged by in its state: the one it breaks or holds.
pub fn deciding_limit(f: &Finding) -> Option<(&'static str, f64)> {
    let fail = f.fail.map(|l| ("must", l));
    let warn = f.warn.map(|l| ("should", l));
    match f.state {
        State::Fail | State::Undecided => fail.or(warn),
        _ => warn.or(fail),
    }
}

/// The limit a finding is judged by, as a phrase: `must ≥ 0.5 mm`.
pub fn deciding(f: &Finding) -> String {
    deciding_limit(f)
        .map_or("no limit".into(), |(word, l)| format!("{word} {} {}", relation(f.sense), quantity(l, &f.unit)))
}

/// The margin with sign and percent of the limit: `−0.35 mm (−44 %)`.
pub fn margin(value: f64, limit: f64, sense: Sense, unit: &str) -> String {
    let margin = match sense {
        Sense::Min => value - limit,
        Sense::Max => limit - value,
    };
    let sign = if margin < 0.0 { "−" } else { "+" };
    let digits = with_unit(&short(margin.abs()), unit);
    if limit.abs() > 1e-9 {
        let percent = (margin / limit * 100.0).abs();
        // What rounds to nothing is something.
        let percent =
            if percent > 0.0 && percent < 0.5 { format!("{percent:.2}") } else { percent.round().to_string() };
        format!("{sign}{digits} ({sign}{percent} %)")
    } else {
        format!("{sign}{digits}")
    }
}

/// That somebody accepts a finding, why and until when: `accepted until 2027-06-30: a membrane`; or that this has ended.
pub fn acceptance(f: &Finding) -> Option<String> {
    let said = |word: &str, until: &str, a: &Accepted| {
        let end = a.until.as_ref().map_or(String::new(), |d| format!(" {until} {d}"));
        format!("{word}{end}: {}", a.reason)
    };
    let ended = f.acceptance_ended.as_ref().map(|a| said("acceptance ended", "on", a));
    f.accepted.as_ref().map(|a| said("accepted", "until", a)).or(ended)
}

/// A point in millimetres, at a hundredth: `21.6, 0, 11`.
pub fn point(at_mm: [f64; 3]) -> String {
    at_mm.map(|x| short((x * 100.0).round() / 100.0)).join(", ")
}

/// Where a place lies in a box, in words: `top, front, left`; each axis is named in its outer thirds, x from left to right,
/// y from front to back, z from bottom to top. `middle` where no axis is.
pub fn whereabouts(p: [f64; 3], box_mm: [[f64; 3]; 2]) -> String {
    let words = [["left", "right"], ["front", "back"], ["bottom", "top"]];
    let side = |a: usize| {
        let share = (p[a] - box_mm[0][a]) / (box_mm[1][a] - box_mm[0][a]).max(1e-9);
        match share {
            s if s < 1.0 / 3.0 => Some(words[a][0]),
            s if s > 2.0 / 3.0 => Some(words[a][1]),
            _ => None,
        }
    };
    let named: Vec<&str> = [2, 1, 0].into_iter().filter_map(side).collect();
    if named.is_empty() { "middle".into() } else { named.join(", ") }
}

/// A text with its first letter as a capital, where it starts a sentence of its own.
pub fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Texts as sentences, one behind the other; none where there is no text.
pub fn sentences<'a>(texts: impl IntoIterator<Item = &'a str>) -> String {
    let told = texts.into_iter().map(|text| text.trim().trim_end_matches('.')).filter(|text| !text.is_empty());
    told.map(sentence).collect::<Vec<_>>().join(". ")
}

/// A word for a shell: quoted where it holds anything but letters, digits and a few signs.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "./_-+".contains(c);
    let word = escaped(word);
    if word.chars().all(plain) && !word.is_empty() { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// A file for a shell, which is no option however its name begins.
pub fn quoted_file(name: &str) -> String {
    if name.starts_with('-') { quoted(&format!("./{name}")) } else { quoted(name) }
}

/// A whole number in groups of three: `101,806`.
pub fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

/// What finer looks took, and what is left: `3 finer looks took 1,718,080 samples; 62,281,920 are left`.
pub fn finer_looks(refined: RefinedReport) -> String {
    let looks =
        if refined.looks == 1 { "1 finer look".into() } else { format!("{} finer looks", thousands(refined.looks)) };
    let lacking = refined.lacking.map_or(String::new(), |n| format!("; a look of {} was not taken", thousands(n)));
    let large = match refined.too_large {
        0 => String::new(),
        n => format!("; {} would take more memory than a window may", thousands(n)),
    };
    let [took, left] = [refined.samples, refined.left].map(thousands);
    format!("{looks} took {took} samples; {left} are left{lacking}{large}")
}

/// The extent of the part: `56 × 36 × 32.4 mm`, to hundredths where they tell it to a tenth.
pub fn extent(box_mm: [[f64; 3]; 2]) -> String {
    let side = |mm: f64| if mm < 0.1 { short(mm) } else { hundredths(mm) };
    let sides = [0, 1, 2].map(|a| side(box_mm[1][a] - box_mm[0][a]));
    format!("{} mm", sides.join(" × "))
}

/// The verdict as a headline.
pub fn headline(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "Printable",
        Verdict::Warn => "Printable, with warnings",
        Verdict::Undecided => "Cannot tell yet",
        Verdict::Fail => "Not printable as is",
    }
}

/// The state whose glyph and colour stand for a verdict.
pub fn verdict_state(verdict: Verdict) -> State {
    match verdict {
        Verdict::Pass => State::Pass,
        Verdict::Warn => State::Warn,
        Verdict::Undecided => State::Undecided,
        Verdict::Fail => State::Fail,
    }
}

/// The state as a word on a card.
pub fn state_word(state: State) -> &'static str {
    match state {
        State::Pass => "Passes",
        State::Warn => "Warning",
        State::Undecided => "Undecided",
        State::Fail => "Fails",
        State::Error => "Broke down",
        State::NotRun => "Not run",
        State::NotApplicable => "Not applicable",
    }
}

/// How many checks are in each state, worst first: `2 fail`, `1 undecided`, …, then how many findings are accepted;
/// what there is none of is left out.
pub fn counts(report: &Report) -> Vec<(State, usize, String)> {
    let checks = [
        (State::Fail, "fail"),
        (State::Error, "broke down"),
        (State::Undecided, "undecided"),
        (State::Warn, "warn"),
        (State::Pass, "pass"),
        (State::NotRun, "not run"),
        (State::NotApplicable, "not applicable"),
    ]
    .into_iter()
    .map(|(state, word)| (state, report.count(state), word));
    let accepted = (State::NotApplicable, report.accepted(), "accepted");
    let present = checks.chain([accepted]).filter(|(_, n, _)| *n > 0);
    present.map(|(state, n, word)| (state, n, format!("{n} {word}"))).collect()
}

/// A finding with the check it belongs to, its number in the report and its number within the check.
#[derive(Clone, Copy)]
pub struct Numbered<'a> {
    /// From 1, worst first over the whole report: the number on its pin.
    pub number: usize,
    /// From 1, within its check.
    pub within: usize,
    pub check: &'a CheckReport,
    pub finding: &'a Finding,
}

impl Numbered<'_> {
    /// The anchor of the finding in the page: `thin-wall-1`.
    pub fn anchor(&self) -> String {
        format!("{}-{}", self.check.name, self.within)
    }

    /// The state in whose colour it is shown: what somebody accepts is grey.
    pub fn shown(&self) -> State {
        if self.finding.accepted.is_some() { State::NotApplicable } else { self.finding.state }
    }

    /// What is measured, in the unit of the finding.
    pub fn measured(&self) -> String {
        measured(self.finding.value, self.finding.low, self.finding.high, &self.finding.unit)
    }

    /// The bracket that is told beside the value.
    pub fn bracket(&self) -> Option<String> {
        bracket_of(self.finding, [self.finding.low, self.finding.high])
    }

    /// The extent of the finding: area, volume and number of equal places, as far as they are known.
    pub fn size(&self) -> Vec<String> {
        let f = self.finding;
        let mut out = Vec::new();
        if f.count > 1 {
            out.push(format!("{} places", thousands(f.count)));
        }
        out.extend(f.area_mm2.map(|a| format!("{} mm²", coarse(a))));
        out.extend(f.volume_mm3.map(|v| format!("{} mm³", coarse(v))));
        out
    }
}

/// All findings that are not passes, worst first, each with its numbers.
pub fn numbered(report: &Report) -> Vec<Numbered<'_>> {
    let mut seen = std::collections::BTreeMap::<&str, usize>::new();
    report
        .ranked()
        .into_iter()
        .enumerate()
        .map(|(i, (check, finding))| {
            let within = seen.entry(&check.name).or_default();
            *within += 1;
            Numbered { number: i + 1, within: *within, check, finding }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Bracket, Limits};

    #[test]
    fn brackets_are_rounded_outwards_and_keep_two_digits() {
        assert_eq!(bracket(0.4212, 0.4873).as_deref(), Some("0.421–0.488"));
        assert_eq!(bracket(0.42, 0.49).as_deref(), Some("0.42–0.49"));
        assert_eq!(bracket(8.6, 9.74).as_deref(), Some("8.6–9.8"));
        assert_eq!(bracket(0.45, 0.45), None);
        // What is there for certain is not shown as nothing.
        assert_eq!(bracket(0.93, 75.3).as_deref(), Some("0.9–76"));
        assert_eq!(measured(0.45123, 0.42, 0.49, "mm"), "0.451 mm");
        assert_eq!(measured(45.0, 45.0, 45.0, "deg"), "45°");
    }

    #[test]
    fn margins_have_sign_and_percent() {
        assert_eq!(margin(0.45, 0.8, Sense::Min, "mm"), "−0.35 mm (−44 %)");
        assert_eq!(margin(10.0379, 10.0, Sense::Max, "mm"), "−0.0379 mm (−0.38 %)");
        assert_eq!(margin(0.8, 0.8, Sense::Min, "mm"), "+0 mm (+0 %)");
        assert_eq!(margin(9.2, 0.0, Sense::Max, "mm3"), "−9.2 mm³");
        assert_eq!(margin(3.72, 0.5, Sense::Min, "mm"), "+3.22 mm (+644 %)");
    }

    #[test]
    fn a_place_is_named_by_the_outer_thirds() {
        let of = |p| whereabouts(p, [[0.0; 3], [3.0, 30.0, 300.0]]);
        assert_eq!(of([0.5, 29.0, 299.0]), "top, back, left");
        assert_eq!(of([1.5, 15.0, 10.0]), "bottom");
        assert_eq!(of([1.5, 15.0, 150.0]), "middle");
    }

    #[test]
    fn texts_become_sentences() {
        assert_eq!(
            sentences(["a wall is thin", "0.15 mm, must ≥ 0.2 mm", "thicken it."]),
            "A wall is thin. 0.15 mm, must ≥ 0.2 mm. Thicken it"
        );
        assert_eq!(sentences(["a wall is thin", ""]), "A wall is thin");
    }

    #[test]
    fn words_for_a_shell_are_quoted() {
        assert_eq!(
            ["part.stl", "ä_1-2+.stl", "", "mein teil.stl"].map(quoted),
            ["part.stl", "ä_1-2+.stl", "''", "'mein teil.stl'"]
        );
        assert_eq!(quoted("p $(id) 'q'.stl"), r"'p $(id) '\''q'\''.stl'");
        // A command has to name the whole of it.
        assert_eq!(quoted(&"x".repeat(200)).len(), 200);
        assert_eq!(["-a.stl", "a b.stl"].map(quoted_file), ["./-a.stl", "'a b.stl'"]);
    }

    #[test]
    fn what_is_exact_has_no_bracket_of_rounding() {
        let of = |[low, high]: [f64; 2], basis: Basis| {
            let limits = Limits { fail: Some(0.8), warn: None, sense: Sense::Min };
            let f = Finding::judged("AM101", "wall", Bracket::new(low, low, high), basis, limits, "mm", 0.0);
            bracket_of(&f, [f.low, f.high])
        };
        assert_eq!(of([0.323437, 0.323439], Basis::Exact), None);
        assert_eq!(of([0.323437, 0.323439], Basis::Certified).as_deref(), Some("0.3234–0.3235"));
        // The circles of a hole stand beside its diameter, and what holds a limit is told with its ends.
        assert_eq!(of([0.31, 0.33], Basis::Exact).as_deref(), Some("0.31–0.33"));
        assert_eq!(of([0.799999, 0.800001], Basis::Exact).as_deref(), Some("0.7999–0.8001"));
    }

    #[test]
    fn what_is_at_most_so_much_is_never_more() {
        let told = [0.0312, 0.456, 12.31, 480.2].map(|value| at_most(value, "mm"));
        assert_eq!(told, ["0.032 mm", "0.46 mm", "13 mm", "481 mm"]);
    }

    #[test]
    fn whole_numbers_are_grouped() {
        assert_eq!([0, 999, 1000, 101806].map(thousands), ["0", "999", "1,000", "101,806"]);
    }
}
