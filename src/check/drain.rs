//! AM302: liquid that the part keeps in this orientation, and cups that suck.

use super::contract::{Check, Context, Measured, Meta, Outcome, ShapeShown, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Limits, Spot, State};
use super::place::{group_equal, locate, reported};
use super::vent::{drilled, shortest_vent};
use super::void::Voids;
use crate::convolution::coarsened_any;
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::TriangleMesh;
use crate::geometry::contour::surface;
use crate::geometry::vector::{Vec3, unit};
use crate::part::Part;
use crate::process::Process;
use crate::topology::{Adjacency, Falls, Passage, components, retained, retained_towards};
use crate::units::{report_digits, short};
use rayon::prelude::*;

/// AM302 `drain`.
pub struct Drain;

static META: Meta = Meta {
    code: "AM302",
    name: "drain",
    title: "Liquid kept in this orientation, and cups that suck",
    what: "Gives the volume of liquid that stays in the part while it hangs from the plate (build direction down), and the area of \
           film that each cup closes while its walls are printed. Sealed voids are left to trapped-volume.",
    why: "Kept resin is carried into the wash, cures where it should not and is paid for. A cup that closes on the film is under \
          vacuum at every layer: it tears the part off, or the film.",
    how: "A sample keeps liquid if every way to the outside rises above it: layers are added from the lowest up, regions are joined, \
          and what has not met the outside in its own layer keeps what it holds. The same from the other side gives the cups: what is \
          cut off from the outside while the layers above are not there yet. Done once with the samples that are wholly free, once \
          with all that may be; the volume between is bracketed, and its value comes from the densities.",
    limits: "Holds for a plate above and a film below; where the printer has it the other way round, the two numbers change places. \
             Films, drops and slow flow are not modelled, so nothing here fails. Basins of fewer than 27 samples are counted in the \
             cover. Of 25 tilts, looked at on a coarse grid of 64 samples, four are measured on the grid of the part.",
    source: "Priority flood: R. Barnes, C. Lehman, D. Mulla, Priority-flood: an optimal depression-filling algorithm, 2014.",
};

/// Basins of fewer samples are below what the grid tells.
const LEAST_SAMPLES: u64 = 27;
/// Samples along the longest side of the grid on which tilts are tried.
const COARSE: usize = 64;
/// Tilts that are measured on the grid of the part.
const MEASURED_TILTS: usize = 4;
/// A vent against suction, millimetres: the least hole that drains, by the escape limit of resin.
const VENT: f64 = 3.5;

impl Check for Drain {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let (kept, suction) = (limits_of(process, "drain"), limits_of(process, "drain.suction"));
        if kept.is_none() && suction.is_none() {
            return Ok(Outcome::NotApplicable("nothing liquid is in this process, or it sets no limit".into()));
        }
        let voids = Voids::of(part)?;
        let mut judge = Judge {
            part,
            context,
            voids: &voids,
            measured: Measured::default(),
            small: 0,
            mesh: TriangleMesh::default(),
        };
        if let Some(limits) = kept {
            judge.kept(limits)?;
        }
        if let Some(limits) = suction {
            judge.suction(limits)?;
        }
        judge.finish();
        Ok(Outcome::Measured(Box::new(judge.measured)))
    }
}

/// Liquid that stands together.
struct Basin {
    set: Indicator,
    /// The set with the samples at its walls that the part touches.
    walled: Indicator,
    /// Its volume from the densities, mm³.
    volume: f64,
    /// Samples that keep liquid whatever the doubtful ones are.
    certain: Indicator,
    extent: ([usize; 3], [usize; 3]),
}

struct Judge<'a> {
    part: &'a Part,
    context: &'a Context,
    voids: &'a Voids<'a>,
    measured: Measured,
    small: u64,
    mesh: TriangleMesh,
}

