//! Files that are there whole or not at all.

use super::Temporary;
use crate::error::{Error, Result, printable};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes a file through a temporary one beside it, which takes its name at the end.
///
/// What was there before stays untouched until the new content is complete; on any error, a panic included,
/// the temporary file is removed. A symbolic link is followed; a device or pipe is written directly. Nothing is
/// forced to the disk: the promise is against errors and interruption, not against a loss of power.
///
/// # Errors
/// [`Error::CannotWrite`] for whatever the operating system or `content` says.
///
/// ```
/// let path = std::env::temp_dir().join("amcheck-doc-atomic.txt");
/// amcheck::io::write_atomically(&path, |w| w.write_all(b"whole"))?;
/// assert_eq!(std::fs::read(&path).unwrap(), b"whole");
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn write_atomically(path: &Path, content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    write(path, content)
        .map_err(|e| Error::CannotWrite { path: printable(&path.to_string_lossy()), reason: printable(&e.to_string()) })
}

/// What writes the content of a file.
pub type Content<'a> = Box<dyn FnOnce(&mut dyn Write) -> std::io::Result<()> + 'a>;

/// Writes several files as [`write_atomically`] does: none takes its name before all are complete.
///
/// # Errors
/// As there, naming the file; if the renaming itself fails, files before it in the list have their names already.
pub fn write_together(files: Vec<(&Path, Content)>) -> Result<()> {
    let named = |path: &Path, e: std::io::Error| Error::CannotWrite {
        path: printable(&path.to_string_lossy()),
        reason: printable(&e.to_string()),
    };
    let mut staged = Vec::new();
    for (path, content) in files {
        staged.extend(stage(path, content).map_err(|e| named(path, e))?.0);
    }
    Temporary::rename_all(&staged).map_err(|(path, e)| named(&path, e))
}

fn write(path: &Path, content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> std::io::Result<()> {
    stage(path, content)?.settle()
}

/// A complete file that waits for its name; a device or pipe has been written already.
struct Staged(Option<(Temporary, PathBuf)>);

impl Staged {
    fn settle(self) -> std::io::Result<()> {
        self.0.map_or(Ok(()), |(temporary, path)| temporary.rename_to(&path))
    }
}

fn stage(path: &Path, content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> std::io::Result<Staged> {
    let path = match std::fs::symlink_metadata(path) {
        Ok(link) if link.is_symlink() => std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()),
        _ => path.to_path_buf(),
    };
    if std::fs::metadata(&path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        let mut out = BufWriter::new(OpenOptions::new().write(true).open(&path)?);
        content(&mut out)?;
        out.flush()?;
        return Ok(Staged(None));
    }
    let (file, temporary) = beside(&path)?;
    let mut out = BufWriter::with_capacity(1 << 20, file);
    content(&mut out)?;
    out.flush()?;
    Ok(Staged(Some((temporary, path))))
}

/// A file that did not exist before, beside another.
fn beside(path: &Path) -> std::io::Result<(File, Temporary)> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().ok_or_else(|| std::io::Error::other("the path names no file"))?;
    loop {
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{}.part", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
        let place = path.with_file_name(hidden);
        if place.exists() {
            continue;
        }
        let temporary = Temporary::claim(place);
        match OpenOptions::new().write(true).create_new(true).open(temporary.path()) {
            Ok(file) => return Ok((file, temporary)),
            // Somebody else made it between the two looks: it is not ours to remove.
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => temporary.keep(),
            Err(e) => return Err(e),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_there_stays_until_the_new_is_whole() {
        let dir = std::env::temp_dir().join(format!("amcheck-atomic-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("report.json");
        write_atomically(&path, |w| w.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |w| {
            w.write_all(b"half")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().contains("disk full"));
        let panicked = std::panic::catch_unwind(|| write_atomically(&path, |_| panic!("on purpose")));
        assert!(panicked.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        write_atomically(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 1, "a temporary file was left");
        assert_eq!(write_atomically(&dir, |_| Ok(())).unwrap_err().exit_code(), 6);
        assert_eq!(write_atomically(&dir.join("no/such/x"), |_| Ok(())).unwrap_err().exit_code(), 6);
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn of_several_files_all_are_written_or_none() {
        let dir = std::env::temp_dir().join(format!("amcheck-together-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let (first, second) = (dir.join("a.npy"), dir.join("b.png"));
        let good = |text: &'static str| -> Content { Box::new(move |w| w.write_all(text.as_bytes())) };
        let bad: Content = Box::new(|_| Err(std::io::Error::other("disk full")));
        let failed = write_together(vec![(&first, good("a")), (&second, bad)]).unwrap_err();
        assert!(failed.to_string().contains("b.png") && failed.to_string().contains("disk full"));
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 0, "something was left");
        write_together(vec![(&first, good("a")), (&second, good("b"))]).unwrap();
        assert_eq!(std::fs::read(&second).unwrap(), b"b");
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 2);
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn links_are_followed_and_devices_written() {
        let dir = std::env::temp_dir().join(format!("amcheck-link-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let (target, link) = (dir.join("target"), dir.join("link"));
        std::fs::write(&target, b"old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_atomically(&link, |w| w.write_all(b"new")).unwrap();
        assert!(link.is_symlink() && std::fs::read(&target).unwrap() == b"new");
        write_atomically(Path::new("/dev/null"), |w| w.write_all(b"gone")).unwrap();
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
