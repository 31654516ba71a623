//! Places of a rolling ball between samples, looked for once.
//!
//! Where the ball fits by less than a spacing no sample is a place of its centre, and what it covers has to be sought sample by sample. A place
//! that is found tells that those around it are covered; about samples where there is none, none need be sought from farther away.

use super::element::StructuringElement;
use super::minkowski::dilate;
use super::offset::HALF_DIAGONAL;
use super::press::nearest_place;
use super::walls::{REACH_IN, on_its_side};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::MeshDistance;
use crate::geometry::vector::Vec3;
use rayon::prelude::*;

/// Samples no farther than this in each direction from one with a place are not given up.
const ABOUT: usize = 2;

/// Facets to look at for exact places where known ones may stand for them: about a second.
const MOST_LOOKS: u64 = 10_000_000;

/// Facets to look at for exact places at most: half a minute.
pub(super) const TOO_MANY_LOOKS: u64 = 500_000_000;

/// Places of which the nearest is sought one by one.
const MOST_KNOWN: usize = 512;

/// Samples of which the cost of a search is taken, about.
const COUNTED: usize = 64;

/// Where the centre of a ball may stand.
pub(super) struct Places {
    /// The samples in whose cubes it may, without those about which no place was found.
    pub(super) possible: Indicator,
    /// The samples of the places that were found between samples, within half a diagonal.
    pub(super) beside: Indicator,
    /// Those of them where no facet reaches into the ball but by rounding.
    pub(super) certain: Indicator,
    /// The places that were found between samples.
    pub(super) between: Vec<Vec3>,
    /// Samples beside places, and the ball's radius, millimetres.
    about: Vec<Vec3>,
    radius: f64,
}

impl Places {
    /// The places of a ball, outside where `ball` is positive, of which the samples in whose cubes one may lie are given, and those that are one.
    ///
    /// # Errors
    /// None on a grid that there is.
    ///
    /// # Cost
    /// Two dilations; up to four searches for a place at each sample that has none among the samples about it.
    pub(super) fn of(
        possible: Indicator,
        stands: &Indicator,
        (mesh, centres): (&MeshDistance, &Indicator),
        ball: f64,
    ) -> Result<Self> {
        let grid = *possible.grid();
        let among_samples = grown(stands)?;
        let lone: Vec<usize> = possible.difference(&among_samples)?.iter().collect();
        let smaller = REACH_IN * grid.h();
        let look = |at: usize| {
            let p = grid.position(grid.index(at));
            if let Some(place) = place((mesh, centres), ball, p) {
                return Some((at, place, true));
            }
            let nearly = (ball.abs() > smaller).then(|| ball - smaller * ball.signum())?;
            place((mesh, centres), nearly, p).map(|place| (at, place, false))
        };
        let found: Vec<(usize, Vec3, bool)> = lone.into_par_iter().filter_map(look).collect();
        let (mut beside, mut certain) = (Indicator::empty(grid), Indicator::empty(grid));
        for &(at, _, fits) in &found {
            beside.set(grid.index(at), true);
            certain.set(grid.index(at), fits);
        }
        let possible = possible.intersection(&grown(&beside)?.union(&among_samples)?)?;
        let between = found.into_iter().map(|(_, place, _)| place).collect();
        let about = possible.difference(stands)?.iter().map(|at| grid.position(grid.index(at))).collect();
        Ok(Places { possible, beside, certain, between, about, radius: ball.abs() })
    }

    /// What it costs that so many samples ask for their exact places, in facets looked at, by the mean of what a search costs where places are.
    ///
    /// # Cost
    /// A few searches.
    pub(super) fn looks(&self, mesh: &MeshDistance, asking: u64) -> u64 {
        let step = (self.about.len() / COUNTED).max(1);
        let looks: Vec<u64> = self.about.iter().step_by(step).map(|&p| mesh.looks(p, self.radius)).collect();
        asking.saturating_mul(looks.iter().sum::<u64>() / (looks.len() as u64).max(1))
    }

    /// Whether the nearest of the places found between samples is to stand for the exact one: it is quickly told, and those would take long.
    pub(super) fn stand_for_others(&self, looks: u64) -> bool {
        looks > MOST_LOOKS && (1..=MOST_KNOWN).contains(&self.between.len())
    }
}

/// The centre of a ball that no facet reaches into, no farther from a sample than the corners of its cube.
fn place((mesh, centres): (&MeshDistance, &Indicator), ball: f64, sample: Vec3) -> Option<Vec3> {
    let free = mesh.nearest(sample, ball.abs() * (1.0 - 1e-9)).is_none();
    let pressed = || nearest_place(mesh, ball, sample, HALF_DIAGONAL * centres.grid().h());
    let centre = if free { Some(sample) } else { pressed() }?;
    on_its_side(mesh, centres, centre, ball).then_some(centre)
}

/// A set with the samples [`ABOUT`] it.
fn grown(set: &Indicator) -> Result<Indicator> {
    let cube = StructuringElement::cuboid([2 * ABOUT + 1; 3], set.grid().spacing())?;
    dilate(set, &cube)?.set.placed([ABOUT as isize; 3], *set.grid())
}

#[cfg(test)]
mod tests {
    use super::super::rolling::open_by_ball;
    use crate::geometry::Primitive;
    use crate::units::Length;
    use std::f64::consts::PI;

    /// Volume of a part opened by a ball at a spacing, and its bracket.
    fn opened(part: &str, radius: f64, h: f64) -> [f64; 3] {
        let part = Primitive::parse(part).unwrap().mesh(Length::mm(0.004 * h));
        let made = open_by_ball(&part, Length::mm(radius), Length::mm(h)).unwrap();
        let [low, high] = made.volume.map(|v| v.as_mm3());
        [made.mesh.signed_volume(), low, high]
    }

    #[test]
    fn a_ball_that_fits_between_samples_certainly_covers_what_it_covers() {
        for (part, radius) in [("box:10x10x10mm", 5.0), ("cylinder:r5h10mm", 4.99), ("ball:5mm", 4.99)] {
            let truth = 4.0 / 3.0 * PI * 125.0;
            let [volume, low, high] = opened(part, radius, 0.16);
            println!("{part} opened by {radius} mm: {volume} in {low} … {high}");
            assert!(0.7 * truth < low && low <= truth && truth <= high, "{part}: {low} … {high}");
            assert!((volume / truth - 1.0).abs() < 0.02, "{part}: {volume}");
        }
    }

    #[test]
    fn where_the_ball_just_does_not_fit_nothing_is_covered() {
        for (part, radius) in [("box:10x10x10mm", 5.001), ("cylinder:r5h10mm", 5.002)] {
            let [volume, low, high] = opened(part, radius, 0.16);
            assert!(volume == 0.0 && low == 0.0 && high > 523.0, "{part}: {volume} in {low} … {high}");
        }
    }
}
