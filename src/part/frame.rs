//! From the frame of the build to that of the file, and back.

use super::Part;
use crate::geometry::vector::{Vec3, add, bounds, dot, sub};

impl Part {
    /// A point of the build's frame in the frame of the file.
    pub fn to_file(&self, p: Vec3) -> Vec3 {
        self.direction_to_file(sub(p, self.translation))
    }

    /// A point of the file's frame in the frame of the build.
    pub fn to_build(&self, p: Vec3) -> Vec3 {
        add(self.direction_to_build(p), self.translation)
    }

    /// A direction of the build's frame in that of the file.
    pub fn direction_to_file(&self, d: Vec3) -> Vec3 {
        [0, 1, 2].map(|c| (0..3).map(|r| self.rotation[r][c] * d[r]).sum())
    }

    /// A direction of the file's frame in that of the build.
    pub fn direction_to_build(&self, d: Vec3) -> Vec3 {
        self.rotation.map(|row| dot(row, d))
    }

    /// Rows of the 4×4 matrix from the frame of the file to that of the build.
    pub fn pose(&self) -> [[f64; 4]; 4] {
        let row = |r: usize| {
            let [x, y, z] = self.rotation[r];
            [x, y, z, self.translation[r]]
        };
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// The point of the part's box in the frame of the build that is nearest to a point.
    pub fn within_box(&self, p: Vec3) -> Vec3 {
        let sides = self.kept.sides.get_or_init(|| self.extent());
        [0, 1, 2].map(|a| p[a].clamp(0.0, sides[a].max(0.0)))
    }

    /// A point of the build's frame as it lies from the least corner of the part's box in the frame of the file: the same however the part is
    /// stood up and wherever it lies in the file.
    pub fn from_corner(&self, p: Vec3) -> Vec3 {
        let turned = |p: Vec3| self.direction_to_file(p);
        let of_box = || bounds(self.mesh.vertices.iter().map(|&v| turned(v))).map_or([0.0; 3], |(lo, _)| lo);
        sub(turned(p), *self.kept.corner.get_or_init(of_box))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::Up;
    use crate::geometry::cuboid;
    use crate::geometry::vector::distance;

    #[test]
    fn a_point_lies_as_far_from_the_corner_however_the_part_stands_and_wherever_it_is() {
        let in_file = [31.5, 2.25, -7.125];
        for shift in [[0.0; 3], [-400.0, 12.5, 3.0]] {
            for up in [Up::PlusZ, Up::MinusZ, Up::PlusX, Up::Along([0.3, -0.5, 0.7])] {
                let mesh = cuboid([30.0, 0.0, -8.0], [50.0, 10.0, -2.0]);
                let mesh = mesh.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift);
                let part = Part::new(mesh, up, 1e-6, 0.0).unwrap();
                let at = part.from_corner(part.to_build(add(in_file, shift)));
                assert!(distance(at, [1.5, 2.25, 0.875]) < 1e-9, "{up:?}: {at:?}");
                let z = part.extent()[2];
                assert_eq!(part.within_box([-1.0, 1.0, z + 5.0]), [0.0, 1.0, z]);
            }
        }
    }
}
