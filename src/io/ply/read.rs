//! Vertices and faces of a PLY file.

use super::body::{Values, damaged};
use super::header::{self, Element, Encoding, Kind, Scalar};
use crate::error::{Error, Place, Result, printable};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use crate::io::{Loaded, accept, polygon};
use crate::notice::{Notice, number_of};

/// The mesh of a PLY file: its faces in file order, polygons clipped into triangles, corners welded.
///
/// # Errors
/// [`Error::Damaged`] with line or byte for headers, counts, numbers and indices that cannot be;
/// [`Error::Unsupported`] for triangle strips; [`Error::NoGeometry`] for point clouds.
///
/// # Cost
/// One pass; counts are held against the bytes that are left before anything is allocated.
///
/// ```
/// let text = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
///     element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// assert_eq!(amcheck::io::ply::read(text)?.mesh.triangles.len(), 1);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Loaded> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let header = header::read(bytes)?;
    let mut values = Values::new(bytes, &header);
    let (mut vertices, mut faces) = (Vertices::default(), Faces::default());
    for element in &header.elements {
        let least = element.least_bytes(header.encoding).max(1);
        // The last number of a text needs no space behind it.
        if element.count.saturating_mul(least) > values.bytes_left() + 1 {
            return Err(count_too_large(element, &values));
        }
        match element.name.as_str() {
            "vertex" => vertices = Vertices::read(element, &mut values)?,
            "face" => faces = Faces::read(element, &mut values)?,
            "tristrips" => return Err(strips()),
            _ => (0..element.count).try_for_each(|_| skip_one(element, &mut values))?,
        }
    }
    if faces.counts.is_empty() {
        return Err(Error::NoGeometry {
            problem: format!(
                "the PLY file holds {} and no faces",
                number_of(vertices.points.len() as u64, ["point", "points"])
            ),
            remedy: "reconstruct a surface from the points and export that".into(),
        });
    }
    let mut notices = faces.notices();
    let mesh = faces.mesh(&vertices.points, &mut notices)?;
    let mesh = accept::with_extent(mesh, "PLY")?;
    // Doubles that are all floats came from a format of floats and resolve no more.
    let finer = vertices.doubles && vertices.points.iter().flatten().any(|&x| f64::from(x as f32) != x);
    let relative_step = if finer { f64::EPSILON / 2.0 } else { f64::powi(2.0, -24) };
    let format = if header.encoding == Encoding::Text { "PLY (ASCII)" } else { "PLY (binary)" };
    Ok(Loaded { mesh, format, unit_mm: None, notices, relative_step })
}

fn skip_one(element: &Element, values: &mut Values<'_>) -> Result<()> {
    element.properties.iter().try_for_each(|p| values.skip(p.kind))
}

fn count_too_large(element: &Element, values: &Values<'_>) -> Error {
    let problem = format!(
        "the header counts {} of `{}`, but only {} bytes are left for them",
        element.count,
        printable(&element.name),
        values.bytes_left()
    );
    damaged(values.place(), problem, "export or copy the file again")
}

fn strips() -> Error {
    Error::Unsupported {
        what: "a PLY file of triangle strips".into(),
        place: Place::Key("element tristrips".into()),
        remedy: "export the part with faces".into(),
    }
}

/// The points of the file.
#[derive(Default)]
struct Vertices {
    points: Vec<Vec3>,
    doubles: bool,
}

impl Vertices {
    fn read(element: &Element, values: &mut Values<'_>) -> Result<Self> {
        let axis = |name: &str| ["x", "y", "z"].iter().position(|a| *a == name);
        let axes: Vec<(Option<usize>, Kind)> = element.properties.iter().map(|p| (axis(&p.name), p.kind)).collect();
        for (a, name) in ["x", "y", "z"].iter().enumerate() {
            if axes.iter().filter(|(axis, kind)| *axis == Some(a) && matches!(kind, Kind::One(_))).count() != 1 {
                let problem = format!("vertices need one number `{name}`");
                return Err(damaged(Place::Key("element vertex".into()), problem, "export the file again"));
            }
        }
        let mut points = Vec::with_capacity(usize::try_from(element.count).unwrap_or(0));
        for _ in 0..element.count {
            let place = values.place();
            let mut point = [0.0; 3];
            for &(axis, kind) in &axes {
                match (axis.and_then(|a| point.get_mut(a)), kind) {
                    (Some(to), Kind::One(scalar)) => *to = values.number(scalar)?,
                    _ => values.skip(kind)?,
                }
            }
            if let Some(problem) = accept::point_problem(point) {
                return Err(damaged(place, problem, "export the file again"));
            }
            points.push(point);
        }
        let doubles = axes.iter().all(|(axis, kind)| axis.is_none() || *kind == Kind::One(Scalar::F64));
        Ok(Vertices { points, doubles })
    }
}

/// The corners of all faces in one list, and how many each has.
#[derive(Default)]
struct Faces {
    corners: Vec<u32>,
    counts: Vec<usize>,
    dropped: u64,
}

impl Faces {
    fn read(element: &Element, values: &mut Values<'_>) -> Result<Self> {
        let is_corners = |name: &str| name == "vertex_indices" || name == "vertex_index";
        let mut faces = Faces::default();
        if element.count > 0 && !element.properties.iter().any(|p| is_corners(&p.name)) {
            let problem = "faces need a list `vertex_indices`".to_string();
            return Err(damaged(Place::Key("element face".into()), problem, "export the file again"));
        }
        for _ in 0..element.count {
            for property in &element.properties {
                match property.kind {
                    Kind::List { count, item } if is_corners(&property.name) => faces.face(count, item, values)?,
                    kind => values.skip(kind)?,
                }
            }
        }
        accept::facets_fit(faces.corners.len() as u64)?;
        Ok(faces)
    }

