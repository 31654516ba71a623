//! What an operation is done to: a mesh file or a built-in element.

use super::complaint::{Answer, Complaint};
use super::words::usage;
use crate::error::{Error, Result};
use crate::geometry::vector::{Vec3, norm};
use crate::geometry::{Health, Primitive, TriangleMesh};
use crate::io::Loaded;
use crate::memory::Allowance;
use crate::notice::{Notice, number_of};
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

    /// A ball as an operand.
    ///
    /// # Errors
    /// [`Error::Operand`] for a radius that is not positive.
    pub fn ball(radius: Length) -> Result<Self> {
        let shape = Primitive::Ball { radius };
        shape.validate()?;
        Ok(Operand { element: Element::BuiltIn(shape), stem: "ball".into(), notices: Vec::new() })
    }

    /// A mesh as an operand without a name.
    pub fn of(mesh: TriangleMesh) -> Self {
        Operand { element: Element::Mesh(mesh), stem: String::new(), notices: Vec::new() }
    }

    /// Side lengths of its box, millimetres.
    pub fn extent(&self) -> [f64; 3] {
        self.bounds().map_or([0.0; 3], |(lo, hi)| [0, 1, 2].map(|a| hi[a] - lo[a]))
    }

    /// Its box.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        match &self.element {
            Element::BuiltIn(shape) => Some((shape.half_extent().map(|x| -x), shape.half_extent())),
            Element::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// How far it reaches from its origin, millimetres.
    pub fn reach(&self) -> f64 {
        match &self.element {
            Element::BuiltIn(shape) => norm(shape.half_extent()),
            Element::Mesh(mesh) => mesh.vertices.iter().map(|&p| norm(p)).fold(0.0, f64::max),
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

/// Refuses operands of which several are standard input: it can be read once.
///
/// # Errors
/// [`Error::Usage`].
pub fn one_from_stdin(names: &[&Path]) -> Result<()> {
    match names.iter().filter(|name| **name == Path::new("-")).count() {
        0 | 1 => Ok(()),
        n => Err(usage(&format!("standard input is to be {n} operands"), "name files for all but one of them")),
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
    let (scale, overruled) = (unit_mm.or(loaded.unit_mm).unwrap_or(1.0), loaded.overruled_by(unit_mm));
    let mesh = if scale == 1.0 { loaded.mesh } else { loaded.mesh.scaled(scale) };
    let health = Health::of(&mesh);
    if !health.is_solid() {
        return Err(why_no_solid(&health));
    }
    // Nobody guesses where the user has said it.
    let guess = health.units_guess().filter(|_| unit_mm.is_none() && scale == 1.0);
    let notices = loaded.notices.into_iter().chain(overruled).chain(health.notices()).chain(guess).collect();
    Ok((health.outward(&mesh).into_owned(), notices))
}

/// What keeps a surface from being a solid's, with a place and a way out.
fn why_no_solid(health: &Health) -> Error {
    let (open, miswound) = (health.open_edges, health.miswound_edges);
    let repair = "`amcheck PART --repair` leaves repaired.3mf, if turning facets and closing cracks is enough";
    let (problem, at_mm, remedy) = if open.count > 0 {
        let problem = format!(
            "{}; shapes are made from closed ones",
            number_of(open.count, ["of its edges is open", "of its edges are open"])
        );
        (problem, open.at_mm, format!("close the holes, or export a closed solid; {repair}"))
    } else if miswound.count > 0 {
        let problem = format!("along {} of its edges facets face opposite sides", miswound.count);
        (problem, miswound.at_mm, format!("turn the facets to face outwards; {repair}"))
    } else if health.unbalanced_edges > 0 {
        let problem = format!("along {} of its edges more facets run one way than the other", health.unbalanced_edges);
        (problem, health.non_manifold_edges.at_mm, format!("leave out facets that are there twice; {repair}"))
    } else {
        ("it encloses no volume".into(), None, "export a closed solid".into())
    };
    Error::NotSolid { problem, at_mm, remedy }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(corners: &[[usize; 3]]) -> String {
        let at = [[0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]];
        let mesh = TriangleMesh::weld(corners.iter().map(|t| t.map(|v| at[v])).collect::<Vec<_>>());
        why_no_solid(&Health::of(&mesh)).to_string()
    }

    #[test]
    fn what_keeps_a_surface_from_being_a_solid_is_said() {
        let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert!(refusal(&sides[..3]).contains("3 of its edges are open"), "{}", refusal(&sides[..3]));
        let turned = [[0, 1, 2], sides[1], sides[2], sides[3]];
        assert!(refusal(&turned).contains("along 3 of its edges facets face opposite sides"), "{}", refusal(&turned));
        let twice = [sides[0], sides[0], sides[1], sides[2], sides[3]];
        assert!(refusal(&twice).contains("more facets run one way than the other"), "{}", refusal(&twice));
        assert!(refusal(&[sides[0], [0, 1, 2]]).contains("encloses no volume"));
    }
}
