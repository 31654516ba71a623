//! Reading OBJ.
//!
//! The crate `tobj` parses the numbers and the faces. It names no line in its errors, resolves faces before
//! it has seen all vertices, fans concave polygons and opens material files. So the statements are read and
//! checked here, it is given vertices and faces alone in a form it cannot trip over, and its polygons are
//! clipped by our own ears.

use crate::error::{Error, Place, Result};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use crate::io::words::{Word, Words};
use crate::io::{Loaded, accept, polygon};
use crate::notice::Notice;

/// Statements that say nothing about the surface.
const IGNORED: [&str; 9] = ["vn", "vt", "g", "o", "s", "usemtl", "mtllib", "mg", "lod"];
/// Statements of curved surfaces, which are not triangles.
const FREE_FORM: [&str; 8] = ["cstype", "curv", "curv2", "surf", "deg", "parm", "bmat", "vp"];

/// The mesh of an OBJ file: its faces in file order, polygons clipped into triangles, corners welded.
///
/// # Errors
/// [`Error::Damaged`] naming the line of a bad number or an index that is zero or past the end;
/// [`Error::Unsupported`] for free-form surfaces without faces and for polygons of more than 4096 corners;
/// [`Error::NoGeometry`] without faces or extent.
///
/// # Limits
/// OBJ states no unit; coordinates are f64.
///
/// ```
/// let quad = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n";
/// assert_eq!(amcheck::io::obj::read(quad)?.mesh.triangles.len(), 2);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Loaded> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut statements = Statements::default();
    statements.read(bytes)?;
    if statements.face_count == 0 {
        return Err(statements.without_faces());
    }
    statements.check_ends()?;
    accept::facets_fit(statements.face_count)?;
    let parsed = parse(&statements)?;
    let mut notices = statements.notices();
    let mesh = triangles(&parsed, &mut notices)?;
    let mesh = accept::with_extent(mesh, "OBJ")?;
    // The text may hold any number of digits; nearly all writers print f32.
    let relative_step = f64::powi(2.0, -24);
    Ok(Loaded { mesh, format: "OBJ", unit_mm: None, notices, relative_step })
}

/// The file as vertices and faces, checked, and what was left aside.
#[derive(Default)]
struct Statements {
    vertices: Vec<u8>,
    faces: Vec<u8>,
    vertex_count: u64,
    face_count: u64,
    /// Indices larger than all before, with their lines: the first past the end is among them.
    records: Vec<(u64, u64)>,
    /// The first index that is zero or reaches back before the first vertex.
    before_start: Option<(u64, Error)>,
    lines_and_points: u64,
    free_form: u64,
    unknown: (u64, u64),
}

impl Statements {
    fn read(&mut self, bytes: &[u8]) -> Result<()> {
        let mut words = Words::new(bytes);
        let mut arguments = Vec::new();
        while let Some(head) = words.next() {
            if head.text.starts_with(b"#") {
                words.skip_line();
                continue;
            }
            gather(&mut words, head.line, &mut arguments);
            self.statement(head, &arguments)?;
        }
        Ok(())
    }

