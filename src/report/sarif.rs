//! The report as SARIF 2.1.0 (OASIS), for lists of alerts.
//!
//! A part has no lines, and alert lists ask for one: every result names line 1 of the part's file, and says its place in
//! millimetres in the message and the properties. The file is named from the folder the tool ran in, for lists of alerts find it from there.

use super::baseline::{self, Change, Comparison, Delta};
use super::phrase::{self, Numbered};
use super::schema::Report;
use crate::check::State;
use crate::error::Error;
use crate::units::report_digits;
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::{Component, Path, Prefix};

/// Most results in one run; lists of alerts take no more.
const MOST: usize = 25_000;

/// The report on the part at a path as SARIF text with a line feed at its end; results worst first, at most 25,000.
///
/// Beside a baseline every result says whether it is new, unchanged or updated, as one is that was accepted and is not now, with a message that says so; and
/// what was between bodies that are one now is a result of its own. What is gone is not told: lists of alerts close what they are no longer told, and would
/// take it for another alert.
///
/// A relative path leads from the folder the tool ran in, one that starts at a root has the scheme `file`; of one that climbs above that folder the
/// file's name stands alone.
pub fn write(report: &Report, part: &Path, comparison: Option<&Comparison>) -> String {
    let file = reference(part).unwrap_or_else(|| encoded(report.part.file.as_ref()));
    let findings = phrase::numbered(report);
    let rules: Vec<Value> = report
        .checks
        .iter()
        .map(|c| {
            json!({"id": c.code, "name": c.name, "shortDescription": {"text": c.title},
                "help": {"text": format!("amcheck explain {}", c.name)}})
        })
        .collect();
    let told = findings.iter().map(|n| {
        let change = comparison.and_then(|c| c.of(n.finding));
        since(result(report, n, change, &file), change)
    });
    let one_body = comparison.into_iter().flat_map(|c| &c.changes).filter(|c| c.news().is_some() && c.new.is_none());
    let joined = one_body.filter_map(|c| joined(report, c, &file));
    let results: Vec<Value> = joined.chain(told).take(MOST).collect();
    let silent: Vec<Value> = report
        .checks
        .iter()
        .filter_map(|c| c.why.as_ref().map(|why| (c, why)))
        .map(|(c, why)| {
            let level = if c.state == State::Error { "error" } else { "note" };
            json!({"level": level, "associatedRule": {"id": c.code}, "message": {"text": format!("{}: {why}", c.state.word())}})
        })
        .collect();
    document(json!({
        "tool": {"driver": {"name": report.tool.name, "version": report.tool.version, "rules": rules}},
        "columnKind": "unicodeCodePoints",
        "artifacts": [{"location": {"uri": file}, "hashes": {"sha-256": report.part.sha256}}],
        "invocations": [{"executionSuccessful": report.count(State::Error) == 0, "toolConfigurationNotifications": silent}],
        "results": results,
    }))
}

/// Of the part at a path, which was refused: one result of level *error*, and a run that did not succeed.
pub fn refused(part: &Path, error: &Error) -> String {
    let file = reference(part).unwrap_or_else(|| encoded(part.file_name().unwrap_or(part.as_os_str())));
    let place = error.place().map_or(String::new(), |place| format!(" ({place})"));
    let text = phrase::sentences([format!("{error}{place}").as_str(), &error.remedy()]);
    let rule = json!({"id": error.code(), "name": "refused", "shortDescription": {"text": "A part that could not be judged"},
        "help": {"text": format!("amcheck explain {}", error.code())}});
    let told = json!({"level": "error", "descriptor": {"id": error.code()}, "message": {"text": text}});
    document(json!({
        "tool": {"driver": {"name": "amcheck", "version": env!("CARGO_PKG_VERSION"), "rules": [rule]}},
        "columnKind": "unicodeCodePoints",
        "artifacts": [{"location": {"uri": file}}],
        "invocations": [{"executionSuccessful": false, "exitCode": error.exit_code(), "toolExecutionNotifications": [told]}],
        "results": [{"ruleId": error.code(), "ruleIndex": 0, "level": "error", "message": {"text": text}, "locations": [location(&file)]}],
    }))
}

/// A file of one run.
fn document(run: Value) -> String {
    let document =
        json!({"$schema": "https://json.schemastore.org/sarif-2.1.0.json", "version": "2.1.0", "runs": [run]});
    serde_json::to_string_pretty(&document).unwrap_or_default() + "\n"
}

