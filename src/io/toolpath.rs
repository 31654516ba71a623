//! Paths that a tool or a nozzle follows: what G-code and lists of points are read as.

use super::accept;
use super::rows::{led, strokes};
use crate::error::{Error, Result};
use crate::geometry::vector::Vec3;
use crate::notice::Notice;
use crate::units::Length;

/// A path as connected strokes, millimetres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Toolpath {
    /// Polylines of at least two corners, in the order they are run.
    pub strokes: Vec<Vec<Vec3>>,
    /// How far the path that is meant may run beside them: arcs beside their chords.
    pub beside: Length,
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

/// A path from text with three numbers on each line; an empty line begins a new stroke, `#` a comment.
///
/// Numbers may be parted by spaces, tabs, semicolons or two commas; the decimal sign is a point.
///
/// # Errors
/// [`Error::Damaged`] naming the line, also of a point that stands alone among others; [`Error::NoGeometry`] without two points.
///
/// ```
/// let path = amcheck::io::toolpath::read_points(b"0 0 0\n3 0 0\n3 4 0\n\n9 9 9\n9 9 8\n")?;
/// assert_eq!((path.strokes.len(), path.length_mm()), (2, 8.0));
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn read_points(bytes: &[u8]) -> Result<Toolpath> {
    let point = |point: Vec3| accept::point_problem(point).map_or(Ok(point), Err);
    let strokes = led(strokes(bytes, ONE_POINT, point)?, TOGETHER)?;
    Toolpath { strokes, ..Toolpath::default() }.with_strokes("the list of points")
}

const ONE_POINT: &str = "write x, y and z of one point on each line, in millimetres";

/// What to do about a line that stands alone.
pub(super) const TOGETHER: &str = "take the empty line out, or sweep along one stroke at a time";

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
        for (text, line) in [("0 0 0\n\n5 0 0\n8 0 0\n", 1), ("0 0 0\n5 0 0\n\n\n8 0 0", 5), ("\n1 0 0\n\n2 0 0\n", 2)]
        {
            let refused = read_points(text.as_bytes()).unwrap_err();
            assert!(
                refused.place() == Some(format!("line {line}")) && refused.to_string().contains("alone"),
                "{refused}"
            );
        }
        assert!(matches!(read_points(b"\n\n1 0 0\n"), Err(Error::NoGeometry { .. })));
        // A row of another length is told as that, however its numbers are parted; a comma within a row parted by others is a decimal sign.
        for (row, said) in [
            ("1,2", "2 numbers on the line, where 3 are needed"),
            ("1, -2.5 # b", "2 numbers on the line, where 3 are needed"),
            ("1;2", "2 numbers on the line, where 3 are needed"),
            ("1,2,", "2 numbers on the line, where 3 are needed"),
            ("7", "1 number on the line, where 3 are needed"),
            ("1,2,3,4", "more than 3 numbers on the line"),
            ("1,5 2,5 3,5", "`1,5` is not a number"),
            ("1,5;2,5;3,5", "`1,5` is not a number"),
            ("1,x", "`1,x` is not a number"),
        ] {
            let refused = read_points(format!("0,0,0\n{row}\n").as_bytes()).unwrap_err();
            assert_eq!(refused.place(), Some("line 2".into()), "{row}: {refused}");
            assert!(refused.to_string().contains(said), "{row}: {refused}");
        }
        assert_eq!(read_points(b"\n# from\n0 0 0\n# to\n1 0 0\n").unwrap().length_mm(), 1.0);
        assert!(read_points(b"0 0 0\n1,5 2,5 3\n").is_err());
    }
}
