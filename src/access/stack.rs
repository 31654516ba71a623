//! A coaxial tool as a stack of digital discs, laid over a set slice by slice.

use super::disc::{Disc, Panel};
use super::meridian::Meridian;
use crate::error::Result;
use crate::field::Indicator;
use crate::grid::Grid;
use crate::units::Length;
use rayon::prelude::*;

/// Layers `first ..= last` above the tip that share a disc; without `last`, all from `first` on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    pub first: usize,
    pub last: Option<usize>,
    pub disc: Disc,
}

/// A tool about the vertical through its tip, as discs of a lattice with the tip in the middle of a cube.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stack {
    runs: Vec<Run>,
}

/// Which way the stack lies over the set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sense {
    /// Correlation: the tips at which the tool meets the set, S ⊕ (−T).
    Obstacle,
    /// Convolution: what the tool covers with its tip in the set, S ⊕ T.
    Swept,
}

impl Stack {
    /// Cubes that the open tool overlaps with its tip at a sample: what decides a pose at a sample.
    pub fn overlapping(tool: &Meridian, spacing: Length) -> Self {
        let h = spacing.as_mm();
        Stack::of(tool, h, |j| tool.largest_within((j - 0.5) * h, (j + 0.5) * h).and_then(|r| Disc::overlapping(r / h)))
    }

    /// Cubes that the open tool overlaps wherever in its cube the tip stands.
    pub fn surely(tool: &Meridian, spacing: Length) -> Self {
        let h = spacing.as_mm();
        Stack::of(tool, h, |j| Disc::surely(tool.least_beside(j * h) / h))
    }

    /// Cubes that the open tool, made wider and longer by `inflation` millimetres at a height, may overlap if the tip may
    /// stand anywhere in its cube; beyond `layers` layers it is as wide as there.
    pub fn possibly(tool: &Meridian, spacing: Length, layers: usize, inflation: impl Fn(f64) -> f64) -> Self {
        let h = spacing.as_mm();
        Stack::of_layers(layers.max(layers_of(tool, h)), |j| {
            let more = inflation((j + 1.0) * h);
            // Up to a cube further down or up than the tool itself, and as far as it is inflated.
            tool.largest_within((j - 1.0) * h - more, (j + 1.0) * h + more).and_then(|r| Disc::possibly((r + more) / h))
        })
    }

    /// Samples in the closed tool with its tip at a sample: the digital tool.
    pub fn middles(tool: &Meridian, spacing: Length) -> Self {
        let h = spacing.as_mm();
        Stack::of(tool, h, |j| {
            let z = j * h;
            tool.largest_within(z - 1e-9 * h, z + 1e-9 * h).and_then(|r| Disc::middles(r / h))
        })
    }

    fn of(tool: &Meridian, h: f64, disc: impl Fn(f64) -> Option<Disc>) -> Self {
        Stack::of_layers(layers_of(tool, h), disc)
    }

    fn of_layers(top: usize, disc: impl Fn(f64) -> Option<Disc>) -> Self {
        let mut runs: Vec<Run> = Vec::new();
        for j in 0..=top {
            let Some(disc) = disc(j as f64) else { continue };
            match runs.last_mut() {
                Some(run) if run.disc == disc && run.last == Some(j - 1) => run.last = Some(j),
                _ => runs.push(Run { first: j, last: Some(j), disc }),
            }
        }
        // Beyond its described length the tool goes on as it ends.
        if let Some(run) = runs.last_mut().filter(|r| r.last == Some(top)) {
            run.last = None;
        }
        Stack { runs }
    }

    /// A stack from its runs.
    pub fn new(runs: Vec<Run>) -> Self {
        Stack { runs }
    }

    /// The runs from the tip upwards.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The stack as a set of samples about the origin, cut off above `layers`.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn as_set(&self, spacing: Length, layers: usize) -> Result<Indicator> {
        let reach = self.runs.iter().map(|r| r.disc.half_width(0).unwrap_or(0).max(r.disc.reach())).max().unwrap_or(0);
        let side = 2 * reach + 1;
        let origin = [-(reach as f64) * spacing.as_mm(), -(reach as f64) * spacing.as_mm(), 0.0];
        let grid = Grid::new(origin, spacing, [side, side, layers.max(1)])?;
        Ok(Indicator::from_predicate(grid, |at| {
            let [i, j, k] = grid.index(at);
            let in_disc = |d: &Disc| d.half_width(j.abs_diff(reach)).is_some_and(|w| i.abs_diff(reach) <= w);
            self.runs.iter().any(|r| r.first <= k && r.last.is_none_or(|l| k <= l) && in_disc(&r.disc))
        }))
    }

    /// The set laid over with the stack, on the set's own grid; nothing stands outside the grid.
    ///
    /// Obstacle: `{ t : ∃j, (t + stack_j) ∩ S ≠ ∅ }`; swept: `{ t + stack : t ∈ S }`.
    ///
    /// # Cost
    /// For every disc, (rows of S that are not empty) · (2·reach + 1) word operations, and log₂(layers) walks over the words.
    pub fn dilate(&self, set: &Indicator, sense: Sense) -> Indicator {
        let mut out = Indicator::empty(*set.grid());
        let [nx, ny, nz] = set.grid().dims();
        let layer = set.words_per_row() * ny;
        let mut at = 0;
        while let Some(run) = self.runs.get(at) {
            let mut wide = vec![0u64; layer * nz];
            let spread = |panel: &mut Panel, (to, from): (&mut [u64], &[u64])| {
                run.disc.dilate_layer(from, to, nx, panel);
            };
            wide.par_chunks_mut(layer).zip(set.words().par_chunks(layer)).for_each_init(Panel::default, spread);
            window(&mut wide, layer, run, sense);
            add_window(out.words_mut(), &wide, layer, run.first, sense);
            at += 1;
        }
        out
    }
}

