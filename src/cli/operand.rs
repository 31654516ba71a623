//! What an operation is done to: a mesh file or a built-in element.

use super::complaint::{Answer, Complaint};
use crate::error::{Error, Result};
use crate::geometry::{Health, Primitive, TriangleMesh};
use crate::io::Loaded;
use crate::memory::Allowance;
use crate::notice::Notice;
use crate::operate::Element;
use crate::units::Length;
use std::path::Path;

/// An operand as it was named.
pub struct Operand {
    pub element: Element,
    /// A word for the result's name.
    pub stem: String,
    /// What was noticed while it was read.
    pub notices: Vec<Notice>,
}

impl Operand {
    /// Reads an operand; `unit_mm` is the unit of a mesh file's numbers, where the user says so.
    ///
    /// A name such as `ball:2mm` is a built-in element unless there is a file of that name.
    ///
    /// # Errors
    /// As [`Primitive::parse`] and [`Allowance::mesh`]; [`Error::NotSolid`] for a surface with a boundary.
    pub fn read(name: &Path, unit_mm: Option<f64>, memory: &Allowance) -> Answer<Self> {
        if let Some(words) = built_in(name) {
            let stem = words.split(':').next().unwrap_or_default().to_lowercase();
            let element = Element::BuiltIn(Primitive::parse(words)?);
            return Ok(Operand { element, stem, notices: Vec::new() });
        }
        let read = || memory.mesh(name).and_then(|loaded| solid(loaded, unit_mm));
        let (mesh, notices) = read().map_err(|e| Complaint::about(Some(name), e))?;
        let stem = if name == Path::new("-") { None } else { name.file_stem() };
        let stem = stem.map_or_else(|| "stdin".into(), |s| s.to_string_lossy().into_owned());
        Ok(Operand { element: Element::Mesh(mesh), stem, notices })
    }

    /// Side lengths of its box, millimetres.
    pub fn extent(&self) -> [f64; 3] {
        match &self.element {
            Element::BuiltIn(shape) => shape.half_extent().map(|x| 2.0 * x),
            Element::Mesh(mesh) => mesh.bounds().map_or([0.0; 3], |(lo, hi)| [0, 1, 2].map(|a| hi[a] - lo[a])),
        }
    }

    /// Its mesh; curved faces of a built-in element are inscribed, no deeper than a hundredth of the spacing.
    pub fn mesh(&self, spacing: Length) -> TriangleMesh {
        match &self.element {
            Element::BuiltIn(shape) => shape.mesh(spacing * 0.01),
            Element::Mesh(mesh) => mesh.clone(),
        }
    }
}

/// The words of a built-in element: a name of two letters or more (one is a drive) before a colon, and no such file.
fn built_in(name: &Path) -> Option<&str> {
    let words = name.to_str()?;
    let (shape, _) = words.split_once(':')?;
    let named = shape.len() > 1 && shape.chars().all(|c| c.is_ascii_alphabetic());
    (named && !name.exists()).then_some(words)
}

/// The mesh in millimetres with its normals out of the material.
fn solid(loaded: Loaded, unit_mm: Option<f64>) -> Result<(TriangleMesh, Vec<Notice>)> {
    let scale = unit_mm.or(loaded.unit_mm).unwrap_or(1.0);
    let mesh = if scale == 1.0 { loaded.mesh } else { loaded.mesh.scaled(scale) };
    let health = Health::of(&mesh);
    if !health.is_solid() {
        return Err(Error::NotSolid {
            problem: format!("{} of its edges are open; shapes are made from closed ones", health.open_edges.count),
            at_mm: health.open_edges.at_mm,
            remedy: "close the holes with a mesh repair, or export a closed solid".into(),
        });
    }
    let notices = loaded.notices.into_iter().chain(health.notices()).collect();
    Ok((health.outward(&mesh).into_owned(), notices))
}
