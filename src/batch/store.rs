//! Results on disk, each there whole or not at all.

use super::row::Row;
use crate::error::{Error, Result, printable};
use crate::io::Temporary;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};

/// The line of a result, in its folder; a folder without it is no result.
const ROW: &str = "row.json";

/// What is kept of a result beside its files.
#[derive(Serialize, Deserialize)]
struct Kept {
    #[serde(flatten)]
    row: Row,
    /// The files that belong to it.
    files: Vec<String>,
}

/// The folder of a batch.
#[derive(Debug, Clone)]
pub struct Store {
    out: PathBuf,
}

impl Store {
    /// Makes the folder, and tries that something can be written there.
    ///
    /// # Errors
    /// [`Error::CannotWrite`] naming the folder.
    pub fn open(out: &Path) -> Result<Self> {
        let store = Store { out: out.into() };
        let parts = out.join("parts");
        let tried = fs::create_dir_all(&parts).and_then(|()| {
            let probe = Temporary::claim(parts.join(format!(".probe.{}.partial", std::process::id())));
            fs::write(probe.path(), b"")
        });
        tried.map_err(|e| cannot(out, &e))?;
        Ok(store)
    }

    /// The folder.
    pub fn out(&self) -> &Path {
        &self.out
    }

    /// The folder of a result below that of the batch: a readable word and the start of its key.
    pub fn folder(name: &str, key: &str) -> String {
        let file = name.rsplit('/').next().unwrap_or(name);
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let word: String = file.chars().take(48).map(plain).collect();
        let digits: String = key.chars().take(16).collect();
        format!("parts/{}-{digits}", word.trim_start_matches('.'))
    }

    /// The line of a result that an earlier run left whole, and whose files are all still there.
    pub fn find(&self, folder: &str) -> Option<Row> {
        let place = self.out.join(folder);
        let kept: Kept = serde_json::from_slice(&fs::read(place.join(ROW)).ok()?).ok()?;
        kept.files.iter().all(|name| place.join(name).is_file()).then_some(kept.row)
    }

    /// Keeps a result: its files and its line, in a folder that takes its name when everything is written.
    ///
    /// A result that is there already is replaced.
    ///
    /// # Errors
    /// [`Error::CannotWrite`]; then nothing is left.
    pub fn keep(&self, folder: &str, row: &Row, files: &[(String, Vec<u8>)]) -> Result<()> {
        let place = self.out.join(folder);
        self.sweep(&place);
        let hidden = hidden(&place, &format!("{}.partial", std::process::id()));
        let temporary = Temporary::claim(hidden);
        let write = || -> std::io::Result<()> {
            fs::create_dir_all(temporary.path())?;
            for (name, bytes) in files {
                fs::write(temporary.path().join(name), bytes)?;
            }
            let names = files.iter().map(|(name, _)| name.clone()).collect();
            let kept = Kept { row: row.clone(), files: names };
            fs::write(temporary.path().join(ROW), serde_json::to_vec_pretty(&kept)?)
        };
        write().map_err(|e| cannot(&place, &e))?;
        if place.exists() {
            // A folder cannot be replaced in one step; if the run ends between the two, the part is judged again.
            let old = Temporary::claim(self::hidden(&place, &format!("{}.old", std::process::id())));
            fs::rename(&place, old.path()).map_err(|e| cannot(&place, &e))?;
        }
        temporary.rename_to(&place).map_err(|e| cannot(&place, &e))
    }

    /// Removes a folder of a result, if it is there.
    pub fn forget(&self, folder: &str) {
        let place = self.out.join(folder);
        self.sweep(&place);
        // What cannot be removed is replaced, or says what was so before.
        let _ = fs::remove_dir_all(place);
    }

    /// Removes what runs that were killed left of this result.
    fn sweep(&self, place: &Path) {
        let Some(prefix) = hidden(place, "").file_name().map(|n| n.to_string_lossy().into_owned()) else { return };
        let Some(Ok(members)) = place.parent().map(fs::read_dir) else { return };
        for member in members.flatten() {
            if member.file_name().to_string_lossy().starts_with(&prefix) {
                let _ = fs::remove_dir_all(member.path());
            }
        }
    }
}

/// Whether a folder is a result of a batch, whole or in the making: as [`Store::folder`] names it.
pub(super) fn is_result(folder: &Path) -> bool {
    let name = folder.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let in_parts = folder.parent().and_then(Path::file_name).is_some_and(|n| n == "parts");
    let in_the_making = name.starts_with('.') && [".partial", ".old"].iter().any(|end| name.ends_with(end));
    let key = name.rsplit('-').next().unwrap_or_default();
    let keyed = key.len() == 16 && key.bytes().all(|b| b.is_ascii_hexdigit());
    in_parts && (in_the_making || keyed && folder.join(ROW).is_file())
}

/// The hidden neighbour of a folder with an ending.
fn hidden(place: &Path, ending: &str) -> PathBuf {
    let name = place.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    place.with_file_name(format!(".{name}.{ending}"))
}

pub(super) fn cannot(place: &Path, e: &std::io::Error) -> Error {
    Error::CannotWrite { path: printable(&place.to_string_lossy()), reason: printable(&e.to_string()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_there_whole_or_not_at_all() {
        let dir = std::env::temp_dir().join(format!("amcheck-store-{}", std::process::id()));
        let store = Store::open(&dir).unwrap();
        let folder = Store::folder("a/ we?ird\u{1b}.stl", "0123456789abcdef0123");
        assert_eq!(folder, "parts/_we_ird_.stl-0123456789abcdef");
        let row = Row::refused("a", &Error::Interrupted);
        // What a killed run left is no result.
        fs::create_dir_all(dir.join("parts/._we_ird_.stl-0123456789abcdef.77.partial")).unwrap();
        assert_eq!(store.find(&folder), None);
        store.keep(&folder, &row, &[("report.json".into(), b"{}".to_vec())]).unwrap();
        assert_eq!(store.find(&folder).as_ref(), Some(&row));
        fs::remove_file(dir.join(&folder).join("report.json")).unwrap();
        assert_eq!(store.find(&folder), None, "a file is gone");
        let other = Row { seconds: 2.0, ..row };
        store.keep(&folder, &other, &[]).unwrap();
        assert_eq!(store.find(&folder), Some(other));
        assert!(is_result(&dir.join(&folder)) && !is_result(&dir.join("parts")));
        assert_eq!(fs::read_dir(dir.join("parts")).unwrap().count(), 1, "something was left");
        let failed = store.keep(&folder, &Row::refused("a", &Error::Interrupted), &[("no/such".into(), vec![])]);
        assert_eq!(failed.unwrap_err().exit_code(), 6);
        assert!(store.find(&folder).is_some_and(|r| r.seconds == 2.0));
        assert_eq!(fs::read_dir(dir.join("parts")).unwrap().count(), 1, "something was left");
        fs::remove_dir_all(&dir).unwrap();
    }
}
