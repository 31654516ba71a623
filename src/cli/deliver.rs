//! Writing the files of a report: all of them or none, and never half of one.

use crate::error::{Error, Result};
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
}

/// A folder that results can be written to, known before the work starts.
pub struct Delivery {
    folder: PathBuf,
    made: Option<PathBuf>,
}

impl Delivery {
    /// Makes the folder and tries that a file can be made in it.
    ///
    /// # Errors
    /// [`Error::CannotWrite`] naming the folder.
    pub fn open(folder: &Path) -> Result<Self> {
        let made =
            folder.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).last().map(Path::to_path_buf);
        let refused =
            |e: std::io::Error| Error::CannotWrite { path: folder.display().to_string(), reason: e.to_string() };
        fs::create_dir_all(folder).map_err(refused)?;
        let delivery = Delivery { folder: folder.into(), made };
        let probe = delivery.partial("probe");
        fs::write(&probe, b"").map_err(refused)?;
        let _ = fs::remove_file(&probe);
        Ok(delivery)
    }

    fn partial(&self, name: &str) -> PathBuf {
        self.folder.join(format!(".{name}.{}.partial", std::process::id()))
    }

    /// Writes every file beside its place and then renames all; on failure none is left.
    ///
    /// Returns what was written: word, place, length.
    ///
    /// # Errors
    /// [`Error::CannotWrite`] naming the file.
    pub fn deliver(mut self, files: Files) -> Result<Vec<(String, String, u64)>> {
        let partials: Vec<(PathBuf, PathBuf)> =
            files.0.iter().map(|(_, name, _)| (self.partial(name), self.folder.join(name))).collect();
        let written = || -> Result<()> {
            for ((_, _, bytes), (partial, place)) in files.0.iter().zip(&partials) {
                fs::write(partial, bytes).map_err(|e| cannot(place, &e))?;
            }
            for (partial, place) in &partials {
                fs::rename(partial, place).map_err(|e| cannot(place, &e))?;
            }
            Ok(())
        };
        if let Err(e) = written() {
            for (partial, _) in &partials {
                let _ = fs::remove_file(partial);
            }
            return Err(e);
        }
        self.made = None;
        Ok(files
            .0
            .iter()
            .zip(&partials)
            .filter(|((what, _, _), _)| what == "report" || what == "data")
            .map(|((what, _, bytes), (_, place))| (what.clone(), place.display().to_string(), bytes.len() as u64))
            .collect())
    }
}

impl Drop for Delivery {
    /// A folder that was made for nothing goes again.
    fn drop(&mut self) {
        if let Some(top) = &self.made {
            let mut folder = self.folder.clone();
            while folder.starts_with(top) && fs::remove_dir(&folder).is_ok() && folder.pop() {}
        }
    }
}

fn cannot(place: &Path, e: &std::io::Error) -> Error {
    Error::CannotWrite { path: place.display().to_string(), reason: e.to_string() }
}
