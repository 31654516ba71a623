//! The file that a made shape goes to.

use super::deliver::Delivery;
use super::words::one_of;
use crate::error::{Error, Result, printable};
use crate::geometry::TriangleMesh;
use crate::io::glb::{self, Scene};
use crate::io::{obj, ply, stl, threemf, write_atomically};
use std::path::{Path, PathBuf};

/// Suffixes that a mesh is written by.
const SUFFIXES: &[&str] = &["stl", "glb", "obj", "ply", "3mf"];

/// A place for a mesh, known to take it before the work starts.
pub struct Destination {
    path: PathBuf,
    suffix: &'static str,
    /// Takes a folder that was made for nothing away again.
    _folder: Delivery,
}

impl Destination {
    /// Looks at the suffix and tries that a file can be made there.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a suffix that is not one of five; [`Error::CannotWrite`] naming the place.
    pub fn open(path: PathBuf) -> Result<Self> {
        let suffix = path.extension().map_or_else(String::new, |s| s.to_string_lossy().to_lowercase());
        let known = one_of("suffix for --out", &[suffix], SUFFIXES)?;
        let suffix = known.first().copied().unwrap_or("stl");
        if path.is_dir() {
            let shown = printable(&path.to_string_lossy());
            return Err(Error::CannotWrite { path: shown, reason: "it is a folder".into() });
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Ok(Destination { _folder: Delivery::open(folder)?, suffix, path })
    }

    /// Writes the mesh, whole or not at all, and returns where.
    ///
    /// # Errors
    /// As [`write_atomically`].
    pub fn write(self, mesh: &TriangleMesh) -> Result<PathBuf> {
        write_atomically(&self.path, |out| match self.suffix {
            "glb" => glb::write(&Scene { mesh, colours: None, attributes: &[] }, out),
            "obj" => obj::write(mesh, out),
            "ply" => ply::write(mesh, out),
            "3mf" => threemf::write(mesh, out),
            _ => stl::write(mesh, out),
        })?;
        Ok(self.path.clone())
    }
}
