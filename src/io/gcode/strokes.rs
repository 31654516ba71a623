//! Strokes of a path as they come.

use crate::error::Result;
use crate::geometry::vector::Vec3;
use crate::io::rows::rows_fit;

/// Strokes under way: a move that starts where the last one ended goes on with it.
#[derive(Default)]
pub(super) struct Strokes {
    pub done: Vec<Vec<Vec3>>,
    corners: usize,
    pub broken: bool,
    /// How far arcs run beside their chords at most, mm.
    pub beside: f64,
}

impl Strokes {
    pub fn add(&mut self, from: Vec3, to: Vec3, beside: f64) -> Result<()> {
        if from == to {
            return Ok(());
        }
        self.beside = self.beside.max(beside);
        rows_fit(self.corners, 24)?;
        match self.done.last_mut().filter(|_| !self.broken) {
            Some(stroke) if stroke.last() == Some(&from) => stroke.push(to),
            _ => self.done.push(vec![from, to]),
        }
        self.corners += 1;
        self.broken = false;
        Ok(())
    }
}
