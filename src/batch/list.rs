//! Which parts a batch is about.

use super::store::is_result;
use crate::error::{Error, Result, escaped, printable};
use crate::io::plain_text;
use std::ffi::OsStr;
use std::fs;
use std::io::Read;
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

/// Suffixes by which a folder's parts are known; what a list names is taken whatever its suffix.
const SUFFIXES: [&str; 4] = ["stl", "obj", "ply", "3mf"];

/// A list longer than this is refused.
const MOST_LIST_BYTES: u64 = 1 << 30;

/// A part of a batch.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// Its name in the table: the path below the folder it was found in, or as it was listed.
    pub name: String,
    /// Where it is.
    pub path: PathBuf,
}

/// The parts that folders, files and lists name, sorted by name, each once.
///
/// A folder stands for every STL, OBJ, PLY and 3MF file below it but what batches left as results; links to folders are not followed. A file with such a suffix
/// is a part. Any other file, and `-` for standard input, is a list in UTF-8 or UTF-16: one path on each line, empty lines and those that start with
/// `#` left out. What cannot be looked into becomes an entry, so that it ends as a line of the table and not in silence.
///
/// # Errors
/// [`Error::CannotRead`] for an operand that cannot be read; [`Error::NoGeometry`] if no part is found.
pub fn entries(operands: &[PathBuf]) -> Result<Vec<Entry>> {
    let mut found = Vec::new();
    for operand in operands {
        if operand.as_os_str() != "-" && operand.is_dir() {
            let prefix = if operands.len() == 1 { None } else { Some(operand.as_path()) };
            below(operand, operand, prefix, &mut found);
        } else if has_suffix(operand) {
            found.push(Entry { name: name_of(operand), path: operand.clone() });
        } else {
            listed(operand, &mut found)?;
        }
    }
    if found.is_empty() {
        let named: Vec<String> = operands.iter().map(|o| shown(o)).collect();
        return Err(Error::NoGeometry {
            problem: format!("{} names no part", named.join(", ")),
            remedy: "name a folder with STL, OBJ, PLY or 3MF files, or a file with one path on each line".into(),
        });
    }
    found.sort();
    found.dedup();
    Ok(found)
}

/// Adds the parts below a folder; a folder that cannot be opened is added itself.
fn below(folder: &Path, top: &Path, prefix: Option<&Path>, found: &mut Vec<Entry>) {
    let name = |path: &Path| {
        let inner = path.strip_prefix(top).unwrap_or(path);
        name_of(&prefix.map_or(inner.to_path_buf(), |p| p.join(inner)))
    };
    let Ok(members) = fs::read_dir(folder) else {
        found.push(Entry { name: name(folder), path: folder.into() });
        return;
    };
    for member in members.flatten() {
        let path = member.path();
        if member.file_type().is_ok_and(|t| t.is_dir()) {
            if !is_result(&path) {
                below(&path, top, prefix, found);
            }
        } else if has_suffix(&path) && !path.is_dir() {
            found.push(Entry { name: name(&path), path });
        }
    }
}

/// Adds the parts of a list.
fn listed(list: &Path, found: &mut Vec<Entry>) -> Result<()> {
    let mut bytes = Vec::new();
    let read = if list.as_os_str() == "-" {
        std::io::stdin().lock().take(MOST_LIST_BYTES).read_to_end(&mut bytes)
    } else {
        fs::File::open(list).and_then(|f| f.take(MOST_LIST_BYTES).read_to_end(&mut bytes))
    };
    read.map_err(|e| Error::CannotRead {
        path: shown(list),
        reason: printable(&e.to_string()),
        remedy: "name a folder, parts, or a file with one path on each line".into(),
    })?;
    for line in plain_text(&bytes).split(|b| *b == b'\n') {
        let line = line.trim_ascii();
        if !line.is_empty() && !line.starts_with(b"#") {
            let path = path_of(line);
            found.push(Entry { name: name_of(&path), path });
        }
    }
    Ok(())
}