/// Layers beyond which a tool is as it ends.
fn layers_of(tool: &Meridian, h: f64) -> usize {
    (tool.length() / h).ceil() as usize + 2
}

/// Unites each layer with those of the run that lie beyond it: as many as the run has layers, or all.
fn window(wide: &mut [u64], layer: usize, run: &Run, sense: Sense) {
    let nz = wide.len() / layer;
    let length = run.last.map_or(nz, |l| (l - run.first + 1).min(nz));
    let mut covered = 1;
    while covered < length {
        let step = covered.min(length - covered);
        match sense {
            Sense::Obstacle => {
                for z in 0..nz.saturating_sub(step) {
                    let (low, high) = wide.split_at_mut((z + step) * layer);
                    unite(&mut low[z * layer..(z + 1) * layer], &high[..layer]);
                }
            }
            Sense::Swept => {
                for z in (step..nz).rev() {
                    let (low, high) = wide.split_at_mut(z * layer);
                    unite(&mut high[..layer], &low[(z - step) * layer..(z - step + 1) * layer]);
                }
            }
        }
        covered += step;
    }
}

fn add_window(out: &mut [u64], wide: &[u64], layer: usize, first: usize, sense: Sense) {
    let shift = (first * layer).min(out.len());
    let kept = out.len() - shift;
    match sense {
        Sense::Obstacle => unite(&mut out[..kept], &wide[shift..]),
        Sense::Swept => unite(&mut out[shift..], &wide[..kept]),
    }
}

fn unite(to: &mut [u64], from: &[u64]) {
    to.iter_mut().zip(from).for_each(|(t, &f)| *t |= f);
}

#[cfg(test)]
mod tests {
    use super::super::meridian::{Outline, Piece, Role};
    use super::*;
    use crate::convolution::Convolver;

    /// Set, stack and spacing of no symmetry.
    fn lopsided() -> (Indicator, Stack, Length) {
        let h = Length::mm(0.5);
        let grid = Grid::new([3.0, -1.0, 2.0], h, [70, 31, 24]).unwrap();
        let mut state = 7u64;
        let mut set = Indicator::empty(grid);
        for at in 0..grid.samples() {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            if (state >> 33).is_multiple_of(997) {
                set.set(grid.index(at), true);
            }
        }
        let straight =
            |role, from, to, lower, upper| Piece { role, from, to, outline: Outline::Straight { lower, upper } };
        let tool = Meridian::new(vec![
            straight(Role::Cutter, 0.0, 1.6, 0.2, 1.3),
            straight(Role::Neck, 1.6, 3.1, 1.3, 1.3),
            straight(Role::Holder, 3.1, 4.2, 2.6, 2.6),
        ]);
        (set, Stack::overlapping(&tool, h), h)
    }

    #[test]
    fn the_slices_give_what_the_transform_counts() {
        let (set, stack, h) = lopsided();
        let nz = set.grid().dims()[2];
        let tool = stack.as_set(h, nz).unwrap();
        let reach = (tool.grid().dims()[0] - 1) / 2;
        let whole = Convolver::new(&set, tool.grid().dims()).unwrap();
        let cut = |counts: &Indicator, first: [isize; 3]| counts.window(first, set.grid().dims()).unwrap();
        let met = whole.correlate(&tool).unwrap().at_least(1);
        // Translation zero stands behind the tool's last sample along z and half its width along x and y.
        let [r, top] = [reach as isize, nz as isize - 1];
        let want = cut(&met, [r, r, top]);
        assert_eq!(stack.dilate(&set, Sense::Obstacle).words(), want.words());
        assert!(want.count() > set.count() && want.count() < want.grid().samples() as u64);
        let covered = whole.convolve(&tool).unwrap().at_least(1);
        assert_eq!(stack.dilate(&set, Sense::Swept).words(), cut(&covered, [r, r, 0]).words());
    }

    #[test]
    fn readings_of_one_tool_are_nested() {
        let (set, _, h) = lopsided();
        let ball = Piece { role: Role::Cutter, from: 0.0, to: 1.7, outline: Outline::LowerBall { radius: 1.7 } };
        let tool = Meridian::new(vec![ball]);
        let hit = |stack: Stack| stack.dilate(&set, Sense::Obstacle);
        let surely = hit(Stack::surely(&tool, h));
        let overlapping = hit(Stack::overlapping(&tool, h));
        let possibly = hit(Stack::possibly(&tool, h, 24, |_| 0.0));
        assert!(surely.is_subset(&overlapping).unwrap() && overlapping.is_subset(&possibly).unwrap());
        assert!(surely.count() < overlapping.count() && overlapping.count() < possibly.count());
    }
}
