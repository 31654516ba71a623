//! Paths that a tool or a nozzle follows: what G-code and lists of points are read as.

use super::accept;
use super::words::Words;
use crate::error::{Error, Place, Result};
use crate::geometry::vector::Vec3;
use crate::notice::Notice;

/// Most corners of a path that are read; a print of a week has fewer.
pub(super) const MOST_CORNERS: usize = 1 << 26;

/// A path as connected strokes, millimetres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Toolpath {
    /// Polylines of at least two corners, in the order they are run.
    pub strokes: Vec<Vec<Vec3>>,
    /// What has to be repeated in the report.
    pub notices: Vec<Notice>,
}

impl Toolpath {
    /// The straight pieces of all strokes.
    pub fn segments(&self) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        self.strokes.iter().flat_map(|stroke| stroke.iter().zip(stroke.iter().skip(1)).map(|(&a, &b)| [a, b]))
    }

    /// The length of all strokes, mm.
    pub fn length_mm(&self) -> f64 {
        self.segments().map(|[a, b]| crate::geometry::vector::distance(a, b)).sum()
    }

    /// The path, if it has a stroke.
    ///
    /// # Errors
    /// [`Error::NoGeometry`].
    pub(super) fn with_strokes(self, what: &str) -> Result<Self> {
        if self.strokes.is_empty() {
            return Err(Error::NoGeometry {
                problem: format!("{what} holds no path of two points or more"),
                remedy: "check that the file is the one to be followed".into(),
            });
        }
        Ok(self)
    }
}

/// Refuses a path of more corners than are read.
///
/// # Errors
/// [`Error::TooLarge`].
pub(super) fn corners_fit(corners: usize) -> Result<()> {
    if corners <= MOST_CORNERS {
        return Ok(());
    }
    Err(Error::TooLarge {
        what: format!("a path of {corners} corners"),
        need_bytes: corners as u128 * 24,
        allowed_bytes: MOST_CORNERS as u128 * 24,
        remedy: "take a part of the path".into(),
    })
}

/// A path from text with three numbers on each line; an empty line begins a new stroke, `#` a comment.
///
/// Numbers may be parted by spaces, tabs, semicolons or two commas; the decimal sign is a point.
///
/// # Errors
/// [`Error::Damaged`] naming the line; [`Error::NoGeometry`] without two points in a row.
///
/// ```
/// let path = amcheck::io::toolpath::read_points(b"0 0 0\n3 0 0\n3 4 0\n\n9 9 9\n9 9 8\n")?;
/// assert_eq!((path.strokes.len(), path.length_mm()), (2, 8.0));
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn read_points(bytes: &[u8]) -> Result<Toolpath> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text: Vec<u8> = bytes.split_inclusive(|&b| b == b'\n').flat_map(separated).collect();
    let mut words = Words::new(&text);
    let mut strokes: Vec<Vec<Vec3>> = vec![Vec::new()];
    let mut last_line = 0;
    let mut corners = 0;
    while let Some(first) = words.peek() {
        if first.text.starts_with(b"#") {
            words.next();
            words.skip_line();
            last_line = first.line;
            continue;
        }
        let line = first.line;
        let mut point = [0.0; 3];
        for value in &mut point {
            let bad = |problem: String, remedy: &str| damaged(line, problem, remedy);
            let word = words.next().filter(|w| w.line == line);
            let word = word.ok_or_else(|| bad("fewer than three numbers on the line".into(), ONE_POINT))?;
            *value = word.number().ok_or_else(|| {
                let (problem, remedy) = word.number_problem();
                bad(problem, remedy)
            })?;
        }
        if words.peek().is_some_and(|w| w.line == line && !w.text.starts_with(b"#")) {
            return Err(damaged(line, "more than three numbers on the line".into(), ONE_POINT));
        }
        if let Some(problem) = accept::point_problem(point) {
            return Err(damaged(line, problem, ONE_POINT));
        }
        if line > last_line + 1 {
            strokes.push(Vec::new());
        }
        last_line = line;
        corners += 1;
        corners_fit(corners)?;
        if let Some(stroke) = strokes.last_mut() {
            stroke.push(point);
        }
    }
    strokes.retain(|s| s.len() > 1);
    Toolpath { strokes, notices: Vec::new() }.with_strokes("the list of points")
}

/// A line with its separators as spaces: semicolons always; commas where they part three fields without a space in them,
/// because elsewhere they are decimal signs.
fn separated(line: &[u8]) -> impl Iterator<Item = u8> + '_ {
    let values = line.split(|&b| b == b'#').next().unwrap_or_default();
    let whole = |field: &[u8]| {
        let field = field.trim_ascii();
        !field.is_empty() && !field.iter().any(|b| b.is_ascii_whitespace() || *b == b';')
    };
    let fields = values.split(|&b| b == b',');
    let commas = fields.clone().count() == 3 && fields.into_iter().all(whole);
    line.iter().map(move |&b| if b == b';' || (commas && b == b',') { b' ' } else { b })
}

const ONE_POINT: &str = "write x, y and z of one point on each line, in millimetres";

fn damaged(line: u64, problem: String, remedy: &str) -> Error {
    Error::Damaged { format: "path", place: Place::Line(line), problem, remedy: remedy.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_and_faults_name_their_line() {
        let path = read_points(b"# a path\n0 0 0\n1;0;0 # here\n1 1 0\n\n\n5 5 5\r\n5 5 6").unwrap();
        assert_eq!((path.strokes.len(), path.segments().count(), path.length_mm()), (2, 3, 3.0));
        for (text, line) in [("0 0 0\n1 2\n", 2), ("0 0 0\n1 2 3 4\n", 2), ("0 0 0\n1,5 0 0\n", 2), ("0 0 1e99\n", 1)] {
            assert_eq!(read_points(text.as_bytes()).unwrap_err().place(), Some(format!("line {line}")), "{text}");
        }
        assert_eq!(read_points(b"0,0,0 # a, b\n1.5, 0,\t0\r\n").unwrap().length_mm(), 1.5);
        assert!(read_points(b"0 0 0\n1,5 2,5 3\n").is_err());
        assert!(matches!(read_points(b"0 0 0\n\n1 1 1\n"), Err(Error::NoGeometry { .. })));
    }
}
