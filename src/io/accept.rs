//! What every reader demands of geometry, whatever the format.

use crate::error::{Error, Result};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, sub};

/// The largest magnitude of a coordinate, in file units. Its cube, and sums of many such volumes, stay exact
/// to the last digits of f64; real parts end nine orders below. Values such as ±3.4e38 are fill-ins of a
/// broken exporter.
pub(super) const LARGEST_COORDINATE: f64 = 1e12;

/// The least longest side of a part, in file units: a micrometre-sized part written in metres has 1e-6.
const LEAST_EXTENT: f64 = 1e-9;

/// The most facets whose corners can all be distinct and still be counted in 32 bits.
pub(super) const MOST_FACETS: u64 = u32::MAX as u64 / 3;

/// What is wrong with a point, or `None` if it is finite and in range.
#[inline]
pub(super) fn point_problem(p: Vec3) -> Option<String> {
    // One comparison decides the good case: it is false for NaN as well.
    if p.iter().all(|x| x.abs() <= LARGEST_COORDINATE) { None } else { Some(describe_bad_point(p)) }
}

#[cold]
fn describe_bad_point(p: Vec3) -> String {
    match p.iter().find(|x| !x.is_finite()) {
        Some(x) if x.is_nan() => "a coordinate is not a number (NaN)".into(),
        Some(x) => format!("coordinate out of range: {x}"),
        None => {
            let worst = p.iter().fold(0.0f64, |w, &x| if x.abs() > w.abs() { x } else { w });
            format!("coordinate out of range: {worst:e}, allowed is ±{LARGEST_COORDINATE:e}")
        }
    }
}

/// The mesh, if it has facets and an extent.
///
/// # Errors
/// [`Error::NoGeometry`] for no facets, and for a longest side below 1e-9 file units.
pub(super) fn with_extent(mesh: TriangleMesh, format: &str) -> Result<TriangleMesh> {
    let Some((lo, hi)) = mesh.bounds() else {
        return Err(no_triangles(format));
    };
    let longest = sub(hi, lo).into_iter().fold(0.0, f64::max);
    if longest < LEAST_EXTENT {
        return Err(Error::NoGeometry {
            problem: format!("the part has no extent: its longest side is {longest:e} file units"),
            remedy: "check the scale of the export".into(),
        });
    }
    Ok(mesh)
}

/// The error of an intact file without facets.
pub(super) fn no_triangles(format: &str) -> Error {
    Error::NoGeometry {
        problem: format!("the {format} file holds no triangles"),
        remedy: "export the part again and check that a body is selected".into(),
    }
}

/// Refuses more facets than can be indexed, before anything is allocated for them.
///
/// # Errors
/// [`Error::TooLarge`].
pub(super) fn facets_fit(facets: u64) -> Result<()> {
    if facets <= MOST_FACETS {
        return Ok(());
    }
    Err(Error::TooLarge {
        what: format!("a mesh of {facets} triangles"),
        need_bytes: u128::from(facets) * 36,
        allowed_bytes: u128::from(MOST_FACETS) * 36,
        remedy: "reduce the number of triangles in the export".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_finite_and_in_range() {
        assert_eq!(point_problem([1e12, -1e12, 0.0]), None);
        assert!(point_problem([0.0, f64::NAN, 0.0]).is_some_and(|p| p.contains("NaN")));
        assert!(point_problem([0.0, 0.0, f64::NEG_INFINITY]).is_some_and(|p| p.contains("range")));
        assert!(point_problem([-3.4e38, 0.0, 0.0]).is_some_and(|p| p.contains("-3.4e38")));
    }

    #[test]
    fn a_part_needs_facets_and_an_extent() {
        let facet = |s: f64| TriangleMesh::weld([[[0.0; 3], [s, 0.0, 0.0], [0.0, s, 0.0]]]);
        assert!(with_extent(facet(1e-6), "STL").is_ok());
        assert!(matches!(with_extent(facet(1e-30), "STL"), Err(Error::NoGeometry { .. })));
        assert!(matches!(with_extent(TriangleMesh::default(), "STL"), Err(Error::NoGeometry { .. })));
    }
}