impl Judge<'_> {
    /// The basins of at least some samples, largest first, sealed voids left out.
    fn basins(&mut self, falls: Falls) -> Result<Vec<Basin>> {
        let solid = self.voids.solid;
        let likely = retained(&solid.outer.complement(), falls, Passage::Faces)?;
        let certain = retained(&solid.inner.complement(), falls, Passage::Corners)?.difference(&solid.outer)?;
        let (basins, small) = self.parted(&likely, &certain)?;
        self.small += small;
        Ok(basins)
    }

    /// The basins that kept samples make, as [`Judge::basins`], and how many samples are in smaller ones.
    fn parted(&self, likely: &Indicator, certain: &Indicator) -> Result<(Vec<Basin>, u64)> {
        let parts = components(likely, Adjacency::Corner);
        let (sizes, boxes, firsts) = (parts.sizes(), parts.boxes(), parts.first_samples());
        let mut order: Vec<usize> =
            (0..parts.count()).filter(|&l| !self.voids.is_sealed(likely.grid().offset(firsts[l]))).collect();
        order.sort_by_key(|&l| (std::cmp::Reverse(sizes[l]), l));
        let (large, small): (Vec<usize>, Vec<usize>) = order.into_iter().partition(|&l| sizes[l] >= LEAST_SAMPLES);
        let basin = |l: usize| {
            let set = parts.select(|m| m as usize == l);
            let certain = certain.intersection(&set)?;
            let walled = set.union(&self.voids.ringed(&set).intersection(&self.voids.solid.outer)?)?;
            let volume = self.volume(&walled);
            Ok(Basin { set, walled, volume, certain, extent: (boxes[l][0], boxes[l][1]) })
        };
        let basins: Result<Vec<Basin>> = large.into_iter().map(basin).collect();
        Ok((basins?, small.iter().map(|&l| sizes[l]).sum()))
    }

    /// Volume of void in a set of samples.
    fn volume(&self, set: &Indicator) -> f64 {
        let density = self.voids.solid.density.field().values();
        set.iter().map(|at| 1.0 - f64::from(density[at])).sum::<f64>() * self.context.spacing_mm.powi(3)
    }

    fn bracket(&self, b: &Basin) -> Bracket {
        let unit = self.context.spacing_mm.powi(3);
        Bracket::new(b.volume, b.certain.count() as f64 * unit, b.walled.count() as f64 * unit)
    }

    fn corners(&self, b: &Basin) -> (Vec3, Vec3) {
        let grid = b.set.grid();
        let half = 0.5 * grid.h();
        (grid.position(b.extent.0).map(|c| c - half), grid.position(b.extent.1).map(|c| c + half))
    }

    /// The sample of a basin in its lowest layer for the film, nearest to the middle of that layer.
    fn bottom(&self, b: &Basin) -> Vec3 {
        let grid = b.set.grid();
        let layer = b.extent.0[2];
        let [nx, ny, _] = grid.dims();
        let mut best = (usize::MAX, b.extent.0);
        for (j, i) in (b.extent.0[1]..=b.extent.1[1].min(ny - 1)).flat_map(|j| (0..nx).map(move |i| (j, i))) {
            if b.set.contains([i, j, layer]) {
                let far =
                    (2 * i).abs_diff(b.extent.0[0] + b.extent.1[0]) + (2 * j).abs_diff(b.extent.0[1] + b.extent.1[1]);
                best = best.min((far, [i, j, layer]));
            }
        }
        grid.position(best.1)
    }

    /// What stays in while the part hangs from the plate.
    fn kept(&mut self, limits: Limits) -> Result<()> {
        let basins = self.basins(Falls::Up)?;
        let sum = basins.iter().map(|b| self.bracket(b)).fold(Bracket::exact(0.0), |s, b| Bracket {
            value: s.value + b.value,
            low: s.low + b.low,
            high: s.high + b.high,
        });
        let bracket = sum;
        let at = basins.first().map(|b| self.bottom(b));
        self.worst(bracket, "mm3", at, "drain");
        let mut f = Finding::judged(META.code, "kept", bracket, Basis::Estimated, limits, "mm3", 0.0);
        let (Some(largest), Some(at)) = (basins.first(), at) else { return Ok(()) };
        if f.state == State::Pass {
            return Ok(());
        }
        locate(&mut f, self.part, self.context, at, self.corners(largest));
        f.count = basins.len() as u64;
        f.volume_mm3 = Some(report_digits(bracket.value));
        f.places = basins
            .iter()
            .map(|b| {
                let own = self.bracket(b).rounded();
                Spot { at_mm: reported(self.part, self.bottom(b)), value: own.value, low: own.low, high: own.high }
            })
            .collect();
        f.message = format!("keeps about {} mm³ of liquid while it hangs from the plate", short(bracket.value.round()));
        let (tilt, left) = self.best_tilt()?;
        f.fix = if left < 0.5 * bracket.value {
            format!("{tilt}: measured again, it keeps about {} mm³ then", short(left.round()))
        } else {
            format!(
                "drill a hole at the lowest place of each basin; the {MEASURED_TILTS} most promising of 25 tilts keep {} mm³ or more",
                short(left.round())
            )
        };
        self.measured.findings.push(f);
        basins.iter().try_for_each(|b| self.show(&b.set))
    }

    /// The film that each cup closes.
    fn suction(&mut self, limits: Limits) -> Result<()> {
        let basins = self.basins(Falls::Down)?;
        let widest = limits.fail.into_iter().chain(limits.warn).fold(f64::INFINITY, f64::min);
        let mut found = Vec::new();
        for b in &basins {
            let bracket = self.film(b);
            let at = self.bottom(b);
            self.worst(bracket, "mm2", Some(at), "drain.suction");
            let mut f = Finding::judged(META.code, "cup", bracket, Basis::Estimated, limits, "mm2", 0.0);
            if f.state == State::Pass {
                continue;
            }
            locate(&mut f, self.part, self.context, at, self.corners(b));
            f.area_mm2 = Some(report_digits(bracket.value));
            f.volume_mm3 = Some(report_digits(b.volume));
            let half = 0.5 * self.context.spacing_mm;
            f.message = format!(
                "a cup that closes {} mm² of film between {} and {} mm above the plate",
                short(bracket.value.round()),
                short(((at[2] - half).max(0.0) * 10.0).round() / 10.0),
                short((self.corners(b).1[2] * 10.0).round() / 10.0)
            );
            f.fix = self.vented(at, widest)?;
            found.push(f);
            self.show(&b.set)?;
        }
        // Cups of one kind differ by how the grid cuts their rims.
        let tolerance = found.first().map_or(0.0, |f: &Finding| 0.03 * f.value);
        let mut grouped = group_equal(found, tolerance);
        for f in grouped.iter_mut().filter(|f| f.count > 1) {
            f.message = format!("{} cups: {}", f.count, f.message);
        }
        self.measured.findings.extend(grouped);
        Ok(())
    }

    /// Greatest area of a layer of a cup.
    fn film(&self, b: &Basin) -> Bracket {
        let area = self.context.spacing_mm.powi(2);
        let most = |set: &Indicator| self.greatest_layer(set, |_| 1.0) * area;
        let density = self.voids.solid.density.field().values();
        let value = self.greatest_layer(&b.walled, |at| 1.0 - f64::from(density[at])) * area;
        Bracket::new(value, most(&b.certain), most(&b.walled))
    }

    /// The greatest sum of a quantity over the samples of one layer.
    fn greatest_layer(&self, set: &Indicator, quantity: impl Fn(usize) -> f64) -> f64 {
        let mut sums = vec![0.0; set.grid().dims()[2]];
        set.iter().for_each(|at| sums[set.grid().index(at)[2]] += quantity(at));
        sums.into_iter().fold(0.0, f64::max)
    }

    /// A vent at the bottom of a cup, with what the cup still closes once it is there.
    fn vented(&self, at: Vec3, widest: f64) -> Result<String> {
        let solid = self.voids.solid;
        let Some(vent) = shortest_vent(solid, at, VENT, Some(0.0)) else {
            return Ok(format!("give it a hole of at least {} mm near the plate", short(VENT)));
        };
        let outer = drilled(&solid.outer, &[vent]);
        let left = retained(&outer.complement(), Falls::Down, Passage::Faces)?;
        let parts = components(&left, Adjacency::Corner);
        let (lo, hi) = (at, vent.to);
        let near = |b: &[[usize; 3]; 2]| {
            let (p, q) = (outer.grid().position(b[0]), outer.grid().position(b[1]));
            (0..3).all(|a| p[a] <= lo[a].max(hi[a]) && lo[a].min(hi[a]) <= q[a])
        };
        let boxes = parts.boxes();
        let still = (0..parts.count()).filter(|&l| near(&boxes[l])).map(|l| {
            let set = parts.select(|m| m as usize == l);
            self.greatest_layer(&set, |_| 1.0) * self.context.spacing_mm.powi(2)
        });
        let still = still.fold(0.0, f64::max);
        Ok(if still <= widest {
            format!("drill {}; measured again, {} mm² stay closed", vent.words(), short(still.round()))
        } else {
            format!(
                "give it a hole of at least {} mm near the plate; one straight vent leaves {} mm² closed",
                short(VENT),
                short(still.round())
            )
        })
    }

    /// The best of the other 25 directions of a cube, in words, with the volume kept then: all are looked at on a coarse grid, the
    /// most promising on the grid of the part.
    fn best_tilt(&self) -> Result<(String, f64)> {
        let solid = self.voids.solid;
        let mut outer = solid.outer.clone();
        while outer.grid().dims().into_iter().max().unwrap_or(0) > COARSE {
            outer = coarsened_any(&outer)?;
        }
        let void = outer.window([-1; 3], outer.grid().dims().map(|n| n + 2))?.complement();
        let directions = (0..27i32).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1].map(f64::from));
        let directions = directions.filter(|d| *d != [0.0; 3] && *d != [0.0, 0.0, 1.0]).map(unit);
        let mut tilts: Vec<(u64, Vec3)> = directions.map(|d| (retained_towards(&void, d).count(), d)).collect();
        // Of equal ones the least tilt.
        tilts.sort_by(|a, b| a.0.cmp(&b.0).then(b.1[2].total_cmp(&a.1[2])));
        tilts.truncate(MEASURED_TILTS);
        let free = solid.outer.complement();
        let none = Indicator::empty(*free.grid());
        let measured = tilts.into_par_iter().map(|(_, d)| {
            let (basins, _) = self.parted(&retained_towards(&free, d), &none)?;
            Ok((basins.iter().map(|b| b.volume).sum::<f64>(), d))
        });
        let measured: Result<Vec<(f64, Vec3)>> = measured.collect();
        let best = measured?.into_iter().min_by(|a, b| a.0.total_cmp(&b.0).then(b.1[2].total_cmp(&a.1[2])));
        let (left, [x, y, z]) = best.unwrap_or((f64::INFINITY, [0.0, 0.0, -1.0]));
        let angle = z.clamp(-1.0, 1.0).acos().to_degrees().round();
        let towards = format!("{}{}", sign("x", x), sign("y", y));
        let words = if towards.is_empty() {
            format!("turn it by {angle}°")
        } else {
            format!("tilt it by {angle}° so that {towards} points down")
        };
        Ok((words, left))
    }

    fn worst(&mut self, bracket: Bracket, unit: &'static str, at: Option<Vec3>, rule: &'static str) {
        let m = &mut self.measured;
        if m.worst.is_none() || (rule == "drain" && bracket.value > 0.0) {
            m.worst = Some(Worst { bracket, unit, at });
            m.rule = Some(rule);
        }
    }

    fn show(&mut self, set: &Indicator) -> Result<()> {
        let shape = surface(set, |_| 0.5)?;
        self.mesh = std::mem::take(&mut self.mesh).joined(&shape);
        Ok(())
    }

    fn finish(&mut self) {
        let m = &mut self.measured;
        let h = short(self.context.spacing_mm);
        m.cover = format!("Every layer of a grid of {h} mm was flooded, with the plate above and below.");
        if self.small > 0 {
            m.cover.push_str(&format!(" {} samples lie in basins too small to tell.", self.small));
        }
        if !self.mesh.triangles.is_empty() {
            let mesh = std::mem::take(&mut self.mesh);
            m.shapes.push(ShapeShown { name: "liquid", title: "Liquid kept, and cups".into(), mesh });
        }
    }
}

fn sign(axis: &str, c: f64) -> String {
    if c == 0.0 { String::new() } else { format!("{}{axis}", if c > 0.0 { '+' } else { '-' }) }
}
