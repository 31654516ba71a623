//! The tables of several runs as one.

use super::row::Row;
use super::shard::Shard;
use crate::error::{Error, Place, Result, printable};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Lines of several folders.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged {
    /// One line for each part, sorted by name; places of results are below, or relative to, the folder they are merged for.
    pub rows: Vec<Row>,
    /// Shares of a batch that have no table: index and count.
    pub missing: Vec<(u32, u32)>,
    /// What is odd about the tables, in words.
    pub notes: Vec<String>,
}

/// Joins the tables that batches left in folders, for a table in `out`.
///
/// A line that several tables have stands once. Where they say different things of a name, all of them stand, each with its folder
/// before its name. Of results below another of the folders, that folder's own table speaks.
///
/// # Errors
/// [`Error::CannotRead`] for a folder without a table, or with shares of two numbers; [`Error::Damaged`] with the line of a table that
/// is none.
pub fn merge(folders: &[PathBuf], out: &Path) -> Result<Merged> {
    let mut said: BTreeMap<String, Vec<(&Path, Row)>> = BTreeMap::new();
    let mut shares: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    let (mut asked, mut among) = (BTreeSet::new(), BTreeSet::new());
    // Whether a share is there twice, and so is of another batch.
    let mut several = false;
    for folder in folders {
        let others: Vec<Vec<String>> = folders.iter().map(|f| absolute(f)).filter(|f| *f != absolute(folder)).collect();
        for (table, share) in tables(folder)? {
            let seen = shares.entry(share.map_or(0, |s| s.count)).or_default();
            several |= share.is_some_and(|s| !seen.insert(s.index));
            for row in lines(&table)? {
                let place = row.folder.as_ref().map(|f| folder.join(f));
                if place.as_ref().is_some_and(|p| others.iter().any(|other| absolute(p).starts_with(other))) {
                    continue;
                }
                asked.extend(row.asked.clone().filter(|_| share.is_some()));
                among.extend(row.among.clone());
                let row = Row { folder: place.map(|p| relative(out, &p)), among: None, ..row };
                let known = said.entry(row.part.clone()).or_default();
                if !known.iter().any(|(_, other)| same(other, &row)) {
                    known.push((folder, row));
                }
            }
        }
    }
    let missing = shares
        .iter()
        .flat_map(|(&count, seen)| (1..=count).filter(|i| !seen.contains(i)).map(move |i| (i, count)))
        .collect();
    let otherwise = (asked.len() > 1).then_some("the shares were not all judged by the same options and version");
    let of_others = (among.len() > 1 && !several).then_some(
        "the shares are not all of the same list of parts: what was taken out of it since may still stand here, what was added may be missing; run \
         those again that are older, what was judged is not judged again",
    );
    let notes = otherwise.into_iter().chain(of_others).map(String::from).collect();
    let mut rows: Vec<Row> = said.into_values().flat_map(told_apart).collect();
    rows.sort_by(|a, b| a.part.cmp(&b.part));
    Ok(Merged { rows, missing, notes })
}

/// Whether two lines say the same of a part; when it was computed, and by what effort, does not matter.
fn same(a: &Row, b: &Row) -> bool {
    let timeless = |r: &Row| Row { seconds: 0.0, peak_mib: None, reused: false, ..r.clone() };
    timeless(a) == timeless(b)
}

/// The lines of one name; of several each gets its folder before its name.
fn told_apart(lines: Vec<(&Path, Row)>) -> Vec<Row> {
    let alone = lines.len() == 1;
    let named = |(folder, row): (&Path, Row)| match alone {
        true => row,
        false => Row { part: format!("{}/{}", folder.to_string_lossy().trim_end_matches('/'), row.part), ..row },
    };
    lines.into_iter().map(named).collect()
}

/// A table and the share that it is of.
type Table = (PathBuf, Option<Shard>);