    fn face(&mut self, count: Scalar, item: Scalar, values: &mut Values<'_>) -> Result<()> {
        let corners = values.length(count, polygon::MOST_CORNERS as u64)?;
        let start = self.corners.len();
        for _ in 0..corners {
            let place = values.place();
            let index = values.number(item)?;
            if !(index >= 0.0 && index < f64::from(u32::MAX) && index.fract() == 0.0) {
                return Err(damaged(place, format!("a face names vertex {index}"), "export the file again"));
            }
            self.corners.push(index as u32);
        }
        if corners < 3 {
            self.corners.truncate(start);
            self.dropped += 1;
        } else {
            self.counts.push(corners as usize);
        }
        Ok(())
    }

    fn notices(&self) -> Vec<Notice> {
        let dropped = (self.dropped > 0).then(|| {
            let words =
                ["face of fewer than three corners was left out", "faces of fewer than three corners were left out"];
            let message = number_of(self.dropped, words);
            Notice::new("lines-dropped", message).counted(self.dropped)
        });
        dropped.into_iter().collect()
    }

    fn mesh(&self, points: &[Vec3], notices: &mut Vec<Notice>) -> Result<TriangleMesh> {
        let corners: Vec<Vec3> = self.corners.iter().map_while(|&i| points.get(i as usize)).copied().collect();
        if corners.len() == self.corners.len() {
            return Ok(TriangleMesh::weld(polygon::facets(&corners, &self.counts, notices)));
        }
        // The face that holds the first corner that is missing.
        let mut past = 0;
        let face = self.counts.iter().take_while(|&&n| {
            past += n;
            past <= corners.len()
        });
        let index = self.corners.get(corners.len()).copied().unwrap_or(0);
        let problem = format!("face {} names vertex {index} of {}", face.count() + 1, points.len());
        Err(damaged(Place::Key("element face".into()), problem, "export the file again"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty uchar red\nproperty list uchar short extra\nproperty float y\nproperty float z\nelement other 2\nproperty list int float junk\nelement face 1\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n";
    const BODY: &str = "0 9 0 0 0\n2 9 1 7 0 0\n2 9 2 7 7 2 0\n0 9 0 2 0\n2 1.5 2.5\n0\n1 4 0 1 2 3\n";

    /// The same file in binary.
    fn binary(order: &str) -> Vec<u8> {
        let mut out = HEAD.replace("ascii", &format!("binary_{order}_endian")).replace('\n', "\r\n").into_bytes();
        let big = order == "big";
        let mut put = |raw: &[u8]| out.extend(if big { raw.iter().rev().copied().collect() } else { raw.to_vec() });
        for (x, y, extra) in [(0.0f32, 0.0f32, 0u8), (2.0, 0.0, 1), (2.0, 2.0, 2), (0.0, 2.0, 0)] {
            put(&x.to_le_bytes());
            put(&[9, extra][..1]);
            put(&[extra]);
            (0..extra).for_each(|_| put(&7i16.to_le_bytes()));
            put(&y.to_le_bytes());
            put(&0f32.to_le_bytes());
        }
        put(&2i32.to_le_bytes());
        put(&1.5f32.to_le_bytes());
        put(&2.5f32.to_le_bytes());
        put(&0i32.to_le_bytes());
        put(&[1]);
        put(&[4]);
        (0..4i32).for_each(|i| put(&i.to_le_bytes()));
        out
    }

    #[test]
    fn unknown_properties_are_skipped_in_every_encoding() {
        let text = read(format!("{HEAD}{BODY}").as_bytes()).unwrap();
        assert_eq!((text.mesh.triangles.len(), text.mesh.area()), (2, 4.0));
        for order in ["little", "big"] {
            assert_eq!(read(&binary(order)).unwrap().mesh, text.mesh, "{order}");
        }
    }

    #[test]
    fn counts_and_lists_that_cannot_be_are_refused() {
        let with = |from: &str, to: &str| read(format!("{HEAD}{BODY}").replacen(from, to, 1).as_bytes()).unwrap_err();
        assert!(with("vertex 4", "vertex 1000000000000").to_string().contains("1000000000000"));
        assert!(with("face 1", "face 1000000000000").to_string().contains("bytes are left"));
        assert!(with("1 4 0 1 2 3", "1 2147483648 0 1 2 3").to_string().contains("2147483648"));
        assert!(with("1 4 0 1 2 3", "1 -4 0 1 2 3").to_string().contains("-4"));
        assert!(with("1 4 0 1 2 3", "1 4 0 1 2 4").to_string().contains("vertex 4 of 4"));
        assert!(with("1 4 0 1 2 3", "1 4 0 1 2 -1").to_string().contains("vertex -1"));
        assert!(with("1 4 0 1 2 3", "1 4 0 1 2").to_string().contains("ends"));
        assert!(with("0 9 0 0 0", "nan 9 0 0 0").to_string().contains("nan"));
        assert!(with("element face 1", "element tristrips 1").to_string().contains("strips"));
        assert!(matches!(with("1 4 0 1 2 3", "1 2 0 1"), Error::NoGeometry { .. }));
        let whole = binary("little");
        for cut in 0..whole.len() {
            assert!(read(&whole[..cut]).is_err(), "{cut}");
        }
    }
}
