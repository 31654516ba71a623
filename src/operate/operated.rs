//! What operations make.

use super::midway::field_between;
use super::pieces::Pieces;
use super::settled::field_to;
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::geometry::TriangleMesh;
use crate::geometry::contour::MEETING;
use crate::geometry::health::{Fault, Through, crossing_pairs};
use crate::geometry::vector::{Vec3, add, scale};
use crate::grid::Grid;
use crate::morphology::Contact;
use crate::units::Volume;
use std::borrow::Cow;

/// A shape that an operation made.
#[derive(Debug, Clone, PartialEq)]
pub struct Operated {
    /// Its surface: closed and manifold; empty only where `volume` says that nothing remains.
    pub mesh: TriangleMesh,
    /// The volume of the surface: the estimate.
    pub volume: Volume,
    /// Certified bounds on the volume of the exact result.
    pub bracket: [Volume; 2],
    /// How it was done, in words.
    pub path: String,
    /// Distances near the surface, where it was made of them.
    pub(super) distances: Option<Field<f32>>,
    /// The samples inside, where the surface is that of the exact result.
    pub(super) inside: Option<Indicator>,
    /// For operations on sets of samples: what is certainly in the result, and what possibly is.
    pub sides: Option<[Indicator; 2]>,
    /// Rooms for the element of a closing that are filled and may be there: how many, and where one is.
    pub(super) filled: Option<(usize, Vec3)>,
    /// How a ball touches the part where the surface is to be, if that is made by one.
    pub(super) contact: Option<Contact>,
}

impl Operated {
    /// The pieces of its surface.
    ///
    /// # Cost
    /// O(facets).
    pub fn pieces(&self) -> Pieces<'_> {
        Pieces::of(&self.mesh)
    }

    /// With how a ball touches the part where the surface is to be.
    pub(super) fn touching(self, contact: Contact) -> Self {
        Operated { contact: Some(contact), ..self }
    }

    /// The function whose zero set the surface is: millimetres, negative inside. Exact distances near the surface of an
    /// offset; to the surface of a sum, an obstacle or a difference, and farther from it to the samples inside; else the mean of the
    /// distances to what is certainly and what possibly inside.
    ///
    /// # Errors
    /// As [`crate::distance::signed_distance`].
    ///
    /// # Cost
    /// Nothing for an offset, else at most two distance transforms, and a search for each sample near the surface of a sum.
    pub fn field(&self) -> Result<Cow<'_, Field<f32>>> {
        match (&self.distances, &self.inside, &self.sides) {
            (Some(distances), ..) => Ok(Cow::Borrowed(distances)),
            (None, Some(inside), _) => Ok(Cow::Owned(field_to(&self.mesh, inside)?)),
            (None, None, Some([lower, upper])) => Ok(Cow::Owned(field_between(lower, upper)?)),
            (None, None, None) => Err(Error::Internal { problem: "a shape without distances and sides".into() }),
        }
    }

    /// The pairs of facets of the surface that cross by more than 1e-5 spacings, and the place of one. Surfaces are made so that none
    /// cross where samples tell of sheets near each other; openings and closings by a ball have some where walls or gaps are
    /// thinner than the spacing.
    ///
    /// # Cost
    /// A tree over the facets, and a look at all pairs whose boxes meet.
    pub fn crossings(&self) -> Fault {
        let grid = self.distances.as_ref().map(Field::grid).or(self.inside.as_ref().map(Indicator::grid));
        let of_sides = || self.sides.as_ref().map(|[lower, _]| lower.grid());
        let spacing = grid.or_else(of_sides).map_or(0.0, Grid::h);
        let facets: Vec<u32> = (0..self.mesh.triangles.len() as u32).collect();
        let pairs = crossing_pairs(&self.mesh, &facets, MEETING * spacing, Through::Inside);
        let middle =
            |[f, _]: &[u32; 2]| scale(self.mesh.corners(*f as usize).into_iter().fold([0.0; 3], add), 1.0 / 3.0);
        Fault { count: pairs.len() as u64, at_mm: pairs.first().map(middle) }
    }
}
