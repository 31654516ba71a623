//! Facets inside the material: where bodies overlap or touch, the nearest facet is not the boundary.

use crate::distance::squared_distance;
use crate::error::{Error, Result};
use crate::field::{Field, Indicator};
use crate::geometry::vector::{Vec3, along, distance, sub, unit};
use crate::geometry::{MeshDistance, TriangleMesh, Winding};
use crate::once::once;
use rayon::prelude::*;

/// A sample whose next outside sample is this many spacings further than the next facet is looked at: two half
/// diagonals of a cube are 1.73 of them, and an outside sample is at most 1.73 from a cube that is half outside.
const FURTHER: f64 = 3.5;

/// Refuses a solid with a facet inside its material: the distance to the facets is then less than that to the boundary,
/// and what is eroded by it is too small.
///
/// `shell2` are squared distances, in spacings, to the cubes that facets touch. A facet is inside the material if the
/// winding number just off its outer side is at least one half. What lies within four spacings of the boundary is not
/// looked for: it moves the result by no more than that, along the line where the bodies meet.
///
/// # Errors
/// [`Error::NotSolid`] with a place.
///
/// # Cost
/// One distance transform; one winding number for each sample in slits thinner than the spacing.
pub(super) fn refuse_buried_facets(
    mesh: &TriangleMesh,
    exact: &MeshDistance,
    centres: &Indicator,
    shell2: &Field<u32>,
) -> Result<()> {
    let grid = *centres.grid();
    let outside2 = squared_distance(&centres.complement())?;
    let (h, winding) = (grid.h(), std::sync::OnceLock::new());
    let buried = |at: usize| -> Option<Vec3> {
        let (facet, outside) = (f64::from(shell2.values()[at]).sqrt(), f64::from(outside2.values()[at]).sqrt());
        let index = grid.index(at);
        if outside < facet + FURTHER || !centres.contains(index) {
            return None;
        }
        let n = exact.nearest(grid.position(index), h * (facet + 1.0))?;
        let [a, b, c] = exact.corners(n.facet);
        let centre = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0);
        // A little into the facet, so that the other side of a narrow groove is further than the step off it.
        let inwards = (0.25 * h).min(0.5 * distance(centre, n.point));
        let beside = along(along(n.point, unit(sub(centre, n.point)), inwards), exact.normal(n.facet), 1e-6 * h);
        let winding = once(&winding, || Winding::new(mesh));
        (winding.at(beside) >= 0.5).then_some(n.point)
    };
    match (0..grid.samples()).into_par_iter().find_map_first(buried) {
        None => Ok(()),
        place => Err(Error::NotSolid {
            problem:
                "a facet lies inside the material, where bodies overlap or touch; what is shrunk by distances to it \
                      would fall apart there"
                    .into(),
            at_mm: place,
            remedy: "unite the bodies first: a boolean union, or `amcheck offset PART --by 0mm`".into(),
        }),
    }
}
