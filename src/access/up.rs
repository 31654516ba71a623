//! Which way of the file points up.

use super::orient::upright;
use crate::error::{Error, Result};
use crate::geometry::vector::Vec3;

/// Which way of the file points up in the build.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Up {
    #[default]
    PlusZ,
    MinusZ,
    PlusX,
    MinusX,
    PlusY,
    MinusY,
    /// Any direction of the file; it need not be a unit vector.
    Along(Vec3),
}

impl Up {
    /// Refuses a direction that points nowhere.
    ///
    /// # Errors
    /// [`Error::Usage`] with the direction, if it is zero or not finite.
    pub fn validate(self) -> Result<()> {
        match self {
            Up::Along(d) if d == [0.0; 3] || d.iter().any(|c| !c.is_finite()) => Err(Error::Usage {
                problem: format!("up along {d:?} points nowhere"),
                remedy: "give three finite numbers that are not all 0".into(),
            }),
            _ => Ok(()),
        }
    }

    /// The rotation that brings this direction to +z.
    pub fn rotation(self) -> [Vec3; 3] {
        match self {
            Up::PlusZ => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Up::MinusZ => [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            Up::PlusX => [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
            Up::MinusX => [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
            Up::PlusY => [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
            Up::MinusY => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
            Up::Along(direction) => upright(direction),
        }
    }
}

/// Six decimals, as far as they are not 0.
fn coordinate(c: f64) -> String {
    let told = format!("{c:.6}");
    match told.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".into(),
        told => told.into(),
    }
}

/// A direction of the file as `--up` takes it, told so well that a facet laid on the plate lies there.
pub fn up_option(direction: Vec3) -> String {
    match (0..3).find(|&a| direction[a].abs() > 1.0 - 1e-9) {
        Some(a) => format!("{}{}", if direction[a] > 0.0 { '+' } else { '-' }, ['x', 'y', 'z'][a]),
        None => direction.map(coordinate).join(","),
    }
}