/// The tables of a folder: those of shares, or the one without. Beside shares that one is what they were joined to before.
fn tables(folder: &Path) -> Result<Vec<Table>> {
    let refused = |reason: String, remedy: &str| Error::CannotRead {
        path: printable(&folder.to_string_lossy()),
        reason,
        remedy: remedy.into(),
    };
    let named = "name a folder that `amcheck batch` wrote to with --out";
    let members = fs::read_dir(folder).map_err(|e| refused(printable(&e.to_string()), named))?;
    let mut found: Vec<Table> = members
        .flatten()
        .filter_map(|m| {
            let name = m.file_name().to_string_lossy().into_owned();
            let tag = name.strip_prefix("table")?.strip_suffix(".jsonl")?.to_string();
            let share = Shard::tagged(&tag);
            (tag.is_empty() || share.is_some()).then(|| (m.path(), share))
        })
        .collect();
    found.sort_by_key(|(_, share)| share.map(|s| (s.count, s.index)));
    let counts: BTreeSet<u32> = found.iter().filter_map(|(_, share)| share.map(|s| s.count)).collect();
    match (counts.first(), counts.last()) {
        (Some(few), Some(many)) if few != many => {
            return Err(refused(
                format!("it holds shares of {few} and of {many}, which are of different runs"),
                "remove the tables that are out of date",
            ));
        }
        (Some(_), _) => found.retain(|(_, share)| share.is_some()),
        _ if found.is_empty() => return Err(refused("there is no table.jsonl in it".into(), named)),
        _ => {}
    }
    Ok(found)
}

fn lines(table: &Path) -> Result<Vec<Row>> {
    let shown = printable(&table.to_string_lossy());
    let text = fs::read_to_string(table).map_err(|e| Error::CannotRead {
        path: shown.clone(),
        reason: printable(&e.to_string()),
        remedy: "run the batch again".into(),
    })?;
    let row = |(i, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|e| Error::Damaged {
            format: "table",
            place: Place::Line(i as u64 + 1),
            problem: format!("{shown}: {}", printable(&e.to_string())),
            remedy: "run the batch again; what it judged before is not judged again".into(),
        })
    };
    text.lines().enumerate().filter(|(_, l)| !l.is_empty()).map(row).collect()
}

/// The parts of a path from the root on.
fn absolute(path: &Path) -> Vec<String> {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let mut parts: Vec<String> = Vec::new();
    for c in path.components() {
        match c {
            Component::ParentDir => drop(parts.pop()),
            Component::CurDir => {}
            other => parts.push(other.as_os_str().to_string_lossy().into_owned()),
        }
    }
    parts
}

