//! The points of a mesh that is being cut, known by where they are.

use crate::geometry::vector::{Vec3, distance};
use rustc_hash::FxHashMap;

/// The vertices of a mesh, and behind them the points at which its facets cut each other: a new one is at least the tolerance from all.
pub(super) struct Points {
    places: Vec<Vec3>,
    /// The points in each cell of a lattice.
    cells: FxHashMap<[i64; 3], Vec<u32>>,
    tolerance: f64,
}

impl Points {
    pub(super) fn new(vertices: &[Vec3], tolerance: f64) -> Self {
        let mut points = Points { places: Vec::new(), cells: FxHashMap::default(), tolerance };
        vertices.iter().for_each(|&p| _ = points.push(p));
        points
    }

    pub(super) fn place(&self, point: u32) -> Vec3 {
        self.places.get(point as usize).copied().unwrap_or_default()
    }

    pub(super) fn places(&self) -> &[Vec3] {
        &self.places
    }

    /// The nearest point within the tolerance, of equally near ones the first; a new one if there is none.
    pub(super) fn at(&mut self, p: Vec3) -> u32 {
        let [i, j, k] = self.cell(p);
        let mut near: Option<(f64, u32)> = None;
        for n in 0..27 {
            let step = [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1];
            let cell = [i.saturating_add(step[0]), j.saturating_add(step[1]), k.saturating_add(step[2])];
            for &point in self.cells.get(&cell).into_iter().flatten() {
                let found = (distance(p, self.place(point)), point);
                if found.0 <= self.tolerance && near.is_none_or(|known| found < known) {
                    near = Some(found);
                }
            }
        }
        near.map_or_else(|| self.push(p), |(_, point)| point)
    }

    fn push(&mut self, p: Vec3) -> u32 {
        let point = self.places.len() as u32;
        self.cells.entry(self.cell(p)).or_default().push(point);
        self.places.push(p);
        point
    }

    /// Cells are as wide as the tolerance: what is within it lies in a neighbour.
    fn cell(&self, p: Vec3) -> [i64; 3] {
        p.map(|x| (x / self.tolerance).floor() as i64)
    }
}
