//! The tables of several runs as one.

use super::row::Row;
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
}

/// Joins the tables that batches left in folders, for a table in `out`.
///
/// Where two tables have a line for the same part, that of the folder named last stands.
///
/// # Errors
/// [`Error::CannotRead`] for a folder without a table; [`Error::Damaged`] with the line of a table that is none.
pub fn merge(folders: &[PathBuf], out: &Path) -> Result<Merged> {
    let mut rows: BTreeMap<String, Row> = BTreeMap::new();
    let mut shares: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for folder in folders {
        let tables = tables(folder)?;
        // A table of shares that were merged before stands back behind the shares themselves.
        for (table, share) in &tables {
            if let Some((index, count)) = share {
                shares.entry(*count).or_default().insert(*index);
            }
            for row in lines(table)? {
                let folder = row.folder.as_ref().map(|f| relative(out, &folder.join(f)));
                rows.insert(row.part.clone(), Row { folder, ..row });
            }
        }
    }
    let missing = shares
        .iter()
        .flat_map(|(&count, seen)| (1..=count).filter(|i| !seen.contains(i)).map(move |i| (i, count)))
        .collect();
    Ok(Merged { rows: rows.into_values().collect(), missing })
}

/// A table and the share that it is of.
type Table = (PathBuf, Option<(u32, u32)>);

/// The tables of a folder: first the one without a share.
fn tables(folder: &Path) -> Result<Vec<Table>> {
    let refused = |reason: String| Error::CannotRead {
        path: printable(&folder.to_string_lossy()),
        reason,
        remedy: "name a folder that `amcheck batch` wrote to with --out".into(),
    };
    let members = fs::read_dir(folder).map_err(|e| refused(printable(&e.to_string())))?;
    let mut found: Vec<Table> = members
        .flatten()
        .filter_map(|m| {
            let name = m.file_name().to_string_lossy().into_owned();
            let tag = name.strip_prefix("table")?.strip_suffix(".jsonl")?.to_string();
            let share = tag.strip_prefix('-').and_then(|t| t.split_once("-of-"));
            let share = share.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
            (tag.is_empty() || share.is_some()).then(|| (m.path(), share))
        })
        .collect();
    found.sort_by_key(|(_, share)| *share);
    if found.is_empty() {
        return Err(refused("there is no table.jsonl in it".into()));
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

/// A path as seen from a folder; with slashes.
fn relative(from: &Path, to: &Path) -> String {
    let absolute = |p: &Path| {
        let p = std::path::absolute(p).unwrap_or_else(|_| p.into());
        let mut parts: Vec<String> = Vec::new();
        for c in p.components() {
            match c {
                Component::ParentDir => drop(parts.pop()),
                Component::CurDir => {}
                other => parts.push(other.as_os_str().to_string_lossy().into_owned()),
            }
        }
        parts
    };
    let (from, to) = (absolute(from), absolute(to));
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..".to_string(), from.len() - shared);
    up.chain(to[shared..].iter().cloned()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::write_tables;

    #[test]
    fn shares_become_one_table_and_a_missing_one_is_named() {
        let dir = std::env::temp_dir().join(format!("amcheck-merge-{}", std::process::id()));
        for name in ["a", "b", "all"] {
            fs::create_dir_all(dir.join(name)).unwrap();
        }
        let row = |part: &str, code: u8| {
            let folder = Some(format!("parts/{part}"));
            Row { code, folder, ..Row::refused(part, &Error::Interrupted) }
        };
        write_tables(&dir.join("a"), "-1-of-3", &[row("x", 0), row("z", 1)]).unwrap();
        write_tables(&dir.join("b"), "-3-of-3", &[row("y", 0), row("z", 4)]).unwrap();
        let merged = merge(&[dir.join("a"), dir.join("b")], &dir.join("all")).unwrap();
        let seen: Vec<(&str, u8)> = merged.rows.iter().map(|r| (r.part.as_str(), r.code)).collect();
        assert_eq!(seen, [("x", 0), ("y", 0), ("z", 4)]);
        assert_eq!(merged.rows[0].folder.as_deref(), Some("../a/parts/x"));
        assert_eq!(merged.missing, [(2, 3)]);
        fs::write(dir.join("a/table-1-of-3.jsonl"), "{}\n").unwrap();
        assert_eq!(merge(&[dir.join("a")], &dir).unwrap_err().place().as_deref(), Some("line 1"));
        assert_eq!(merge(&[dir.join("all")], &dir).unwrap_err().exit_code(), 4);
        fs::remove_dir_all(&dir).unwrap();
    }
}