/// A path as seen from a folder; with slashes.
fn relative(from: &Path, to: &Path) -> String {
    let (from, to) = (absolute(from), absolute(to));
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..".to_string(), from.len() - shared);
    up.chain(to[shared..].iter().cloned()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::{remove_outdated, write_tables};

    /// A folder for each name, empty.
    fn scratch(name: &str, folders: &[&str]) -> PathBuf {
        let dir = std::env::temp_dir().join(format!("amcheck-merge-{name}-{}", std::process::id()));
        folders.iter().for_each(|folder| fs::create_dir_all(dir.join(folder)).unwrap());
        dir
    }

    fn row(part: &str, code: u8) -> Row {
        Row { code, folder: Some(format!("parts/{part}")), ..Row::refused(part, &Error::Interrupted) }
    }

    fn share(index: u32, count: u32) -> Option<Shard> {
        Some(Shard { index, count })
    }

    fn seen(merged: &Merged) -> Vec<(&str, u8)> {
        merged.rows.iter().map(|r| (r.part.as_str(), r.code)).collect()
    }

    #[test]
    fn shares_of_other_lists_of_parts_are_told() {
        let dir = scratch("lists", &["a", "b"]);
        let of = |part: &str, among: &str| Row { among: Some(among.into()), ..row(part, 0) };
        write_tables(&dir.join("a"), share(1, 2), &[of("x", "6 parts")]).unwrap();
        write_tables(&dir.join("a"), share(2, 2), &[of("y", "6 parts")]).unwrap();
        assert_eq!(merge(&[dir.join("a")], &dir).unwrap().notes.len(), 0);
        // One share was run again after a part had gone.
        write_tables(&dir.join("a"), share(1, 2), &[of("x", "5 parts")]).unwrap();
        let notes = merge(&[dir.join("a")], &dir).unwrap().notes;
        assert!(notes.len() == 1 && notes[0].contains("not all of the same list"), "{notes:?}");
        // Two batches are of two lists.
        write_tables(&dir.join("a"), share(2, 2), &[of("y", "5 parts")]).unwrap();
        write_tables(&dir.join("b"), share(1, 2), &[of("z", "1 part")]).unwrap();
        write_tables(&dir.join("b"), share(2, 2), &[]).unwrap();
        assert_eq!(merge(&[dir.join("a"), dir.join("b")], &dir).unwrap().notes.len(), 0);
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn shares_become_one_table_and_a_missing_one_is_named() {
        let dir = scratch("shares", &["a", "b", "all"]);
        write_tables(&dir.join("a"), share(1, 3), &[row("x", 0)]).unwrap();
        // What was joined before says nothing beside the shares.
        write_tables(&dir.join("a"), None, &[row("x", 1), row("y", 1)]).unwrap();
        write_tables(&dir.join("b"), share(3, 3), &[row("y", 0), row("z", 4)]).unwrap();
        let merged = merge(&[dir.join("a"), dir.join("b")], &dir.join("all")).unwrap();
        assert_eq!(seen(&merged), [("x", 0), ("y", 0), ("z", 4)]);
        assert_eq!(merged.rows[0].folder.as_deref(), Some("../a/parts/x"));
        assert_eq!((merged.missing, merged.notes.len()), (vec![(2, 3)], 0));
        let other = |part: &str, asked: &str| Row { asked: Some(asked.into()), ..row(part, 0) };
        write_tables(&dir.join("a"), share(1, 3), &[other("x", "1")]).unwrap();
        write_tables(&dir.join("a"), share(2, 3), &[other("w", "2")]).unwrap();
        assert_eq!(merge(&[dir.join("a")], &dir).unwrap().notes.len(), 1);
        fs::write(dir.join("a/table-1-of-3.jsonl"), "{}\n").unwrap();
        assert_eq!(merge(&[dir.join("a")], &dir).unwrap_err().place().as_deref(), Some("line 1"));
        assert_eq!(merge(&[dir.join("all")], &dir).unwrap_err().exit_code(), 4);
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn shares_of_two_runs_are_refused_until_one_is_gone() {
        let dir = scratch("runs", &["a"]);
        let a = dir.join("a");
        write_tables(&a, share(1, 3), &[row("x", 0)]).unwrap();
        write_tables(&a, share(1, 2), &[row("x", 1)]).unwrap();
        let refused = merge(std::slice::from_ref(&a), &dir).unwrap_err();
        assert!(refused.to_string().contains("shares of 2 and of 3"), "{refused}");
        remove_outdated(&a, share(2, 2)).unwrap();
        assert_eq!(seen(&merge(std::slice::from_ref(&a), &dir).unwrap()), [("x", 1)]);
        remove_outdated(&a, None).unwrap();
        assert_eq!(fs::read_dir(&a).unwrap().count(), 0);
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn parts_of_one_name_all_stand() {
        let dir = scratch("names", &["a", "b"]);
        let (a, b) = (dir.join("a"), dir.join("b"));
        write_tables(&a, None, &[row("same", 0), row("x", 1)]).unwrap();
        write_tables(&b, None, &[row("x", 0)]).unwrap();
        let both = [a.clone(), b.clone()];
        let merged = merge(&both, &a).unwrap();
        let [in_a, in_b] = [&a, &b].map(|f| format!("{}/x", f.display()));
        assert_eq!(seen(&merged), [(in_a.as_str(), 1), (in_b.as_str(), 0), ("same", 0)]);
        // Joined again, what came from the other folder is taken from there.
        write_tables(&a, None, &merged.rows).unwrap();
        write_tables(&b, None, &[row("x", 3)]).unwrap();
        assert_eq!(seen(&merge(&both, &a).unwrap()), [(in_a.as_str(), 1), ("same", 0), ("x", 3)]);
        fs::remove_dir_all(&dir).unwrap();
    }
}
