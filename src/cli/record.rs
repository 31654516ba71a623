//! The list, in a folder of results, of what runs wrote there: nothing else makes way for what a later run writes.

use super::leftover::{of_judging, of_orienting, of_repairing};
use crate::error::printable;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The list's own name; a line of it is a SHA-256 and a name, as `sha256sum` writes and checks them.
pub const NAME: &str = ".amcheck-files";

/// What a run says of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Said {
    /// Whether it can be printed.
    Report,
    /// How it may stand.
    Orientations,
}

impl Said {
    const ALL: [Said; 2] = [Said::Report, Said::Orientations];

    /// What the line begins with that says of which part that is; `sha256sum` passes such lines over.
    fn line(self) -> &'static str {
        match self {
            Said::Report => "# of ",
            Said::Orientations => "# oriented ",
        }
    }

    /// Its name, and what points to it.
    fn words(self) -> [&'static str; 2] {
        match self {
            Said::Report => ["report", "this one"],
            Said::Orientations => ["orientations", "these"],
        }
    }

    /// A note that a folder held, or goes on holding, this of another part, where something is written of one.
    pub fn of_another_beside(self, written: Said, folder: &Path) -> String {
        let (folder, [what, _], [now, these]) = (printable(&folder.to_string_lossy()), self.words(), written.words());
        match self == written {
            true => format!("{folder} held the {what} of another part, which {these} replaced; --out DIR keeps both"),
            false => format!(
                "{folder} holds the {what} of another part beside the {now} of this one; --out DIR keeps them apart"
            ),
        }
    }

    /// Whether a file of such a name belongs to it.
    fn names(self, name: &str) -> bool {
        match self {
            Said::Report => of_judging(name),
            Said::Orientations => of_orienting(name),
        }
    }
}

/// Files that runs are known to have written to a folder, each with the digest of what was written, and of which part they speak.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Record {
    files: BTreeSet<(String, String)>,
    /// The digest of where that part lies: a report does not tell where that is.
    of: BTreeMap<Said, String>,
}

impl Record {
    /// The list of a folder; empty where there is none.
    pub fn of(folder: &Path) -> Self {
        let text = fs::read_to_string(folder.join(NAME)).unwrap_or_default();
        // A list may come from anywhere: what no run would write is not taken from it.
        let entry = |line: &str| line.split_once("  ").map(|(digest, name)| (name.to_string(), digest.to_string()));
        let files = text.lines().filter_map(entry).filter(|(name, _)| is_listed(name)).collect();
        let place =
            |said: Said| text.lines().find_map(|line| line.strip_prefix(said.line())).map(|of| (said, of.into()));
        Record { files, of: Said::ALL.into_iter().filter_map(place).collect() }
    }

    /// What of the folder still stands there and is of another file than this part, wherever that lies; unknown of standard input.
    pub fn of_another(&self, folder: &Path, part: &Path) -> Vec<Said> {
        let Some(place) = place_of(part) else { return Vec::new() };
        let others: Vec<Said> = self.of.iter().filter(|(_, of)| **of != place).map(|(said, _)| *said).collect();
        if others.is_empty() {
            return others;
        }
        let standing = self.standing(folder);
        others.into_iter().filter(|said| standing.names().any(|name| said.names(name))).collect()
    }

    /// The notes that a run owes which writes something of a part to the folder.
    pub fn notes(&self, folder: &Path, part: &Path, written: Said) -> Vec<String> {
        self.of_another(folder, part).into_iter().map(|said| said.of_another_beside(written, folder)).collect()
    }

    /// Says of which part the folder's report, or its orientations, are.
    pub fn set_of(&mut self, said: Said, part: &Path) {
        self.of.remove(&said);
        self.of.extend(place_of(part).map(|place| (said, place)));
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
        let of = self.of.iter().map(|(said, of)| format!("{}{of}\n", said.line()));
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
        assert!(record.of_another(&dir, &dir.join("mesh.png")).is_empty(), "nobody knows of what it is");
        record.set_of(Said::Report, &dir.join("notes.txt"));
        fs::write(dir.join(NAME), record.text()).unwrap();
        assert_eq!(Record::of(&dir), record);
        let other = |record: &Record, name: &str| record.of_another(&dir, &dir.join(name));
        assert_eq!(other(&record, "mesh.png"), [Said::Report]);
        assert!(["notes.txt", "./notes.txt", "gone.stl"].iter().all(|name| other(&record, name).is_empty()));
        record.set_of(Said::Orientations, &dir.join("mesh.png"));
        assert_eq!(other(&record, "mesh.png"), [Said::Report]);
        assert!(other(&record, "notes.txt").is_empty(), "no orientations stand there");
        record.add("orientations.json", b"ours");
        fs::write(dir.join("orientations.json"), b"ours").unwrap();
        fs::write(dir.join(NAME), record.text()).unwrap();
        assert_eq!(Record::of(&dir), record);
        assert_eq!(other(&record, "notes.txt"), [Said::Orientations]);
        fs::remove_file(dir.join("report.md")).unwrap();
        assert!(other(&record, "mesh.png").is_empty(), "no report stands there");
        fs::remove_dir_all(&dir).unwrap();
    }
}
