//! The direction of the file that points up in the build.

use crate::geometry::vector::Vec3;

/// Which way of the file points up in the build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Up {
    #[default]
    PlusZ,
    MinusZ,
    PlusX,
    MinusX,
    PlusY,
    MinusY,
}

impl Up {
    /// The rotation that brings this direction to +z.
    pub fn rotation(self) -> [Vec3; 3] {
        match self {
            Up::PlusZ => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Up::MinusZ => [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            Up::PlusX => [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
            Up::MinusX => [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
            Up::PlusY => [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
            Up::MinusY => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        }
    }
}
