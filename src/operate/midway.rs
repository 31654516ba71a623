//! The surface midway between two sets of samples: where the mean of their signed distances vanishes.

use crate::distance::{NearBoundary, signed_distance};
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::TriangleMesh;
use crate::geometry::contour::{crossing_between, linear_crossing, surface};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// The mean of the signed distances of two sets, lower ⊆ upper, millimetres; that of the upper alone where the lower is empty.
///
/// # Errors
/// As [`signed_distance`].
///
/// # Cost
/// Two distance transforms.
pub(super) fn field_between(lower: &Indicator, upper: &Indicator) -> Result<Field<f32>> {
    let distances = |set: &Indicator| -> Result<Field<f32>> { Ok(signed_distance(&widened(set)?)?.field().clone()) };
    let mut field = distances(upper)?;
    if !lower.is_empty() && lower != upper {
        let below = distances(lower)?;
        field.values_mut().par_iter_mut().zip(below.values()).for_each(|(m, &b)| *m = 0.5 * (*m + b));
    }
    Ok(field)
}

/// The surface where that mean vanishes; none if both sets are empty.
///
/// # Errors
/// As [`surface`] and [`field_between`].
///
/// # Cost
/// Some twenty words for each sample between the sets and for each vertex; as [`field_between`] where a boundary is out of reach.
pub(super) fn surface_between(lower: &Indicator, upper: &Indicator) -> Result<TriangleMesh> {
    if upper.is_empty() {
        return Ok(TriangleMesh::default());
    }
    if lower.is_empty() || lower == upper {
        // Half a spacing on either side.
        return surface(&widened(upper)?, |_| 0.5);
    }
    let wide = [widened(lower)?, widened(upper)?];
    if let Some(band) = Band::new(&wide)? {
        let lost = AtomicBool::new(false);
        let value = |index: [isize; 3]| {
            band.at(index).unwrap_or_else(|| {
                lost.store(true, Ordering::Relaxed);
                0.0
            })
        };
        let mesh = surface(&band.inside, |edge| {
            let mut next = edge.from;
            next[edge.axis] += 1;
            crossing_between(value(edge.from), value(next), 0.0)
        })?;
        if !lost.into_inner() {
            return Ok(mesh);
        }
    }
    let mean = field_between(lower, upper)?;
    let inside = Indicator::from_predicate(*mean.grid(), |at| mean.values()[at] <= 0.0);
    surface(&inside, |edge| linear_crossing(&mean, edge, 0.0))
}

/// Room for the distance to fall off on all sides, so that the border does not cut it.
pub(super) fn widened(set: &Indicator) -> Result<Indicator> {
    set.window([-2; 3], set.grid().dims().map(|n| n + 4))
}

/// The samples between two sets, with the mean distance at each.
struct Band<'a> {
    near: [NearBoundary<'a>; 2],
    samples: Indicator,
    /// By row, in order along x.
    values: Vec<Vec<f32>>,
    /// Where the mean distance is not positive.
    inside: Indicator,
}

impl<'a> Band<'a> {
    /// `None` where a boundary is out of reach.
    fn new(sets: &'a [Indicator; 2]) -> Result<Option<Self>> {
        let [lower, upper] = sets;
        let (near, samples) = ([NearBoundary::new(lower), NearBoundary::new(upper)], upper.difference(lower)?);
        let (words, ny) = (samples.words_per_row(), samples.grid().dims()[1]);
        let rows = samples.words().par_chunks(words).enumerate();
        let values = rows.map(|(row, bits)| {
            let at = |i: usize| mean(&near, [i, row % ny, row / ny].map(|n| n as isize));
            ones(bits).map(at).collect::<Option<Vec<f32>>>()
        });
        let Some(values) = values.collect::<Option<Vec<_>>>() else { return Ok(None) };
        let mut inside = lower.clone();
        let rows = inside.words_mut().par_chunks_mut(words).zip(samples.words().par_chunks(words)).zip(&values);
        rows.for_each(|((row, bits), values)| {
            let within = ones(bits).zip(values).filter(|(_, mean)| **mean <= 0.0);
            within.for_each(|(i, _)| row[i / 64] |= 1 << (i % 64));
        });
        Ok(Some(Band { near, samples, values, inside }))
    }

    /// The mean distance at a sample.
    fn at(&self, index: [isize; 3]) -> Option<f32> {
        let [i, j, k] = index.map(|n| n as usize);
        if !self.samples.contains([i, j, k]) {
            return mean(&self.near, index);
        }
        let row = self.samples.row(j, k);
        let before: u32 = row[..i / 64].iter().map(|w| w.count_ones()).sum();
        let rank = before + (row[i / 64] & ((1 << (i % 64)) - 1)).count_ones();
        self.values[k * self.samples.grid().dims()[1] + j].get(rank as usize).copied()
    }
}

fn mean([lower, upper]: &[NearBoundary; 2], index: [isize; 3]) -> Option<f32> {
    Some(0.5 * (upper.at(index)? + lower.at(index)?))
}

/// The set bits of a row, in order.
fn ones(row: &[u64]) -> impl Iterator<Item = usize> + '_ {
    row.iter().enumerate().flat_map(|(w, &word)| {
        let mut rest = word;
        std::iter::from_fn(move || {
            let bit = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
            rest &= rest - 1;
            Some(64 * w + bit)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::grid::Grid;
    use crate::units::Length;

    /// As [`surface_between`], from the field.
    fn from_field(lower: &Indicator, upper: &Indicator) -> TriangleMesh {
        let mean = field_between(lower, upper).unwrap();
        let inside = Indicator::from_predicate(*mean.grid(), |at| mean.values()[at] <= 0.0);
        surface(&inside, |edge| linear_crossing(&mean, edge, 0.0)).unwrap()
    }

    #[test]
    fn the_surface_is_that_of_the_field_bit_for_bit() {
        let grid = Grid::new([-6.0, -5.0, -4.0], Length::mm(0.2), [66, 51, 40]).unwrap();
        let level = |shape: &str, most: f64| {
            let shape = Primitive::parse(shape).unwrap();
            Indicator::from_predicate(grid, |at| shape.signed_distance(grid.position(grid.index(at))) <= most)
        };
        let specks = Indicator::from_predicate(grid, |at| at.is_multiple_of(997));
        let far = Indicator::from_predicate(grid, |at| at < 3);
        for (lower, upper) in [
            (level("ball:3mm", -0.3), level("ball:3mm", 0.35)),
            (level("box:9x7x2mm", -0.1), level("box:9x7x2mm", 0.5)),
            (level("cone:r4r0.5h6mm", -0.5), level("cone:r4r0.5h6mm", 0.3).union(&specks).unwrap()),
            (level("ball:3mm", 0.0), level("ball:3mm", 0.0)),
            (Indicator::empty(grid), level("ball:3mm", 0.0)),
            (Indicator::empty(grid), Indicator::empty(grid)),
            // A boundary farther than any reach, and sets up to the border.
            (far.clone(), level("ball:5mm", 0.0).union(&far).unwrap()),
            (level("ball:5mm", 0.0), Indicator::empty(grid).complement()),
        ] {
            assert_eq!(surface_between(&lower, &upper).unwrap(), from_field(&lower, &upper));
        }
    }
}
