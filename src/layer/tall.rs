//! Features that stand tall on little: height over least width, from the top down.

use super::section::{Point, section_points};
use crate::field::Indicator;
use crate::geometry::vector::Vec3;
use crate::geometry::{DisjointSets, Hull, TriangleMesh};

/// A piece of the part above some layer, and the section it stands on.
#[derive(Debug, Clone, PartialEq)]
pub struct TallFeature {
    /// Height of its top above the section, mm.
    pub height_mm: f64,
    /// Least and greatest width of the section's convex hull, mm.
    pub width_mm: (f64, f64),
    /// Middle of the section.
    pub foot: Vec3,
    /// Box of section and top.
    pub extent: (Vec3, Vec3),
}

impl TallFeature {
    /// Height over least width.
    pub fn slenderness(&self) -> f64 {
        self.height_mm / self.width_mm.0
    }
}

/// Heights below a pillar's lowest layer that are tried as its foot.
const STARTS: usize = 8;

/// A stretch of samples of one layer.
#[derive(Debug, Clone, Copy)]
struct Run {
    j: u32,
    from: u32,
    to: u32,
    set: u32,
}

/// What is known of a set of material above a layer.
#[derive(Debug, Clone, Copy)]
struct Set {
    /// Layer of its top, and a box of that layer's samples.
    top: u32,
    top_box: [u32; 4],
    /// The most slender section since it last joined another set.
    best: Option<Candidate>,
}

/// The sets met so far, and what was each at its best when it joined another.
#[derive(Default)]
struct Pillars {
    joined: DisjointSets,
    sets: Vec<Set>,
    found: Vec<Candidate>,
}

#[derive(Debug, Clone, Copy)]
struct Candidate {
    slenderness: f64,
    layer: u32,
    /// Box of the section's samples: i from, i to, j from, j to.
    section: [u32; 4],
    top: u32,
    top_box: [u32; 4],
}

/// The features whose height is more than `least` times the least width of a section that carries them.
///
/// Let C be a connected component of the samples inside at or above layer k, with top t and section C_k in layer k; its
/// slenderness at k is (t − z_k) / w(C_k) with w the least width of the convex hull of C_k. Components are followed from the top
/// down; each is reported once, at its most slender layer, when it joins another or ends. Sections longer than `longest_ratio` times
/// their least width are walls and not looked at. Samples find the places; height and widths are then taken from the mesh.
/// No layer below the height `lowest` is looked at: a part that stands on a point or a round side is not slender for that. A pillar as
/// narrow further down begins there.
/// A feature thinner than the spacing may be missed, so the result is an estimate.
///
/// # Cost
/// O(samples/64 + runs·log).
pub fn tall_features(
    centres: &Indicator,
    mesh: &TriangleMesh,
    least: f64,
    longest_ratio: f64,
    lowest: f64,
) -> Vec<TallFeature> {
    let [nx, ny, nz] = centres.grid().dims();
    let h = centres.grid().h();
    let mut pillars = Pillars::default();
    let mut above: Vec<Run> = Vec::new();
    for k in (0..nz).rev() {
        let mut runs = runs_of_layer(centres, k, nx, ny);
        pillars.settle(&mut runs, &above, k as u32);
        let looked_at = if centres.grid().origin()[2] + k as f64 * h >= lowest { sections(&runs) } else { Vec::new() };
        for (set, section) in looked_at {
            let s = &mut pillars.sets[set as usize];
            let height = f64::from(s.top - k as u32) * h;
            // No width is less than this one or the hull of the runs would be thinner than a sample.
            let quick = height / h;
            if quick <= least.max(s.best.map_or(0.0, |b| b.slenderness)) {
                continue;
            }
            let hull = Hull::of(section.iter().flat_map(|r| corners_of(r, h)));
            let (narrow, wide) = hull.widths();
            let slenderness = height / narrow;
            // A sample more or less at each side decides nothing here; the mesh does.
            if wide <= longest_ratio * narrow + 2.0 * h && s.best.is_none_or(|b| slenderness > b.slenderness) {
                let section = box_of(&section);
                s.best = Some(Candidate { slenderness, layer: k as u32, section, top: s.top, top_box: s.top_box });
            }
        }
        above = runs;
    }
    let Pillars { mut joined, sets, mut found } = pillars;
    found.extend((0u32..).zip(sets).filter(|(s, _)| joined.root(*s) == *s).filter_map(|(_, set)| set.best));
    found
        .into_iter()
        .filter(|c| 2.0 * c.slenderness + 2.0 > least)
        .filter_map(|c| on_the_mesh(&c, centres, mesh, lowest))
        .filter(|f| f.slenderness() > least && f.width_mm.1 <= longest_ratio * f.width_mm.0 * std::f64::consts::SQRT_2)
        .collect()
}