fn result(report: &Report, n: &Numbered, change: Option<&Change>, file: &str) -> Value {
    let f = n.finding;
    let level = match f.state {
        State::Fail => "error",
        State::Undecided => "note",
        _ => "warning",
    };
    let bracket = n.bracket().map_or(String::new(), |b| format!(" ({b})"));
    let measured = format!("{}{bracket}, {}, at {} mm", n.measured(), phrase::deciding(f), phrase::point(f.at_mm));
    let withdrawn = change.and_then(Change::withdrawn).unwrap_or_default();
    let text = phrase::sentences([f.message.as_str(), &measured, withdrawn, &f.fix]);
    let rule = report.checks.iter().position(|c| c.name == n.check.name).unwrap_or(0);
    let mut result = json!({
        "ruleId": n.check.code,
        "ruleIndex": rule,
        "level": level,
        "message": {"text": text},
        "locations": [location(file)],
        "partialFingerprints": {"amcheck/v1": f.fingerprint},
        "properties": {
            "state": f.state.word(), "value": report_digits(f.value), "low": report_digits(f.low),
            "high": report_digits(f.high), "unit": f.unit, "at_mm": f.at_mm.map(report_digits)
        },
    });
    if let Some(a) = &f.accepted {
        let until = a.until.as_ref().map(|d| json!({"until": d}));
        result["suppressions"] = json!([{"kind": "external", "status": "accepted", "justification": a.reason}]);
        if let Some(until) = until {
            result["suppressions"][0]["properties"] = until;
        }
    }
    result
}

/// A result with what it was in the baseline, where it was compared with one: nothing is said where that did not run the check.
fn since(mut result: Value, change: Option<&Change>) -> Value {
    if let Some(change) = change.filter(|c| c.delta != Delta::Unchecked || c.old.is_some()) {
        result["baselineState"] = match change.delta {
            Delta::New => "new",
            Delta::Worse | Delta::Better => "updated",
            Delta::Same if change.is_no_longer_accepted() => "updated",
            Delta::Same | Delta::Unchecked | Delta::Fixed => "unchanged",
        }
        .into();
    }
    result
}

/// What was between bodies that are one now, which no finding of the report tells.
fn joined(report: &Report, change: &Change, file: &str) -> Option<Value> {
    let f = change.old.as_ref()?;
    let rule = report.checks.iter().position(|c| c.name == change.check)?;
    let level = if change.news() == Some(State::Fail) { "error" } else { "warning" };
    let result = json!({
        "ruleId": f.code,
        "ruleIndex": rule,
        "level": level,
        "message": {"text": phrase::sentence(&baseline::from_to(change))},
        "locations": [location(file)],
        "partialFingerprints": {"amcheck/v1": f.fingerprint},
    });
    Some(since(result, Some(change)))
}

/// Line 1 of the part's file: it has no lines, and lists of alerts ask for one.
fn location(file: &str) -> Value {
    json!({"physicalLocation": {"artifactLocation": {"uri": file, "index": 0}, "region": {"startLine": 1}}})
}

/// A path as a reference (RFC 3986): relative where it leads down from where it starts, with the scheme `file` (RFC 8089) where it starts at a root.
fn reference(path: &Path) -> Option<String> {
    let (mut root, mut names) = (None, Vec::new());
    for component in path.components() {
        match component {
            Component::Normal(name) => names.push(encoded(name)),
            Component::CurDir => {}
            Component::RootDir => root = root.or(Some("file://".to_string())),
            Component::Prefix(prefix) => root = Some(volume(prefix.kind())?),
            Component::ParentDir => return None,
        }
    }
    // A file named `-` is standard input.
    (!names.is_empty() && names != ["-"]).then(|| root.into_iter().chain(names).collect::<Vec<_>>().join("/"))
}

/// What a drive or a share of Windows begins a reference with.
fn volume(prefix: Prefix) -> Option<String> {
    match prefix {
        Prefix::Disk(letter) | Prefix::VerbatimDisk(letter) => Some(format!("file:///{}:", char::from(letter))),
        Prefix::UNC(server, share) | Prefix::VerbatimUNC(server, share) => {
            Some(format!("file://{}/{}", encoded(server), encoded(share)))
        }
        Prefix::Verbatim(_) | Prefix::DeviceNS(_) => None,
    }
}

/// A file name in a reference: everything but unreserved signs is percent-encoded.
fn encoded(name: &OsStr) -> String {
    let keep = |b: u8| b.is_ascii_alphanumeric() || b"-._~".contains(&b);
    let sign = |&b: &u8| if keep(b) { char::from(b).to_string() } else { format!("%{b:02X}") };
    name.as_encoded_bytes().iter().map(sign).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_named_from_where_the_tool_ran() {
        let named = |path: &str| reference(Path::new(path));
        assert_eq!(named("./left side/a#1.stl").as_deref(), Some("left%20side/a%231.stl"));
        assert_eq!(named("a.stl").as_deref(), Some("a.stl"));
        for elsewhere in ["../a.stl", "b/../../a.stl", "/b/../a.stl", "-", ""] {
            assert_eq!(named(elsewhere), None, "{elsewhere}");
        }
        if cfg!(unix) {
            assert_eq!(named("/left side/ü.stl").as_deref(), Some("file:///left%20side/%C3%BC.stl"));
        }
        let [disk, server, share] = [OsStr::new("c"), OsStr::new("a b"), OsStr::new("s")];
        assert_eq!(volume(Prefix::UNC(server, share)).as_deref(), Some("file://a%20b/s"));
        assert_eq!((volume(Prefix::Disk(b'C')).as_deref(), volume(Prefix::Verbatim(disk))), (Some("file:///C:"), None));
    }
}
