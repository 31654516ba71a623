//! The list, in a folder of results, of what runs wrote there: nothing else makes way for what a later run writes.

use super::leftover::{of_judging, of_orienting, of_repairing};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The list's own name; a line of it is a SHA-256 and a name, as `sha256sum` writes and checks them.
pub const NAME: &str = ".amcheck-files";

/// What the line begins with that says which part was judged there; `sha256sum` passes such lines over.
const OF: &str = "# of ";

/// Files that runs are known to have written to a folder, each with the digest of what was written, and the part that was judged last.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Record {
    files: BTreeSet<(String, String)>,
    /// The digest of where that part lies: a report does not tell where that is.
    of: Option<String>,
}

impl Record {
    /// The list of a folder; empty where there is none.
    pub fn of(folder: &Path) -> Self {
        let text = fs::read_to_string(folder.join(NAME)).unwrap_or_default();
        // A list may come from anywhere: what no run would write is not taken from it.
        let entry = |line: &str| line.split_once("  ").map(|(digest, name)| (name.to_string(), digest.to_string()));
        let files = text.lines().filter_map(entry).filter(|(name, _)| is_listed(name)).collect();
        Record { files, of: text.lines().find_map(|line| line.strip_prefix(OF)).map(String::from) }
    }

    /// Whether a report that still stands in the folder is of another file than this part, wherever that lies; unknown of standard input.
    pub fn is_of_another(&self, folder: &Path, part: &Path) -> bool {
        let other = matches!((&self.of, place_of(part)), (Some(was), Some(is)) if *was != is);
        other && self.standing(folder).names().any(of_judging)
    }

    /// Says which part the folder's report is of.
    pub fn set_of(&mut self, part: &Path) {
        self.of = place_of(part);
    }

    /// Adds a file, if it is of a kind that may make way later.
    pub fn add(&mut self, name: &str, bytes: &[u8]) {
        if is_listed(name) {
            self.files.insert((name.into(), hex(Sha256::new_with_prefix(bytes))));
        }
    }

    /// The files that still stand in the folder as they were written.
    pub fn standing(&self, folder: &Path) -> Self {
        let stands = |(name, digest): &&(String, String)| digest_of(&folder.join(name)).as_ref() == Some(digest);
        Record { files: self.files.iter().filter(stands).cloned().collect(), of: self.of.clone() }
    }

    /// The names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|(name, _)| name.as_str())
    }

    /// The same list without a name.
    pub fn without(mut self, names: &[String]) -> Self {
        self.files.retain(|(name, _)| !names.contains(name));
        self
    }

    /// The list as text.
    pub fn text(&self) -> String {
        let of = self.of.iter().map(|of| format!("{OF}{of}\n"));
        of.chain(self.files.iter().map(|(name, digest)| format!("{digest}  {name}\n"))).collect()
    }
}

fn is_listed(name: &str) -> bool {
    of_repairing(name) || of_orienting(name)
}

/// The digest of where a part lies, whatever way leads there; none of standard input.
fn place_of(part: &Path) -> Option<String> {
    let place = part.canonicalize().ok().filter(|_| part != Path::new("-"))?;
    Some(hex(Sha256::new_with_prefix(place.as_os_str().as_encoded_bytes())))
}

/// The digest of a file; none of what is no file or cannot be read.
fn digest_of(path: &Path) -> Option<String> {
    fs::symlink_metadata(path).ok().filter(fs::Metadata::is_file)?;
    let mut hash = Sha256::new();
    std::io::copy(&mut fs::File::open(path).ok()?, &mut hash).ok()?;
    Some(hex(hash))
}

fn hex(hash: Sha256) -> String {
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_names_only_what_stands_as_it_was_written_and_could_have_been() {
        let dir = std::env::temp_dir().join(format!("amcheck-record-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let mut record = Record::default();
        for name in ["report.md", "best.stl", "timings.json", "../report.md", "notes.txt", "mesh.png"] {
            record.add(name, b"ours");
        }
        assert!(record.names().eq(["best.stl", "mesh.png", "report.md"]));
        fs::write(dir.join(NAME), format!("{}no line\n00  ../report.md\n00  notes.txt\n", record.text())).unwrap();
        assert_eq!(Record::of(&dir), record);
        fs::write(dir.join("report.md"), b"ours").unwrap();
        fs::write(dir.join("mesh.png"), b"mine").unwrap();
        fs::create_dir(dir.join("best.stl")).unwrap();
        assert!(record.standing(&dir).names().eq(["report.md"]));
        fs::write(dir.join("notes.txt"), b"mine").unwrap();
        assert!(!record.is_of_another(&dir, &dir.join("mesh.png")), "nobody knows of what it is");
        record.set_of(&dir.join("notes.txt"));
        fs::write(dir.join(NAME), record.text()).unwrap();
        assert_eq!(Record::of(&dir), record);
        let other = |name: &str| record.is_of_another(&dir, &dir.join(name));
        assert!(other("mesh.png") && !other("notes.txt") && !other("./notes.txt") && !other("gone.stl"));
        fs::remove_file(dir.join("report.md")).unwrap();
        assert!(!record.is_of_another(&dir, &dir.join("mesh.png")), "no report stands there");
        fs::remove_dir_all(&dir).unwrap();
    }
}
