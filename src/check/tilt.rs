//! Tilts in which a part keeps less liquid while it hangs from the plate.

use super::basin::Basin;
use super::void::Voids;
use crate::convolution::coarsened_any;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, dot, unit};
use crate::topology::{Adjacency, Falls, components, retained_towards};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

/// Samples along the longest side of the grid on which tilts are tried.
const COARSE: usize = 64;
/// Tilts that are measured on the grid of the part.
pub(super) const MEASURED_TILTS: usize = 2;
/// Height of the slabs that the film of a cup is counted in, in units of the spacing: samples of a slanted layer lie within one.
const SLAB: f64 = 2.0;

/// A tilt, measured on the grid of the part.
#[derive(Debug, Clone)]
pub(super) struct Tilt {
    /// The build direction then.
    pub up: Vec3,
    /// What is kept then.
    pub kept_mm3: f64,
    /// The film that each cup closes then, the most first.
    pub films_mm2: Vec<f64>,
}

impl Tilt {
    /// The most film that a cup closes.
    pub fn film_mm2(&self) -> f64 {
        self.films_mm2.first().copied().unwrap_or(0.0)
    }

    /// How far its cups are beyond what is allowed, then what it keeps, then how far it is from upright.
    fn order(&self, allowed_mm2: f64) -> [f64; 3] {
        [(self.film_mm2() - allowed_mm2).max(0.0), self.kept_mm3, -self.up[2]]
    }
}

/// The best of the other 25 directions of a cube: all are looked at on a coarse grid, the most promising on the grid of the part.
///
/// Tilts come first whose cups close at most `allowed_mm2` of film, or no more than as the part stands; of these the one that keeps the
/// least volume.
///
/// # Errors
/// As [`Basin::all`].
///
/// # Cost
/// Two floods of the coarse void for each direction, and two of the whole void for those that are measured, and one for the film as it stands.
pub(super) fn best_tilt(voids: &Voids, allowed_mm2: f64) -> Result<Option<Tilt>> {
    let upright = [0.0, 0.0, 1.0];
    let mut outer = voids.solid.outer.clone();
    while outer.grid().dims().into_iter().max().unwrap_or(0) > COARSE {
        outer = coarsened_any(&outer)?;
    }
    let void = outer.window([-1; 3], outer.grid().dims().map(|n| n + 2))?.complement();
    let unit_mm3 = void.grid().h().powi(3);
    let quickly = |up: Vec3| -> Result<Tilt> {
        let kept_mm3 = retained_towards(&void, up)?.count() as f64 * unit_mm3;
        Ok(Tilt { up, kept_mm3, films_mm2: films(&void, up, |_| false)? })
    };
    let directions = (0..27i32).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1].map(f64::from));
    let directions = directions.filter(|d| *d != [0.0; 3] && *d != upright).map(unit);
    let mut tilts: Vec<Tilt> = directions.map(quickly).collect::<Result<_>>()?;
    sort(&mut tilts, allowed_mm2.max(quickly(upright)?.film_mm2()));
    tilts.truncate(MEASURED_TILTS);
    let free = voids.solid.outer.complement();
    let none = Indicator::empty(*free.grid());
    let films_of = |up: Vec3| films(&free, up, |at| voids.is_sealed(at));
    let measured = tilts.into_par_iter().map(|Tilt { up, .. }| {
        let falls = if up[2] < 0.0 { Falls::Up } else { Falls::Down };
        let (basins, _) = Basin::all(voids, &retained_towards(&free, up)?, &none, falls)?;
        Ok(Tilt { up, kept_mm3: basins.iter().map(|b| b.volume).sum(), films_mm2: films_of(up)? })
    });
    let mut measured: Vec<Tilt> = measured.collect::<Result<_>>()?;
    sort(&mut measured, films_of(upright)?.into_iter().fold(allowed_mm2, f64::max));
    Ok(measured.into_iter().next())
}

fn sort(tilts: &mut [Tilt], allowed_mm2: f64) {
    let compared = |a: [f64; 3], b: [f64; 3]| a.iter().zip(&b).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne());
    tilts.sort_by(|a, b| compared(a.order(allowed_mm2), b.order(allowed_mm2)).unwrap_or(std::cmp::Ordering::Equal));
}

/// The film that each cup closes with `up` as the build direction, mm², the most first: the greatest section across it of what would be kept by
/// what falls the other way, sealed voids left out.
fn films(void: &Indicator, up: Vec3, is_sealed: impl Fn(usize) -> bool) -> Result<Vec<f64>> {
    let grid = *void.grid();
    let cups = components(&retained_towards(void, up.map(|c| -c))?, Adjacency::Corner);
    let sealed: Vec<bool> = cups.first_samples().into_iter().map(|first| is_sealed(grid.offset(first))).collect();
    let mut sections: HashMap<(u32, i64), u64> = HashMap::new();
    for at in cups.select(|label| !sealed[label as usize]).iter() {
        let index = grid.index(at);
        let slab = (dot(index.map(|i| i as f64), up) / SLAB).floor() as i64;
        if let Some(label) = cups.of(index) {
            *sections.entry((label, slab)).or_default() += 1;
        }
    }
    let mut widest: BTreeMap<u32, u64> = BTreeMap::new();
    for ((label, _), samples) in sections {
        let most = widest.entry(label).or_default();
        *most = samples.max(*most);
    }
    let mut films: Vec<f64> = widest.into_values().map(|n| n as f64 / SLAB * grid.h().powi(2)).collect();
    films.sort_by(|a, b| b.total_cmp(a));
    Ok(films)
}

#[cfg(test)]
mod tests {
    use super::super::void::tests::{flask, part};
    use super::*;

    #[test]
    fn a_tilt_that_makes_a_cup_comes_after_those_that_make_none() {
        // Open below, and so full of liquid while it hangs; turned over it would be a cup.
        let below =
            flask(20.0, 12.0, 12.0).transformed([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]], [0.0; 3]);
        let part = part(below, 0.5, [0.2, -0.1, 0.3]);
        let voids = Voids::of(&part).unwrap();
        let free = voids.solid.outer.complement();
        let films_of = |up: Vec3| films(&free, up, |_| false).unwrap();
        assert!(films_of([0.0, 0.0, 1.0]).is_empty());
        // The section of the pocket, to a sample at each wall.
        let cups = films_of([0.0, 0.0, -1.0]);
        assert!(matches!(cups[..], [cup] if (11.0f64.powi(2)..=144.0).contains(&cup)), "{cups:?}");
        let tilt = best_tilt(&voids, 1.0).unwrap().unwrap();
        assert!(tilt.kept_mm3 < 1.0 && tilt.film_mm2() <= 1.0 && tilt.up[2] > -0.1, "{tilt:?}");
    }

    #[test]
    fn what_is_beyond_the_allowed_film_counts_before_what_is_kept() {
        let tilt = |kept_mm3: f64, film: f64| Tilt { up: [1.0, 0.0, 0.0], kept_mm3, films_mm2: vec![film] };
        let mut tilts = [tilt(0.0, 300.0), tilt(60.0, 90.0), tilt(0.0, 200.0), tilt(50.0, 100.0)];
        sort(&mut tilts, 100.0);
        assert_eq!(
            tilts.map(|t| (t.kept_mm3, t.film_mm2())),
            [(50.0, 100.0), (60.0, 90.0), (0.0, 200.0), (0.0, 300.0)]
        );
    }
}
