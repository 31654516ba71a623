//! Motions that a body is taken along: lists of points, or of poses.

use super::accept;
use super::rows::{first_row, led, strokes};
use super::toolpath::{TOGETHER, read_points};
use crate::error::{Error, Place, Result};
use crate::geometry::Waypoint;
use crate::geometry::vector::Vec3;

/// A quaternion's length may differ from 1 by this: four decimals of its numbers. It is made a unit one.
const UNIT: f64 = 1e-3;

/// Where a body goes.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// From point to point, never turned.
    Points(Vec<Vec3>),
    /// From pose to pose.
    Poses(Vec<Waypoint>),
}

/// A motion from text: x, y and z on each line, as [`read_points`], or x, y, z and a unit quaternion w, x, y, z. The first line
/// with numbers says which.
///
/// # Errors
/// [`Error::Damaged`] naming line and value, for a line of another length, a quaternion that is not of unit length, or what is no
/// number; [`Error::Unsupported`] for several strokes, which an empty line parts; [`Error::NoGeometry`] without two lines.
///
/// ```
/// use amcheck::io::motion::{Motion, read_motion};
/// let quarter = read_motion(b"0 0 0  1 0 0 0\n5 0 0  0.70711 0 0 0.70711\n")?;
/// assert!(matches!(quarter, Motion::Poses(poses) if poses.len() == 2));
/// assert!(matches!(read_motion(b"0 0 0\n5 0 0\n")?, Motion::Points(_)));
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn read_motion(bytes: &[u8]) -> Result<Motion> {
    if first_row::<7>(bytes) == 7 {
        return Ok(Motion::Poses(only(led(strokes(bytes, ONE_POSE, waypoint)?, TOGETHER)?)?));
    }
    Ok(Motion::Points(only(read_points(bytes)?.strokes)?))
}

/// What a row of seven numbers says.
fn waypoint([x, y, z, qw, qx, qy, qz]: [f64; 7]) -> std::result::Result<Waypoint, String> {
    if let Some(problem) = accept::point_problem([x, y, z]) {
        return Err(problem);
    }
    let turn = [qw, qx, qy, qz];
    if let Some(value) = turn.iter().find(|x| !x.is_finite()) {
        return Err(format!("a number of the quaternion is not finite: {value}"));
    }
    let length = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
    if (length - 1.0).abs() > UNIT {
        return Err(format!("the quaternion {qw} {qx} {qy} {qz} has the length {length:.4}, not 1"));
    }
    Ok(Waypoint { at_mm: [x, y, z], turn: turn.map(|x| x / length) })
}

/// The one stroke there is.
fn only<T>(mut strokes: Vec<Vec<T>>) -> Result<Vec<T>> {
    match (strokes.pop(), strokes.len()) {
        (Some(stroke), 0) => Ok(stroke),
        (None, _) => Err(Error::NoGeometry {
            problem: "the list of poses holds no two in a row".into(),
            remedy: "check that the file is the one to be followed".into(),
        }),
        (_, others) => Err(Error::Unsupported {
            what: format!("a path of {} strokes", others + 1),
            place: Place::Whole,
            remedy: "sweep along one stroke at a time: an empty line ends a stroke".into(),
        }),
    }
}

const ONE_POSE: &str =
    "write x, y, z in millimetres and a unit quaternion w, x, y, z on each line, or x, y, z alone on all of them";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_read_and_faults_name_line_and_value() {
        let Motion::Poses(poses) =
            read_motion(b"# x y z w x y z\n0,0,0,1,0,0,0\n1;2;3;0.5;0.5;-0.5;0.5 # b\n").unwrap()
        else {
            panic!("no poses")
        };
        assert_eq!(poses[1], Waypoint { at_mm: [1.0, 2.0, 3.0], turn: [0.5, 0.5, -0.5, 0.5] });
        let first = "0 0 0 1 0 0 0\n";
        for (line, said) in [
            ("1 2 3", "3 numbers"),
            ("1 2 3 1 0 0", "6 numbers"),
            ("1 2 3 1 0 0 0 0", "more than 7"),
            ("1 2 3 0.9 0 0 0", "0.9"),
            ("1 2 3 1e999 0 0 0", "inf"),
            ("1 2 3 nan 0 0 0", "`nan`"),
            ("1 2 1e99 1 0 0 0", "1e99"),
        ] {
            let error = read_motion(format!("{first}{line}\n").as_bytes()).unwrap_err();
            assert_eq!(error.place(), Some("line 2".into()), "{line}");
            assert!(error.to_string().contains(said), "{line}: {error}");
        }
        assert!(read_motion(b"0 0 0\n1 2 3 1 0 0 0\n").is_err());
        for named in ["x,y,z,qw,qx,qy,qz", "# made by hand\n\n\"x [mm]\" y z w x y z # names", "x;y;z;w;q1;q2;q3;"] {
            let text = format!("{named}\n0,0,0,1,0,0,0\n1,2,3,1,0,0,0\n");
            assert!(matches!(read_motion(text.as_bytes()), Ok(Motion::Poses(poses)) if poses.len() == 2), "{named}");
        }
        for (text, line, said) in [
            ("0,0,0,1,0,0,0,\n1,2,3,1,0,0,0,\n", 1, "a comma stands behind the 7 numbers"),
            ("x,y,z\n0,0,0\n1, 2, 3, # b\n", 3, "a comma stands behind the 3 numbers"),
            ("nan,nan,nan\n0,0,0\n1,2,3\n", 1, "`nan`"),
            ("x,y,z\nx,y,z\n0,0,0\n1,2,3\n", 2, "`x`"),
            ("0,0,0\nx,y,z\n1,2,3\n", 2, "`x`"),
        ] {
            let error = read_motion(text.as_bytes()).unwrap_err();
            assert_eq!(error.place(), Some(format!("line {line}")), "{text}: {error}");
            assert!(error.to_string().contains(said), "{text}: {error}");
        }
        assert!(matches!(read_motion(first.as_bytes()), Err(Error::NoGeometry { .. })));
        let alone = format!("{first}\n{first}{first}");
        assert_eq!(read_motion(alone.as_bytes()).unwrap_err().place(), Some("line 1".into()));
        let two = format!("{first}{first}\n{first}{first}");
        assert!(matches!(read_motion(two.as_bytes()), Err(Error::Unsupported { .. })));
    }
}