    fn statement(&mut self, head: Word<'_>, arguments: &[Word<'_>]) -> Result<()> {
        let is_one_of = |list: &[&str]| list.iter().any(|k| head.text == k.as_bytes());
        if head.text == b"v" {
            return self.vertex(head, arguments);
        }
        if head.text == b"f" || head.text == b"fo" {
            return self.face(head, arguments);
        }
        if is_one_of(&FREE_FORM) {
            self.free_form += 1;
        } else if is_one_of(&["l", "p"]) {
            self.lines_and_points += 1;
        } else if !is_one_of(&IGNORED) {
            self.unknown = (self.unknown.0 + 1, if self.unknown.0 == 0 { head.line } else { self.unknown.1 });
        }
        Ok(())
    }

    fn vertex(&mut self, head: Word<'_>, arguments: &[Word<'_>]) -> Result<()> {
        let Some([x, y, z]) = arguments.first_chunk::<3>() else {
            return Err(damaged(head.line, format!("a vertex with {} of three coordinates", arguments.len()), EXPORT));
        };
        let mut values = [0.0; 3];
        for (word, value) in [x, y, z].into_iter().zip(&mut values) {
            *value = word.number().ok_or_else(|| {
                let (problem, remedy) = word.number_problem();
                damaged(word.line, problem, remedy)
            })?;
        }
        if let Some(problem) = accept::point_problem(values) {
            return Err(damaged(head.line, problem, EXPORT));
        }
        self.vertex_count += 1;
        self.vertices.push(b'v');
        for word in [x, y, z] {
            self.vertices.push(b' ');
            self.vertices.extend_from_slice(word.text);
        }
        self.vertices.push(b'\n');
        Ok(())
    }

    fn face(&mut self, head: Word<'_>, arguments: &[Word<'_>]) -> Result<()> {
        if arguments.len() < 3 {
            self.lines_and_points += 1;
            return Ok(());
        }
        if arguments.len() > polygon::MOST_CORNERS {
            return Err(Error::Unsupported {
                what: format!("a polygon of {} corners", arguments.len()),
                place: Place::Line(head.line),
                remedy: "export the part as triangles".into(),
            });
        }
        self.face_count += 1;
        self.faces.push(b'f');
        for word in arguments {
            let index = match self.index(word) {
                Ok(index) => index,
                Err(fault) => {
                    self.before_start.get_or_insert((word.line, fault));
                    continue;
                }
            };
            if self.records.last().is_none_or(|r| index > r.0) {
                self.records.push((index, word.line));
            }
            self.faces.extend_from_slice(format!(" {index}").as_bytes());
        }
        self.faces.push(b'\n');
        Ok(())
    }

    /// The index of a corner counted from 1; negative ones count back from the vertices so far.
    fn index(&self, word: &Word<'_>) -> Result<u64> {
        let own = word.text.split(|&b| b == b'/').next().unwrap_or_default();
        let index = std::str::from_utf8(own).ok().and_then(|t| t.parse::<i64>().ok());
        let index = index.ok_or_else(|| damaged(word.line, format!("`{}` is not a corner", word.shown()), EXPORT))?;
        let so_far = i64::try_from(self.vertex_count).unwrap_or(i64::MAX);
        let from_one = if index < 0 { so_far.saturating_add(index).saturating_add(1) } else { index };
        u64::try_from(from_one).ok().filter(|&i| i > 0).ok_or_else(|| {
            let problem = format!("a face names vertex {index} of {so_far}; indices start at 1");
            damaged(word.line, problem, EXPORT)
        })
    }

    /// No face names a vertex before the first or past the last one of the file; the first fault is told.
    fn check_ends(&self) -> Result<()> {
        let past = self.records.iter().find(|r| r.0 > self.vertex_count);
        match (past, &self.before_start) {
            (None, None) => Ok(()),
            (Some(&(_, line)), Some((earlier, fault))) if *earlier < line => Err(fault.clone()),
            (Some(&(index, line)), _) => {
                Err(damaged(line, format!("a face names vertex {index} of {}", self.vertex_count), EXPORT))
            }
            (None, Some((_, fault))) => Err(fault.clone()),
        }
    }

    fn without_faces(&self) -> Error {
        if self.free_form > 0 {
            return Error::Unsupported {
                what: "an OBJ file of free-form curves and surfaces".into(),
                place: Place::Whole,
                remedy: "export the part as triangles".into(),
            };
        }
        Error::NoGeometry {
            problem: format!(
                "the OBJ file holds {} vertices, {} lines or points, and no faces",
                self.vertex_count, self.lines_and_points
            ),
            remedy: "export a surface, not points or lines".into(),
        }
    }

    fn notices(&self) -> Vec<Notice> {
        let (unknown, line) = self.unknown;
        [
            ("lines-dropped", self.lines_and_points, "lines and points were left out".to_string()),
            ("surfaces-dropped", self.free_form, "statements of free-form surfaces were left out".to_string()),
            ("unknown-statements", unknown, format!("unknown statements were passed over, the first in line {line}")),
        ]
        .into_iter()
        .filter(|n| n.1 > 0)
        .map(|(code, count, message)| Notice::new(code, format!("{count} {message}")).counted(count))
        .collect()
    }
}

/// The arguments of a statement: the other words of its line, and of the next where it ends in `\`.
fn gather<'a>(words: &mut Words<'a>, line: u64, arguments: &mut Vec<Word<'a>>) {
    arguments.clear();
    let mut line = line;
    while let Some(word) = words.peek().filter(|w| w.line == line) {
        if word.text.starts_with(b"#") {
            words.skip_line();
            return;
        }
        words.next();
        if word.text == b"\\" {
            line += 1;
        } else {
            arguments.push(word);
        }
    }
}

/// Positions, corners and numbers of corners as `tobj` reads them.
fn parse(statements: &Statements) -> Result<tobj::Mesh> {
    let text = [statements.vertices.as_slice(), &statements.faces].concat();
    let broken = |e: tobj::LoadError| Error::Internal { problem: format!("OBJ statements were refused: {e}") };
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) =
        tobj::load_obj_buf(&mut text.as_slice(), &tobj::LoadOptions::default(), no_materials).map_err(broken)?;
    let mesh = models.into_iter().next().map(|m| m.mesh);
    mesh.ok_or_else(|| Error::Internal { problem: "OBJ faces were lost".into() })
}

