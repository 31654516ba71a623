//! How files that others read name a part.

use crate::batch::Entry;
use std::path::{Component, Path, PathBuf};

/// The names of a part.
pub struct Named {
    /// In tables and lists of tests: its place in the batch, or the name of its file.
    pub name: String,
    /// Where lists of alerts find it.
    pub file: PathBuf,
}

impl Named {
    /// Of a part that is judged alone.
    pub fn alone(part: &Path) -> Self {
        let name = part.file_name().unwrap_or(part.as_os_str()).to_string_lossy().into_owned();
        Named { name, file: from_here(part) }
    }

    /// Of a part of a batch: files of one name in several folders are told apart.
    pub fn in_batch(entry: &Entry) -> Self {
        Named { name: entry.name.clone(), file: from_here(&entry.path) }
    }
}

/// A path from the folder the tool runs in where it lies below it, else from its root.
fn from_here(path: &Path) -> PathBuf {
    let leads_down = path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if leads_down {
        return path.into();
    }
    // Folders are followed through links; the file itself keeps the name that it was given.
    let folder = path.parent().map(Path::canonicalize);
    let (Some(name), Some(Ok(folder))) = (path.file_name(), folder) else { return path.into() };
    let here = std::env::current_dir().and_then(|here| here.canonicalize());
    let below = here.ok().and_then(|here| folder.strip_prefix(here).ok().map(Path::to_path_buf));
    below.unwrap_or(folder).join(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_below_is_named_from_here_and_any_other_from_its_root() {
        let here = std::env::current_dir().unwrap().canonicalize().unwrap();
        let parts = here.join("fixtures/parts/block.stl");
        assert_eq!(from_here(&parts), Path::new("fixtures/parts/block.stl"));
        assert_eq!(from_here(Path::new("src/../fixtures/block.stl")), Path::new("fixtures/block.stl"));
        let above = here.parent().unwrap();
        assert_eq!(from_here(Path::new("../part.stl")), above.join("part.stl"));
        for as_given in ["part.stl", "./a/part.stl", "-", "none/../part.stl"] {
            assert_eq!(from_here(Path::new(as_given)), Path::new(as_given));
        }
        assert_eq!(Named::alone(&parts).name, "block.stl");
    }
}
