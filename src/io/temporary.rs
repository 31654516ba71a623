//! What must not be left behind: files and folders in the making.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How a place in the making goes again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// With everything in it.
    Whole,
    /// A folder, if nothing is in it.
    Empty,
}

/// The places in the making of this process; a signal reaches the process, not the call that makes them.
static LIVE: Mutex<BTreeMap<PathBuf, Kind>> = Mutex::new(BTreeMap::new());

fn live() -> MutexGuard<'static, BTreeMap<PathBuf, Kind>> {
    // A set of names is whole whatever a thread was doing when it broke down.
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or folder in the making, removed when dropped unless it got its name.
#[derive(Debug)]
pub struct Temporary {
    path: PathBuf,
}

impl Temporary {
    /// Claims a place before anything is made there.
    pub fn claim(path: PathBuf) -> Self {
        live().insert(path.clone(), Kind::Whole);
        Temporary { path }
    }

    /// Makes a folder and those above it that are missing; each that was made goes again unless something is put into it or it is
    /// [kept](Temporary::keep).
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn folders(folder: &Path) -> std::io::Result<Vec<Self>> {
        let mut missing: Vec<PathBuf> = folder
            .ancestors()
            .take_while(|p| !p.as_os_str().is_empty() && !p.exists())
            .map(Path::to_path_buf)
            .collect();
        // The innermost is dropped first, so that the outer ones are empty then.
        let claimed = missing.drain(..).map(|path| {
            live().insert(path.clone(), Kind::Empty);
            Temporary { path }
        });
        let claimed = claimed.collect();
        std::fs::create_dir_all(folder)?;
        Ok(claimed)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives it its name.
    ///
    /// # Errors
    /// Those of the operating system; then it is removed.
    pub fn rename_to(self, place: &Path) -> std::io::Result<()> {
        Temporary::rename_all(&[(self, place.to_path_buf())]).map_err(|(_, e)| e)
    }

    /// Gives several their names without being interrupted by [`abandon_temporaries`].
    ///
    /// # Errors
    /// The first place that cannot be had, and what the operating system says.
    pub fn rename_all(all: &[(Temporary, PathBuf)]) -> Result<(), (PathBuf, std::io::Error)> {
        let mut live = live();
        for (temporary, place) in all {
            std::fs::rename(&temporary.path, place).map_err(|e| (place.clone(), e))?;
            live.remove(&temporary.path);
        }
        Ok(())
    }

    /// Leaves it where it is.
    pub fn keep(self) {
        live().remove(&self.path);
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let kind = live().remove(&self.path);
        if let Some(kind) = kind {
            remove(&self.path, kind);
        }
    }
}

/// Removes everything in the making and lets nothing else begin: the last call before the process ends on a signal.
///
/// Whoever makes or names a file afterwards waits for ever.
pub fn abandon_temporaries() {
    let live = live();
    for kind in [Kind::Whole, Kind::Empty] {
        // Inner folders stand behind the outer ones.
        live.iter().rev().filter(|(_, k)| **k == kind).for_each(|(path, k)| remove(path, *k));
    }
    std::mem::forget(live);
}

/// Nothing can be done about a failure here, and after success there is nothing of that name.
fn remove(path: &Path, kind: Kind) {
    let _ = match kind {
        Kind::Empty => std::fs::remove_dir(path),
        Kind::Whole if path.is_dir() => std::fs::remove_dir_all(path),
        Kind::Whole => std::fs::remove_file(path),
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn what_got_no_name_goes_again() {
        let dir = std::env::temp_dir().join(format!("amcheck-temporary-{}", std::process::id()));
        let folders = Temporary::folders(&dir.join("a/b")).unwrap();
        assert_eq!(folders.len(), 3);
        drop(folders);
        assert!(!dir.exists());
        let folders = Temporary::folders(&dir.join("a/b")).unwrap();
        let tree = Temporary::claim(dir.join("a/b/tree"));
        fs::create_dir_all(tree.path().join("in")).unwrap();
        let file = Temporary::claim(dir.join("a/.file"));
        fs::write(file.path(), b"x").unwrap();
        file.rename_to(&dir.join("a/file")).unwrap();
        drop(tree);
        drop(folders);
        assert!(dir.join("a/file").exists() && !dir.join("a/b").exists());
        let lost = Temporary::claim(dir.join("a/.lost"));
        fs::write(lost.path(), b"x").unwrap();
        assert!(lost.rename_to(&dir.join("none/lost")).is_err());
        assert_eq!(fs::read_dir(dir.join("a")).unwrap().count(), 1);
        fs::remove_dir_all(&dir).unwrap();
    }
}