/// The facets of all faces, welded.
fn triangles(parsed: &tobj::Mesh, notices: &mut Vec<Notice>) -> Result<TriangleMesh> {
    let at = |i: &u32| parsed.positions.get(3 * *i as usize..).and_then(|p| p.first_chunk::<3>()).copied();
    let corners: Vec<Vec3> = parsed
        .indices
        .iter()
        .map(|i| at(i).ok_or_else(|| Error::Internal { problem: format!("OBJ corner {i} was lost") }))
        .collect::<Result<_>>()?;
    // No arities means triangles only.
    let arities: Vec<usize> = parsed.face_arities.iter().map(|&n| n as usize).collect();
    let counts = if arities.is_empty() { vec![3; corners.len() / 3] } else { arities };
    Ok(TriangleMesh::weld(polygon::facets(&corners, &counts, notices)))
}

const EXPORT: &str = "export the file again";

fn damaged(line: u64, problem: String, remedy: &str) -> Error {
    Error::Damaged { format: "OBJ", place: Place::Line(line), problem, remedy: remedy.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";

    fn load(faces: &str) -> Result<Loaded> {
        read(format!("{SQUARE}{faces}").as_bytes())
    }

    #[test]
    fn faces_of_every_form_are_read() {
        for faces in [
            "f 1 2 3\nf 1 3 4\n",
            "f 1/9/9 2//7 3/1 4\n",
            "f -4 -3 -2 -1\n",
            "f 1 2 \\\n 3 4\n",
            "o a b\ng\nmtllib ../../etc/passwd\nusemtl x\ns off\nf 1 2 3 4 # quad\n",
        ] {
            let l = load(faces).unwrap_or_else(|e| panic!("{faces}: {e}"));
            assert_eq!((l.mesh.triangles.len(), l.mesh.area(), l.notices.len()), (2, 4.0, 0), "{faces}");
        }
        assert_eq!(read(format!("f 1 2 3 4\r\n{}", SQUARE.replace('\n', "\r\n")).as_bytes()).unwrap().mesh.area(), 4.0);
        let weighted = read(b"v 0 0 0 2\nv 1 0 0 0.5 0.5 0.5\nv 0 0.1000000001 0\nf 1 2 3\n").unwrap().mesh;
        assert_eq!(weighted.vertices[2][1], 0.1000000001);
    }

    #[test]
    fn concave_faces_keep_their_area_and_bow_ties_are_noticed() {
        let dart = read(b"v 0 0 0\nv 4 -2 0\nv 1 0 0\nv 4 2 0\nf 1 2 3 4\n").unwrap();
        assert_eq!((dart.mesh.area(), dart.notices.len()), (2.0, 0));
        let bow = read(b"v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 2 0\nf 1 2 3 4\n").unwrap();
        assert_eq!(bow.notices[0].code, "polygon-fan");
    }

    #[test]
    fn what_is_no_face_is_dropped_and_said() {
        let l = load("f 1 2 3\nl 1 2\np 1\nf 1 2\nxyz 1\ncstype bspline\n").unwrap();
        let codes: Vec<_> = l.notices.iter().map(|n| (n.code.as_str(), n.count)).collect();
        assert_eq!(codes, [("lines-dropped", Some(3)), ("surfaces-dropped", Some(1)), ("unknown-statements", Some(1))]);
        assert!(matches!(load("l 1 2\n"), Err(Error::NoGeometry { .. })));
        assert!(matches!(load("surf 0 1\n"), Err(Error::Unsupported { .. })));
    }

    #[test]
    fn faults_name_their_line() {
        for (faces, line) in [
            ("f 1 2 5\n", 5),
            ("f 1 2 0\n", 5),
            ("f 1 2 -5\n", 5),
            ("f 1 2 3\nf 1 x 3\n", 6),
            ("f 1 2 3\nv 1 2\n", 6),
            ("v 1,5 2 3\nf 1 2 3\n", 5),
            ("v nan 2 3\nf 1 2 3\n", 5),
            ("v 3.4e38 2 3\nf 1 2 3\n", 5),
            ("f 1 2 99999999999999999999\n", 5),
        ] {
            let e = load(faces).unwrap_err();
            assert_eq!(e.place(), Some(format!("line {line}")), "{faces}: {e}");
        }
        assert!(load(&format!("f{}\n", " 1".repeat(5000))).is_err());
    }
}