fn runs_of_layer(centres: &Indicator, k: usize, nx: usize, ny: usize) -> Vec<Run> {
    let mut runs = Vec::new();
    for j in 0..ny {
        let mut open: Option<u32> = None;
        let row = centres.row(j, k);
        if row.iter().all(|&w| w == 0) {
            continue;
        }
        for i in 0..=nx {
            let inside = i < nx && row[i / 64] >> (i % 64) & 1 == 1;
            match (inside, open) {
                (true, None) => open = Some(i as u32),
                (false, Some(from)) => {
                    runs.push(Run { j: j as u32, from, to: i as u32, set: u32::MAX });
                    open = None;
                }
                _ => {}
            }
        }
    }
    runs
}

impl Pillars {
    /// Gives every run of a layer its set, joining those that touch in the layer or from above.
    fn settle(&mut self, runs: &mut [Run], above: &[Run], layer: u32) {
        let mut upper = 0;
        for run in runs.iter_mut() {
            while upper < above.len() && (above[upper].j, above[upper].to) <= (run.j, run.from) {
                upper += 1;
            }
            let mut set = None;
            for other in above[upper..].iter().take_while(|o| o.j == run.j && o.from < run.to) {
                set = Some(self.join(set, other.set, layer));
            }
            run.set = set.unwrap_or_else(|| {
                let top_box = [run.from, run.to, run.j, run.j + 1];
                self.sets.push(Set { top: layer, top_box, best: None });
                self.joined.grow()
            });
        }
        // Runs of neighbouring rows of the same layer.
        let mut before = 0;
        for at in 0..runs.len() {
            let run = runs[at];
            while runs[before].j + 1 < run.j || (runs[before].j + 1 == run.j && runs[before].to < run.from) {
                before += 1;
            }
            let mut other = before;
            while other < at && runs[other].j + 1 == run.j && runs[other].from <= run.to {
                let set = self.join(Some(run.set), runs[other].set, layer);
                runs[at].set = set;
                other += 1;
            }
        }
        for run in runs.iter_mut() {
            run.set = self.joined.root(run.set);
        }
    }

    /// Joins a set with another; where both are old, what each was at its best is kept and the union starts anew.
    fn join(&mut self, one: Option<u32>, other: u32, layer: u32) -> u32 {
        let b = self.joined.root(other);
        let Some(a) = one.map(|s| self.joined.root(s)) else { return b };
        if a == b {
            return a;
        }
        let (keep, lose) = (a.min(b), a.max(b));
        let (x, y) = (self.sets[keep as usize], self.sets[lose as usize]);
        let union = match (x.top == layer, y.top == layer) {
            // Pieces that begin in this layer are no features of their own.
            (true, false) => y,
            (false, true) => x,
            (true, true) => Set { top_box: hull_of(x.top_box, y.top_box), ..x },
            (false, false) => {
                self.found.extend(x.best);
                self.found.extend(y.best);
                let higher = if y.top > x.top { y } else { x };
                Set { best: None, ..higher }
            }
        };
        self.sets[keep as usize] = union;
        self.joined.join(keep, lose)
    }
}

