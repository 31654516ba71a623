//! Which boxes come near each other.

use super::vector::Vec3;
use rayon::prelude::*;

/// A label and the corners of a box.
pub type LabelledBox = (u32, Vec3, Vec3);

/// All pairs of boxes nearer than `reach` along every axis, lower label first, in order.
///
/// # Cost
/// By a sweep along the axis on which the boxes spread most: O(n log n) and those that overlap along it.
pub fn box_pairs(mut boxes: Vec<LabelledBox>, reach: f64) -> Vec<(u32, u32)> {
    let spread = |x: usize| {
        let lows = || boxes.iter().map(|b| b.1[x]);
        lows().fold(f64::MIN, f64::max) - lows().fold(f64::MAX, f64::min)
    };
    let axis = (0..3).max_by(|&a, &b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
    boxes.sort_by(|a, b| a.1[axis].total_cmp(&b.1[axis]));
    let near = |a: &LabelledBox, b: &LabelledBox| (0..3).all(|x| a.1[x] - b.2[x] < reach && b.1[x] - a.2[x] < reach);
    let mut pairs: Vec<(u32, u32)> = boxes
        .par_iter()
        .enumerate()
        .flat_map_iter(|(i, a)| {
            let ahead = boxes[i + 1..].iter().take_while(|b| b.1[axis] - a.2[axis] < reach);
            ahead.filter(|b| near(a, b)).map(|b| (a.0.min(b.0), a.0.max(b.0)))
        })
        .collect();
    pairs.sort_unstable();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_finds_the_pairs_that_every_pair_with_every_other_finds() {
        let mut state = 3u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        let boxes: Vec<LabelledBox> = (0..200)
            .map(|i| {
                let low = [next() * 30.0, next() * 10.0, next() * 10.0];
                (i, low, low.map(|x| x + next()))
            })
            .collect();
        let mut all = Vec::new();
        for a in &boxes {
            for b in boxes.iter().filter(|b| b.0 > a.0) {
                if (0..3).all(|x| a.1[x] - b.2[x] < 0.7 && b.1[x] - a.2[x] < 0.7) {
                    all.push((a.0, b.0));
                }
            }
        }
        assert!(all.len() > 20);
        assert_eq!(box_pairs(boxes, 0.7), all);
    }
}
