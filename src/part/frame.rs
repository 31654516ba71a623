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

    /// The box of each body in the frame of the file, least corner first.
    pub fn body_boxes_in_file(&self) -> Vec<[Vec3; 2]> {
        let mut corners: Vec<Vec<Vec3>> = vec![Vec::new(); self.health().bodies.len()];
        for (facet, body) in self.health().facet_body.iter().enumerate() {
            if let Some(own) = corners.get_mut(*body as usize) {
                let facet = self.mesh.corners(facet).map(|p| self.to_file(p));
                let [lo, hi] = bounds(own.iter().copied().chain(facet)).map_or([[0.0; 3]; 2], |(lo, hi)| [lo, hi]);
                *own = vec![lo, hi];
            }
        }
        corners.iter().map(|own| bounds(own.iter().copied()).map_or([[0.0; 3]; 2], |(lo, hi)| [lo, hi])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::Up;
    use crate::geometry::cuboid;
    use crate::geometry::vector::distance;

    #[test]
    fn bodies_are_told_where_the_file_has_them_however_the_part_stands() {
        let boxes = [[[30.0, 0.0, -8.0], [50.0, 10.0, -2.0]], [[55.0, 1.0, -7.0], [60.0, 4.0, -3.0]]];
        let mesh = cuboid(boxes[0][0], boxes[0][1]).joined(&cuboid(boxes[1][0], boxes[1][1]));
        for up in [Up::PlusZ, Up::MinusZ, Up::PlusX, Up::Along([0.3, -0.5, 0.7])] {
            let part = Part::new(mesh.clone(), up, 1e-6, 0.0).unwrap();
            let told = part.body_boxes_in_file();
            let off = |told: [Vec3; 2], of: [Vec3; 2]| distance(told[0], of[0]) + distance(told[1], of[1]);
            assert!(told.len() == 2 && (0..2).all(|n| off(told[n], boxes[n]) < 1e-9), "{up:?}: {told:?}");
            let z = part.extent()[2];
            assert_eq!(part.within_box([-1.0, 1.0, z + 5.0]), [0.0, 1.0, z]);
        }
    }
}