/// A path as its bytes say, UTF-8 or not.
#[cfg(unix)]
fn path_of(bytes: &[u8]) -> PathBuf {
    use std::os::unix::ffi::OsStrExt;
    OsStr::from_bytes(bytes).into()
}

/// A path from UTF-8.
#[cfg(not(unix))]
fn path_of(bytes: &[u8]) -> PathBuf {
    OsStr::new(String::from_utf8_lossy(bytes).as_ref()).into()
}

fn has_suffix(path: &Path) -> bool {
    path.extension().is_some_and(|s| SUFFIXES.iter().any(|known| s.eq_ignore_ascii_case(known)))
}

/// The name of a part at a path: with slashes, whatever parts folders on this system.
fn name_of(path: &Path) -> String {
    let name = path.to_string_lossy();
    if MAIN_SEPARATOR == '/' { name.into_owned() } else { name.replace(MAIN_SEPARATOR, "/") }
}

/// The whole path with its control characters escaped; unlike a message it is not cut.
fn shown(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_files_and_lists_are_told_apart() {
        let dir = std::env::temp_dir().join(format!("amcheck-list-{}", std::process::id()));
        fs::create_dir_all(dir.join("a/b")).unwrap();
        for name in ["a/b/two.STL", "a/one.3mf", "a/notes.md"] {
            fs::write(dir.join(name), b"x").unwrap();
        }
        fs::write(dir.join("list.txt"), "# parts\n\n one.bin \nmissing.stl\r\none.bin\n").unwrap();
        let names = |operands: &[&str]| -> Vec<String> {
            let operands: Vec<PathBuf> = operands.iter().map(|o| dir.join(o)).collect();
            entries(&operands).unwrap().into_iter().map(|e| e.name).collect()
        };
        assert_eq!(names(&["a"]), ["b/two.STL", "one.3mf"]);
        assert_eq!(names(&["list.txt"]), ["missing.stl", "one.bin"]);
        fs::write(dir.join("marked.txt"), "\u{feff}one.bin\r\ntwo.bin").unwrap();
        let wide: Vec<u8> = "\u{feff}one.bin\r\ntwo.bin".encode_utf16().flat_map(u16::to_le_bytes).collect();
        fs::write(dir.join("wide.txt"), wide).unwrap();
        assert_eq!([names(&["marked.txt"]), names(&["wide.txt"])], [["one.bin", "two.bin"]; 2]);
        assert_eq!(names(&["a", "a/one.3mf"]).len(), 2, "the same part twice is one entry");
        // What a batch left there is no part of the next one.
        let left = dir.join("a/out/parts/one.3mf-0123456789abcdef");
        fs::create_dir_all(&left).unwrap();
        ["repaired.3mf", "row.json"].iter().for_each(|name| fs::write(left.join(name), b"x").unwrap());
        assert_eq!(names(&["a"]), ["b/two.STL", "one.3mf"]);
        fs::create_dir(dir.join("bare")).unwrap();
        assert_eq!(entries(&[dir.join("bare")]).unwrap_err().exit_code(), 4);
        assert_eq!(entries(&[dir.join("none.txt")]).unwrap_err().exit_code(), 4);
        fs::remove_dir_all(&dir).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn names_are_kept_as_they_are() {
        let dir = std::env::temp_dir().join(format!("amcheck-list-odd-{}", std::process::id()));
        fs::create_dir_all(dir.join("a")).unwrap();
        for name in ["a\\b.stl", "a/b.stl", "new\nline.stl"] {
            fs::write(dir.join(name), b"x").unwrap();
        }
        let names: Vec<String> = entries(std::slice::from_ref(&dir)).unwrap().into_iter().map(|e| e.name).collect();
        assert_eq!(names, ["a/b.stl", "a\\b.stl", "new\nline.stl"]);
        fs::remove_dir_all(&dir).unwrap();
    }
}
