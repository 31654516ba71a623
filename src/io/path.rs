//! Files and standard input, read whole and within a limit.

use super::{Loaded, Salvage, read};
use crate::error::{Error, Result, nearest, printable};
use std::fs::{File, Metadata};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// The bytes of a file, or of standard input for `-`, and the mesh they hold.
///
/// # Errors
/// [`Error::CannotRead`] for a file that is missing (with the nearest name beside it), a directory, not
/// permitted, or changing while it is read; [`Error::TooLarge`] beyond `limit_bytes`, told from the size
/// before reading, and for pipes and devices, which have none; otherwise as [`read()`].
///
/// # Cost
/// One reading of the file into memory.
pub fn read_path(path: &Path, limit_bytes: u64, salvage: Salvage) -> Result<(Vec<u8>, Loaded)> {
    let bytes = content_of(path, limit_bytes)?;
    let loaded = read(&path.to_string_lossy(), &bytes, salvage)?;
    Ok((bytes, loaded))
}

/// The bytes of a file, or of standard input for `-`.
///
/// # Errors
/// As [`read_path`], but for those of what the bytes hold.
pub fn content_of(path: &Path, limit_bytes: u64) -> Result<Vec<u8>> {
    if path != Path::new("-") {
        return bytes_of(path, limit_bytes);
    }
    let mut bytes = Vec::new();
    let mut input = std::io::stdin().lock().take(limit_bytes.saturating_add(1));
    input.read_to_end(&mut bytes).map_err(|e| refused(path, &e))?;
    within("standard input", bytes.len() as u64, limit_bytes)?;
    Ok(bytes)
}

/// The bytes of a regular file that stays as it is while it is read.
pub(crate) fn bytes_of(path: &Path, limit_bytes: u64) -> Result<Vec<u8>> {
    let before = std::fs::metadata(path).map_err(|e| refused(path, &e))?;
    if before.is_dir() {
        return Err(Error::CannotRead {
            path: shown(path),
            reason: "it is a directory".into(),
            remedy: "name a file in it, or use `amcheck batch` for the whole directory".into(),
        });
    }
    if !before.is_file() {
        // Opening a pipe waits for its writer, perhaps for ever, so the kind is looked at first.
        return Err(Error::CannotRead {
            path: shown(path),
            reason: "it is a pipe or a device, which may never end".into(),
            remedy: "hand its content over as standard input, with - for its name".into(),
        });
    }
    within(&shown(path), before.len(), limit_bytes)?;
    let mut file = File::open(path).map_err(|e| refused(path, &e))?;
    let mut bytes = Vec::new();
    let room = usize::try_from(before.len()).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(room).map_err(|_| too_large(&shown(path), before.len(), limit_bytes))?;
    // One byte more than there should be shows a file that grows, without following it for ever.
    file.by_ref().take(before.len().saturating_add(1)).read_to_end(&mut bytes).map_err(|e| refused(path, &e))?;
    let after = file.metadata().map_err(|e| refused(path, &e))?;
    if bytes.len() as u64 != before.len() || changed(&before, &after) {
        return Err(Error::CannotRead {
            path: shown(path),
            reason: "it changed while it was read".into(),
            remedy: "wait until the export has ended and try again".into(),
        });
    }
    Ok(bytes)
}

/// Whether a file was written between two looks at it.
fn changed(before: &Metadata, after: &Metadata) -> bool {
    before.len() != after.len() || before.modified().ok() != after.modified().ok()
}

fn within(what: &str, bytes: u64, limit: u64) -> Result<()> {
    if bytes <= limit { Ok(()) } else { Err(too_large(what, bytes, limit)) }
}

fn too_large(what: &str, bytes: u64, limit: u64) -> Error {
    Error::TooLarge {
        what: what.into(),
        need_bytes: u128::from(bytes),
        allowed_bytes: u128::from(limit),
        remedy: "allow more with --memory, or export the part with fewer triangles".into(),
    }
}

/// The error of an operating system that does not hand the file over.
fn refused(path: &Path, reason: &std::io::Error) -> Error {
    let (reason, remedy) = match reason.kind() {
        ErrorKind::NotFound => match path.read_link() {
            Ok(target) => (
                format!("it is a link that leads to nothing: {}", shown(&target)),
                "mend the link, or name the file itself".into(),
            ),
            Err(_) => ("there is no such file".into(), near_name(path)),
        },
        ErrorKind::PermissionDenied => ("reading it is not permitted".into(), "change its permissions".into()),
        _ => (printable(&reason.to_string()), "check the path and the disk".into()),
    };
    Error::CannotRead { path: shown(path), reason, remedy }
}

/// The file of the same directory whose name is nearest, as a question.
fn near_name(path: &Path) -> String {
    let directory = match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
        None => Path::new("."),
    };
    let wanted = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let Ok(entries) = std::fs::read_dir(directory) else {
        return format!("there is no directory {} either", shown(directory));
    };
    // Sorted, because the order of a directory differs between file systems.
    let mut names: Vec<String> =
        entries.take(10_000).flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    match nearest(&wanted, names.iter().map(String::as_str)) {
        Some(name) => format!("did you mean `{}`?", shown(&path.with_file_name(name))),
        None => "check the path".into(),
    }
}

fn shown(path: &Path) -> String {
    printable(&path.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    const STL: &[u8] =
        b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid";

    #[test]
    fn files_are_read_within_their_limit() {
        let dir = std::env::temp_dir().join(format!("amcheck-path-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let part = dir.join("my part #1.stl");
        std::fs::write(&part, STL).unwrap();
        std::fs::write(dir.join("empty.stl"), b"").unwrap();
        let (bytes, loaded) = read_path(&part, 1 << 20, Salvage::Refuse).unwrap();
        assert_eq!((bytes.as_slice(), loaded.mesh.triangles.len()), (STL, 1));

        let fails = |name: &str, limit| read_path(&dir.join(name), limit, Salvage::Refuse).unwrap_err();
        assert_eq!(fails("my part #1.stl", 10).exit_code(), 5);
        assert!(fails("my prt #1.stl", 1 << 20).remedy().contains("my part #1.stl"));
        assert!(fails("", 1 << 20).to_string().contains("directory"));
        assert!(fails("empty.stl", 1 << 20).to_string().contains("0 bytes"));
        assert!(fails("none/x.stl", 1 << 20).remedy().contains("directory"));
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn a_link_that_leads_to_nothing_is_told_as_that() {
        let link = std::env::temp_dir().join(format!("amcheck-link-{}.stl", std::process::id()));
        std::os::unix::fs::symlink("/nowhere/part.stl", &link).unwrap();
        let error = read_path(&link, 1 << 20, Salvage::Refuse).unwrap_err();
        std::fs::remove_file(&link).unwrap();
        let (said, remedy) = (error.to_string(), error.remedy());
        assert!(
            said.contains("leads to nothing: /nowhere/part.stl") && remedy.contains("mend the link"),
            "{said} {remedy}"
        );
    }

    #[test]
    #[cfg(unix)]
    fn devices_are_refused_without_reading_them() {
        assert_eq!(read_path(Path::new("/dev/zero"), 1 << 20, Salvage::Refuse).unwrap_err().exit_code(), 4);
    }
}
