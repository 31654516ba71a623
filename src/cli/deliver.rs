//! Writing the files of a report: all of them or none, and never half of one.

use super::record::{self, Record, Said};
use crate::error::{Error, Result, printable};
use crate::io::Temporary;
use std::fs;
use std::path::{Path, PathBuf};

/// Files to be written, in order, with a word for the summary.
#[derive(Default)]
pub struct Files(Vec<(String, String, Vec<u8>)>);

impl Files {
    /// Adds a file.
    pub fn push(&mut self, what: &str, name: &str, bytes: Vec<u8>) {
        self.0.push((what.into(), name.into(), bytes));
    }

    /// Name of each.
    pub fn names(&self) -> Vec<String> {
        self.0.iter().map(|(_, name, _)| name.clone()).collect()
    }

    /// Name and content of each.
    pub fn into_contents(self) -> Vec<(String, Vec<u8>)> {
        self.0.into_iter().map(|(_, name, bytes)| (name, bytes)).collect()
    }
}

/// Refuses to write where something is read from: what a result is made of is never replaced by it.
///
/// # Errors
/// [`Error::CannotWrite`] naming the place.
pub fn spare(place: &Path, inputs: &[&Path]) -> Result<()> {
    match is_among(place, inputs) {
        false => Ok(()),
        true => Err(Error::CannotWrite {
            path: printable(&place.to_string_lossy()),
            reason: "the result is made from this very file; name another place with --out".into(),
        }),
    }
}

/// Whether one of these files stands at a place, whatever either is called.
pub fn is_among(place: &Path, files: &[&Path]) -> bool {
    let standing = place.canonicalize();
    standing.is_ok_and(|at| files.iter().any(|file| file.canonicalize().is_ok_and(|file| file == at)))
}

/// A folder that results can be written to, known before the work starts.
pub struct Delivery {
    folder: PathBuf,
    made: Vec<Temporary>,
    /// The part of which the files speak, and what they say of it.
    of: Option<(Said, PathBuf)>,
}

impl Delivery {
    /// Makes the folder and tries that a file can be made in it; a folder that was made for nothing goes again.
    ///
    /// # Errors
    /// [`Error::CannotWrite`] naming the folder.
    pub fn open(folder: &Path) -> Result<Self> {
        let made = Temporary::folders(folder).map_err(|e| cannot(folder, &e))?;
        let delivery = Delivery { folder: folder.into(), made, of: None };
        let probe = delivery.partial("probe");
        fs::write(probe.path(), b"").map_err(|e| cannot(folder, &e))?;
        Ok(delivery)
    }

    /// The same folder, for what is said of a part.
    pub fn saying(self, said: Said, part: &Path) -> Self {
        Delivery { of: Some((said, part.into())), ..self }
    }

    fn partial(&self, name: &str) -> Temporary {
        Temporary::claim(self.folder.join(format!(".{name}.{}.partial", std::process::id())))
    }

    /// Writes every file beside its place and then renames all; on failure none is left, and none of `inputs` is replaced.
    ///
    /// The folder's [`Record`] gains what is written. Returns that: word, place, length.
    ///
    /// # Errors
    /// [`Error::CannotWrite`] naming the file.
    pub fn deliver(mut self, files: Files, inputs: &[&Path]) -> Result<Vec<(String, String, u64)>> {
        files.0.iter().try_for_each(|(_, name, _)| spare(&self.folder.join(name), inputs))?;
        let mut record = Record::of(&self.folder);
        files.0.iter().for_each(|(_, name, bytes)| record.add(name, bytes));
        if let Some((said, part)) = &self.of {
            record.set_of(*said, part);
        }
        let record = record.text();
        // The list gets its name first: whatever ends the run then, nothing stands there that it does not know.
        let listed = std::iter::once((record::NAME, record.as_bytes()));
        let mut partials = Vec::new();
        for (name, bytes) in listed.chain(files.0.iter().map(|(_, name, bytes)| (name.as_str(), bytes.as_slice()))) {
            let (partial, place) = (self.partial(name), self.folder.join(name));
            fs::write(partial.path(), bytes).map_err(|e| cannot(&place, &e))?;
            partials.push((partial, place));
        }
        Temporary::rename_all(&partials).map_err(|(place, e)| cannot(&place, &e))?;
        self.made.drain(..).for_each(Temporary::keep);
        Ok(files
            .0
            .iter()
            .zip(partials.iter().skip(1))
            .map(|((what, _, bytes), (_, place))| (what.clone(), place.display().to_string(), bytes.len() as u64))
            .collect())
    }
}

pub(super) fn cannot(place: &Path, e: &std::io::Error) -> Error {
    Error::CannotWrite { path: place.display().to_string(), reason: e.to_string() }
}
