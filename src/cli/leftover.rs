//! What an earlier run left in a folder that this run does not write again: reports and pictures of another answer.

use super::deliver::cannot;
use super::record::{self, Record};
use crate::check::registry::CHECKS;
use crate::error::Result;
use crate::io::Temporary;
use std::io::ErrorKind;
use std::path::Path;

/// Reports that judging a part writes. Meshes and timings are not among them: a mended part stays until a part is to be repaired again.
const REPORTS: [&str; 7] =
    ["report.html", "report.json", "report.glb", "report.md", "report.junit.xml", "report.sarif", "badge.svg"];

/// Pictures that judging a part writes, beside those named after checks.
const PICTURES: [&str; 7] =
    ["summary", "slice-x", "slice-y", "slice-z", "local-thickness", "ray-thickness", "local-gap"];

/// Whether judging a part names a file like this.
pub fn of_judging(name: &str) -> bool {
    let picture = |stem: &str| {
        let check = stem.strip_prefix("close-").unwrap_or(stem);
        PICTURES.contains(&stem) || CHECKS.iter().any(|c| c.meta().name == check)
    };
    REPORTS.contains(&name) || name.strip_suffix(".png").is_some_and(picture)
}

/// Whether judging and repairing a part names a file like this.
pub fn of_repairing(name: &str) -> bool {
    of_judging(name) || name == "repaired.3mf"
}

/// Whether comparing orientations names a file like this.
pub fn of_orienting(name: &str) -> bool {
    let rank = name.strip_prefix("orientation-").and_then(|rest| rest.strip_suffix(".png"));
    let numbered = rank.is_some_and(|rank| !rank.is_empty() && rank.bytes().all(|b| b.is_ascii_digit()));
    ["orientations.html", "orientations.json", "best.stl"].contains(&name) || numbered
}

/// Removes the files that runs are known to have left in a folder, that are `known` as well and not among those just written; `read` is spared,
/// because it was asked about. What somebody else put there, or changed since, stays whatever its name.
///
/// # Errors
/// [`crate::Error::CannotWrite`] naming the file.
pub fn remove(folder: &Path, written: &[String], known: fn(&str) -> bool, read: &[&Path]) -> Result<()> {
    let read: Vec<_> = read.iter().filter_map(|path| path.canonicalize().ok()).collect();
    let listed = Record::of(folder);
    let standing = listed.standing(folder);
    let mut removed = Vec::new();
    for name in standing.names().filter(|name| known(name) && !written.iter().any(|w| w == name)) {
        let path = folder.join(name);
        if path.canonicalize().is_ok_and(|path| read.contains(&path)) {
            continue;
        }
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(cannot(&path, &e)),
            _ => removed.push(name.to_string()),
        }
    }
    let left = standing.without(&removed);
    if left != listed {
        relist(folder, &left)?;
    }
    Ok(())
}

/// Puts a list in the place of the one that a folder has.
fn relist(folder: &Path, record: &Record) -> Result<()> {
    let place = folder.join(record::NAME);
    let partial = Temporary::claim(folder.join(format!("{}.{}.partial", record::NAME, std::process::id())));
    let write = || std::fs::write(partial.path(), record.text());
    write().and_then(|()| partial.rename_to(&place)).map_err(|e| cannot(&place, &e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_amcheck_names_goes() {
        for name in ["report.md", "close-blend.png", "thin-wall.png", "slice-x.png"] {
            assert!(of_judging(name) && !of_orienting(name), "{name}");
        }
        for name in ["repaired.3mf", "timings.json", "photo.png", "thumbnail.png", "my-report.html", "report.pdf"] {
            assert!(!of_judging(name) && !of_orienting(name), "{name}");
        }
        assert!(of_repairing("repaired.3mf") && of_repairing("report.md") && !of_repairing("photo.png"));
        assert!(of_orienting("orientation-12.png") && !of_orienting("orientation-.png"));
        assert!(of_orienting("best.stl") && !of_orienting("my-best.stl"));
    }
}
