//! The second operand of an operation.

use crate::error::{Error, Result};
use crate::geometry::{Primitive, TriangleMesh};
use crate::units::{Length, Volume};

/// The second operand: a closed mesh, or a built-in shape known in closed form.
#[derive(Debug, Clone, PartialEq)]
pub enum Element {
    /// A closed mesh, about the origin of its own frame.
    Mesh(TriangleMesh),
    /// A ball, box, cylinder or cone, centred on the origin.
    BuiltIn(Primitive),
}

impl Element {
    /// Its facets; curved faces are inscribed by a hundredth of the spacing at most.
    ///
    /// # Errors
    /// As [`wound_outwards`], and for sizes that are not positive.
    pub(super) fn faceted(&self, spacing: Length) -> Result<TriangleMesh> {
        match self {
            Element::Mesh(mesh) => wound_outwards(mesh).map(|()| mesh.clone()),
            Element::BuiltIn(shape) => {
                shape.validate()?;
                Ok(shape.mesh(spacing * 0.01))
            }
        }
    }

    /// A mesh with the lowest corner of its box at the origin: no opening or closing depends on where it lies, so that its samples must not.
    pub(super) fn in_place(&self) -> Element {
        match self {
            Element::Mesh(mesh) => {
                let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                let back = mesh.bounds().map_or([0.0; 3], |(lo, _)| lo.map(|x| -x));
                Element::Mesh(mesh.transformed(still, back))
            }
            Element::BuiltIn(_) => self.clone(),
        }
    }
}

/// Refuses a mesh whose facets enclose less than nothing: what is outside of it would be taken for its material.
///
/// # Errors
/// [`Error::NotSolid`].
///
/// # Cost
/// O(facets).
pub(super) fn wound_outwards(mesh: &TriangleMesh) -> Result<()> {
    let volume = mesh.signed_volume();
    if volume < 0.0 {
        return Err(Error::NotSolid {
            problem: format!("it is wound inside out, around {}", Volume::mm3(volume)),
            at_mm: None,
            remedy: "turn its facets to face outwards, with `flipped()` of the mesh".into(),
        });
    }
    Ok(())
}