fn hull_of(a: [u32; 4], b: [u32; 4]) -> [u32; 4] {
    [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
}

/// The runs of each set, in the order of the sets' first runs.
fn sections(runs: &[Run]) -> Vec<(u32, Vec<Run>)> {
    let mut order: Vec<Run> = runs.to_vec();
    order.sort_by_key(|r| (r.set, r.j, r.from));
    order.chunk_by(|a, b| a.set == b.set).map(|c| (c[0].set, c.to_vec())).collect()
}

fn box_of(runs: &[Run]) -> [u32; 4] {
    runs.iter().map(|r| [r.from, r.to, r.j, r.j + 1]).reduce(hull_of).unwrap_or_default()
}

/// Corners of a run's rectangle, in millimetres about the first sample's cube.
fn corners_of(r: &Run, h: f64) -> [Point; 4] {
    let (x0, x1, y0, y1) = (f64::from(r.from) * h, f64::from(r.to) * h, f64::from(r.j) * h, f64::from(r.j + 1) * h);
    [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
}

/// Height and widths of a candidate from the mesh: the section at its layer, the highest vertex about its top.
fn on_the_mesh(c: &Candidate, centres: &Indicator, mesh: &TriangleMesh, lowest: f64) -> Option<TallFeature> {
    let grid = centres.grid();
    let h = grid.h();
    let side = |at: u32, axis: usize| grid.origin()[axis] + (f64::from(at) - 0.5) * h;
    let within = |b: [u32; 4], p: Point, reach: f64| {
        p[0] > side(b[0], 0) - reach
            && p[0] < side(b[1], 0) + reach
            && p[1] > side(b[2], 1) - reach
            && p[1] < side(b[3], 1) + reach
    };
    // A sample in a facet counts as standing just above it, and so does the section.
    let mut level = grid.origin()[2] + (f64::from(c.layer) + 1e-3) * h;
    let section = |level: f64| Hull::of(section_points(mesh, level).into_iter().filter(|&p| within(c.section, p, h)));
    let hull = section(level);
    let top_layer = grid.origin()[2] + f64::from(c.top) * h;
    let top = mesh
        .vertices
        .iter()
        .filter(|v| v[2] >= top_layer && v[2] < top_layer + 1.001 * h && within(c.top_box, [v[0], v[1]], 1.5 * h))
        .map(|v| v[2])
        .fold(top_layer, f64::max);
    let mut widths = hull.widths();
    if !(widths.0 > 0.0 && widths.0.is_finite()) {
        return None;
    }
    // The pillar begins at a vertex: the lowest height nearby at which it is still as narrow. What no layer was looked at below is near.
    let near = if level - 1.5 * h < lowest { f64::NEG_INFINITY } else { level - 1.5 * h };
    let mut starts: Vec<f64> = mesh
        .vertices
        .iter()
        .filter(|v| v[2] < level && v[2] > near && within(c.section, [v[0], v[1]], h))
        .map(|v| v[2] + 1e-6 * h)
        .collect();
    starts.sort_by(f64::total_cmp);
    starts.dedup();
    let alike = |a: f64, b: f64| a > 0.99 * b && a < 1.01 * b;
    let as_narrow = |w: (f64, f64)| alike(w.0, widths.0) && alike(w.1, widths.1);
    let lowest = starts.into_iter().take(STARTS).map(|z| (z, section(z).widths())).find(|(_, w)| as_narrow(*w));
    if let Some((z, w)) = lowest {
        (level, widths) = (z, w);
    }
    let (x, y) =
        (0.5 * (side(c.section[0], 0) + side(c.section[1], 0)), 0.5 * (side(c.section[2], 1) + side(c.section[3], 1)));
    let spread = hull_of(c.section, c.top_box);
    Some(TallFeature {
        height_mm: top - level,
        width_mm: widths,
        foot: [x, y, level],
        extent: ([side(spread[0], 0), side(spread[2], 1), level], [side(spread[1], 0), side(spread[3], 1), top]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::geometry::{Primitive, occupancy};
    use crate::grid::Grid;
    use crate::units::Length;

    fn found(part: &TriangleMesh, h: f64, phase: f64, least: f64) -> Vec<TallFeature> {
        let (lo, hi) = part.bounds().unwrap();
        let grid = Grid::covering(lo, hi, Length::mm(h), 1, [phase; 3]).unwrap();
        tall_features(&occupancy(part, &grid).unwrap(), part, least, 4.0, f64::NEG_INFINITY)
    }

    #[test]
    fn pillars_on_a_plate_are_found_each_and_a_block_is_not() {
        let plate = cuboid([0.0; 3], [30.0, 20.0, 2.0]);
        // The pillars stand on the plate with a common face; occupancy joins them.
        let part = plate
            .joined(&cuboid([3.0, 3.0, 2.0], [5.0, 5.0, 32.0]))
            .joined(&cuboid([20.0, 10.0, 2.0], [23.0, 12.0, 22.0]))
            .joined(&cuboid([10.0, 10.0, 2.0], [16.0, 16.0, 12.0]));
        for (h, phase) in [(0.5, 0.0), (0.37, 0.2), (0.61, -0.3)] {
            let mut all = found(&part, h, phase, 8.0);
            all.sort_by(|a, b| b.slenderness().total_cmp(&a.slenderness()));
            assert_eq!(all.len(), 2, "{all:?}");
            for (f, (height, width)) in all.iter().zip([(30.0, 2.0), (20.0, 2.0)]) {
                let exact = (f.width_mm.0 - width).abs() < 1e-9 && (f.height_mm - height).abs() < 2e-6 * h;
                assert!(exact, "{f:?}");
            }
        }
        assert!(found(&cuboid([0.0; 3], [20.0; 3]), 0.5, 0.1, 8.0).is_empty());
    }

    #[test]
    fn a_pillar_on_the_plate_is_as_high_as_it_is() {
        let pillar = cuboid([0.0; 3], [2.0, 2.0, 24.0]);
        let grid = Grid::covering([0.0; 3], [2.0, 2.0, 24.0], Length::mm(0.094), 1, [0.0; 3]).unwrap();
        let all = tall_features(&occupancy(&pillar, &grid).unwrap(), &pillar, 8.0, 4.0, 0.15);
        assert!(all.len() == 1 && (all[0].slenderness() - 12.0).abs() < 1e-5, "{all:?}");
    }

    #[test]
    fn a_ball_is_no_pillar_for_standing_on_a_point() {
        let ball = Primitive::parse("ball:10mm").unwrap().mesh(Length::mm(0.002));
        // Layers of samples at 0.05 and 0.3 mm above the bottom: sections 2.0 and 4.9 mm wide.
        let grid = Grid::new([-11.0, -11.0, -11.2], Length::mm(0.25), [89; 3]).unwrap();
        let inside = occupancy(&ball, &grid).unwrap();
        let bottom = ball.bounds().unwrap().0[2];
        let above = |lowest: f64, least: f64| tall_features(&inside, &ball, least, 4.0, bottom + lowest);
        assert!((above(0.0, 8.0)[0].slenderness() - 19.95 / 2.0).abs() < 0.2, "{:?}", above(0.0, 8.0));
        assert!(above(0.1, 8.0).is_empty());
        assert!((above(0.1, 3.0)[0].slenderness() - 19.7 / 4.86).abs() < 0.1, "{:?}", above(0.1, 3.0));
    }

    #[test]
    fn legs_under_a_top_and_walls_are_no_pillars() {
        let legs = [[0.0, 0.0], [18.0, 0.0], [0.0, 18.0], [18.0, 18.0]];
        let table = legs.iter().fold(cuboid([0.0, 0.0, 30.0], [20.0, 20.0, 32.0]), |t, [x, y]| {
            t.joined(&cuboid([*x, *y, 0.0], [x + 2.0, y + 2.0, 30.0]))
        });
        assert!(found(&table, 0.5, 0.1, 8.0).is_empty());
        assert!(found(&cuboid([0.0; 3], [30.0, 1.2, 25.0]), 0.4, 0.1, 8.0).is_empty());
    }
}
