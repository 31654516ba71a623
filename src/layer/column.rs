//! Volume under downward surface, integrated over columns with bounds.

use super::clip::Polygon;
use super::ground::Carried;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use rayon::prelude::*;

/// What lies straight below a set of facets, between them and the part or the plate.
///
/// Each pair is a lower and an upper bound; they are equal to rounding wherever no silhouette of the part falls into a column
/// together with another surface below it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SupportVolume {
    /// Volume of the columns, mm³.
    pub volume_mm3: [f64; 2],
    /// Area of the columns' feet on the plate, mm².
    pub on_plate_mm2: [f64; 2],
    /// Area of the columns' feet on the part, seen from above, mm².
    pub on_part_mm2: [f64; 2],
    /// Area of the facets seen from below, mm²: exact.
    pub shadow_mm2: f64,
}

/// The class of pieces through which a line from above enters the part; those of wanted facets have the number of their group.
const ENTRY: u32 = u32::MAX;
/// The class of pieces through which it leaves the part and that need no support.
const FREE: u32 = u32::MAX - 1;

/// A facet over one column: the area of its shadow, ∫ z over it, and its heights.
#[derive(Debug, Clone, Copy)]
struct Piece {
    cell: u32,
    class: u32,
    area: f64,
    moment: f64,
    low: f64,
    high: f64,
}

impl Piece {
    /// What it does to a line where one group is wanted: 0 leave through wanted surface, 1 through other, 2 enter.
    fn role(&self, group: u32) -> usize {
        match self.class {
            ENTRY => 2,
            class => usize::from(class != group),
        }
    }
}

/// The volume between `wanted` facets and the first of the part, or the plate, below them.
///
/// With the shadow D of the wanted facets, V = ∫_D (z_D − z_below) dA over all their sheets. The plane is cut into square
/// columns of side `column_mm` and every facet is clipped to them exactly. Walking down a column, let s, u ≥ 0 be lower bounds of the
/// area of the lines that are below a wanted facet, or in the open but not below one; N, U, O(z) the areas of wanted, other downward
/// and upward surface met above z. A line changes from s or u only by entering the part, so s ≥ s₀ + N − O and u ≥ u₀ + U − O;
/// what is not solid and not u is at most s. All integrals over z are moments of the pieces, so the bounds are equal where
/// only one of the classes is present. `bounding` says which facets bound the solid; the bounds hold if those are closed and
/// do not cross each other.
///
/// # Cost
/// O(facets + pieces·log), where a facet has one piece for each column that it shades; 40 bytes a piece.
pub fn support_volume(
    mesh: &TriangleMesh,
    bounding: impl Fn(usize) -> bool + Sync,
    wanted: &[u32],
    plate_z: f64,
    column_mm: f64,
) -> SupportVolume {
    let groups = [wanted];
    support_volumes(mesh, bounding, &groups, plate_z, column_mm).into_iter().next().unwrap_or_default()
}

/// As [`support_volume`] for each of several groups of facets that have none in common: what lies below one group down to the
/// part, whatever else is above it. The truths add up to that of all facets together.
///
/// # Cost
/// As for all facets at once, and a walk for each group in a column.
pub fn support_volumes(
    mesh: &TriangleMesh,
    bounding: impl Fn(usize) -> bool + Sync,
    groups: &[&[u32]],
    plate_z: f64,
    column_mm: f64,
) -> Vec<SupportVolume> {
    let mut totals = vec![SupportVolume::default(); groups.len()];
    let Some((lo, hi)) = mesh.bounds() else { return totals };
    let columns = Columns::over(lo, hi, column_mm);
    let mut class = vec![FREE; mesh.triangles.len()];
    for (group, facets) in (0..FREE).zip(groups) {
        for &f in facets.iter() {
            class[f as usize] = group;
        }
    }
    let mut cut = columns.pieces(mesh, |f| class[f] < FREE, |f| class[f], None);
    // What passes no wanted piece changes nothing.
    let mut asked = vec![false; columns.counts[0] * columns.counts[1]];
    cut.iter().flatten().for_each(|p| asked[p.cell as usize] |= p.class < FREE);
    cut.extend(columns.pieces(mesh, |f| bounding(f) && class[f] == FREE, |_| FREE, Some(&asked)));
    let (starts, pieces) = columns.ordered(&cut);
    let rows: Vec<Vec<(u32, SupportVolume)>> = (0..columns.counts[1])
        .into_par_iter()
        .with_max_len(4)
        .map_init(Default::default, |(order, here): &mut (Vec<Piece>, Vec<u32>), row| {
            let mut found: Vec<(u32, SupportVolume)> = Vec::new();
            for cell in row * columns.counts[0]..(row + 1) * columns.counts[0] {
                let of_cell = &pieces[starts[cell] as usize..starts[cell + 1] as usize];
                here.clear();
                here.extend(of_cell.iter().map(|p| p.class).filter(|&c| c < FREE));
                here.sort_unstable();
                here.dedup();
                for &group in here.iter() {
                    order.clear();
                    order.extend_from_slice(of_cell);
                    let below = walk(order, group, columns.side * columns.side, plate_z);
                    match found.iter_mut().rev().find(|(g, _)| *g == group) {
                        Some((_, sum)) => sum.add(&below),
                        None => found.push((group, below)),
                    }
                }
            }
            found
        })
        .collect();
    rows.iter().flatten().for_each(|(group, row)| totals[*group as usize].add(row));
    totals
}

/// Area of the part's shadow on the plate, mm²: lower and upper bound.
///
/// In a column the shadow is at least the area that is solid at some height, and at most the area of all upward surface.
/// `bounding` says which facets bound the solid.
///
/// # Cost
/// As [`support_volume`].
pub fn shadow_area(mesh: &TriangleMesh, bounding: impl Fn(usize) -> bool + Sync, column_mm: f64) -> [f64; 2] {
    let Some((lo, hi)) = mesh.bounds() else { return [0.0; 2] };
    let columns = Columns::over(lo, hi, column_mm);
    let section = columns.side * columns.side;
    let (starts, mut pieces) = columns.ordered(&columns.pieces(mesh, bounding, |_| FREE, None));
    let mut total = [0.0; 2];
    for cell in starts.windows(2) {
        let of_cell = &mut pieces[cell[0] as usize..cell[1] as usize];
        of_cell.sort_by(|a, b| b.high.total_cmp(&a.high).then(b.low.total_cmp(&a.low)));
        let (mut solid, mut most, mut above, mut entries) = (0.0f64, 0.0f64, f64::INFINITY, 0.0);
        for p in of_cell.iter() {
            // Only between pieces is the solid area the sum of what was met.
            if p.high <= above {
                most = most.max(solid);
            }
            above = above.min(p.low);
            match p.class {
                ENTRY => {
                    solid += p.area;
                    entries += p.area;
                }
                _ => solid -= p.area,
            }
        }
        total[0] += most.clamp(0.0, section);
        total[1] += entries.clamp(most.min(section), section);
    }
    total
}

impl SupportVolume {
    fn add(&mut self, other: &SupportVolume) {
        let plus = |a: &mut [f64; 2], b: &[f64; 2]| (0..2).for_each(|e| a[e] += b[e]);
        plus(&mut self.volume_mm3, &other.volume_mm3);
        plus(&mut self.on_plate_mm2, &other.on_plate_mm2);
        plus(&mut self.on_part_mm2, &other.on_part_mm2);
        self.shadow_mm2 += other.shadow_mm2;
    }

    /// Without what lies on the plate or rests on material no more than a layer below: there is no support between them.
    pub(super) fn without(self, carried: &Carried, layer_mm: f64) -> Self {
        let less = |bounds: [f64; 2], by: f64| bounds.map(|bound| (bound - by).max(0.0));
        let [lying_mm2, lying_mm3] = carried.lying;
        let [low, high] = less(self.volume_mm3, lying_mm3);
        SupportVolume {
            // How far below the surface lies on which it rests is not known.
            volume_mm3: [(low - carried.resting_mm2 * layer_mm).max(0.0), high],
            on_plate_mm2: less(self.on_plate_mm2, lying_mm2),
            on_part_mm2: less(self.on_part_mm2, carried.resting_mm2),
            ..self
        }
    }

    /// The same where only what takes `least` is certain.
    pub(super) fn down_to(self, least: &SupportVolume) -> Self {
        let low = |own: [f64; 2], least: [f64; 2]| [own[0].min(least[0]), own[1]];
        SupportVolume {
            volume_mm3: low(self.volume_mm3, least.volume_mm3),
            on_plate_mm2: low(self.on_plate_mm2, least.on_plate_mm2),
            on_part_mm2: low(self.on_part_mm2, least.on_part_mm2),
            ..self
        }
    }

    /// Whether nothing hangs over.
    pub fn is_empty(&self) -> bool {
        self.shadow_mm2 == 0.0
    }
}

/// One column from above: bounds of volume and feet below its pieces of one group.
fn walk(pieces: &mut [Piece], group: u32, section: f64, plate_z: f64) -> SupportVolume {
    pieces.sort_by(|a, b| {
        b.high.total_cmp(&a.high).then(b.low.total_cmp(&a.low)).then(a.role(group).cmp(&b.role(group)))
    });
    let (mut solid, mut held, mut open) = (0.0f64, 0.0f64, section);
    let mut volume = [0.0; 2];
    let mut shadow = 0.0;
    let mut from = pieces.first().map_or(plate_z, |p| p.high);
    let mut at = 0;
    while at < pieces.len() {
        // Pieces whose heights overlap are met together.
        let (high, mut low, first) = (pieces[at].high, pieces[at].low, at);
        while at < pieces.len() && (pieces[at].high > low || at == first) {
            low = low.min(pieces[at].low);
            at += 1;
        }
        let mut area = [0.0; 3];
        // ∫ of the area met above z, from the lowest point of the group to its highest.
        let mut below = [0.0; 3];
        for p in &pieces[first..at] {
            area[p.role(group)] += p.area;
            below[p.role(group)] += p.moment - p.area * low;
        }
        let [wanted, free, entry] = area;
        let most = (section - solid - open).max(held);
        let (gap, depth) = (from - high, high - low);
        volume[0] += held * gap + (held * depth + below[0] - below[2]).max(0.0);
        let void = (section - solid) * depth + below[0] + below[1] - below[2];
        let opened = (open * depth + below[1] - below[2]).max(0.0);
        volume[1] += most * gap + (most * depth + below[0]).min(void - opened).max(0.0);
        held = (held + wanted - entry).max(0.0);
        open = (open + free - entry).max(0.0);
        solid = (solid + entry - wanted - free).clamp(0.0, section);
        shadow += wanted;
        from = low;
    }
    let most = (section - solid - open).max(held).min(shadow);
    let gap = (from - plate_z).max(0.0);
    volume[0] += held * gap;
    volume[1] = (volume[1] + most * gap).max(volume[0]);
    SupportVolume {
        volume_mm3: volume,
        on_plate_mm2: [held.min(shadow), most],
        on_part_mm2: [shadow - most, shadow - held.min(shadow)],
        shadow_mm2: shadow,
    }
}

/// Square columns over a box.
struct Columns {
    origin: [f64; 2],
    side: f64,
    counts: [usize; 2],
}

impl Columns {
    /// Columns of a side, wider where there would be more than sixteen million; the box lies centred in them.
    fn over(lo: Vec3, hi: Vec3, side: f64) -> Self {
        let extent = [hi[0] - lo[0], hi[1] - lo[1]];
        let least = extent[0].max(extent[1]) / 4096.0;
        let side = if side > least && side.is_finite() { side } else { least.max(f64::MIN_POSITIVE) };
        let counts = extent.map(|e| (e / side).ceil() as usize + 1);
        let origin = [0, 1].map(|a| lo[a] - 0.5 * (counts[a] as f64 * side - extent[a]));
        Columns { origin, side, counts }
    }

    /// The pieces of some facets, in chunks of the facets in order; those of facets that look down are of the class `down`
    /// gives them. Only columns that are `asked` for get any.
    fn pieces(
        &self,
        mesh: &TriangleMesh,
        of: impl Fn(usize) -> bool + Sync,
        down: impl Fn(usize) -> u32 + Sync,
        asked: Option<&[bool]>,
    ) -> Vec<Vec<Piece>> {
        const CHUNK: usize = 2048;
        let facets = mesh.triangles.len();
        (0..facets.div_ceil(CHUNK))
            .into_par_iter()
            .with_max_len(1)
            .map(|chunk| {
                let mut pieces = Vec::new();
                for f in (chunk * CHUNK..((chunk + 1) * CHUNK).min(facets)).filter(|&f| of(f)) {
                    self.cut(mesh.corners(f), down(f), asked, &mut pieces);
                }
                pieces
            })
            .collect()
    }

    /// Pieces ordered by column, with the place where each column starts.
    fn ordered(&self, cut: &[Vec<Piece>]) -> (Vec<u32>, Vec<Piece>) {
        let mut starts = vec![0u32; self.counts[0] * self.counts[1] + 1];
        cut.iter().flatten().for_each(|p| starts[p.cell as usize + 1] += 1);
        for c in 1..starts.len() {
            starts[c] += starts[c - 1];
        }
        let blank = Piece { cell: 0, class: FREE, area: 0.0, moment: 0.0, low: 0.0, high: 0.0 };
        let mut sorted = vec![blank; starts.last().map_or(0, |&n| n as usize)];
        let mut next = starts.clone();
        for p in cut.iter().flatten() {
            sorted[next[p.cell as usize] as usize] = *p;
            next[p.cell as usize] += 1;
        }
        (starts, sorted)
    }

    /// The pieces of one facet.
    fn cut(&self, corners: [Vec3; 3], down: u32, asked: Option<&[bool]>, pieces: &mut Vec<Piece>) {
        let mut whole = Polygon::default();
        for p in corners {
            whole.push([(p[0] - self.origin[0]) / self.side, (p[1] - self.origin[1]) / self.side, p[2]]);
        }
        let signed = whole.area();
        if signed == 0.0 || !signed.is_finite() {
            return;
        }
        let class = if signed > 0.0 { ENTRY } else { down };
        let is_asked = |i: usize, j: usize| asked.is_none_or(|a| a[j * self.counts[0] + i]);
        let [across, deep] = [0, 1].map(|axis| whole.slices(axis, self.counts[axis]));
        if !deep.into_iter().any(|j| across.clone().any(|i| is_asked(i, j))) {
            return;
        }
        whole.each_slice(1, self.counts[1], |j, row| {
            row.each_slice(0, self.counts[0], |i, piece| {
                if !is_asked(i, j) {
                    return;
                }
                let area = piece.area().abs() * self.side * self.side;
                if area > 0.0 {
                    let (low, high) = piece.span(2);
                    let mean = piece.mean_height().clamp(low, high);
                    let cell = (j * self.counts[0] + i) as u32;
                    pieces.push(Piece { cell, class, area, moment: area * mean, low, high });
                }
            });
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::layer::downward_facets;
    use crate::random::Lcg;
    use crate::units::Angle;

    fn about_z(mesh: &TriangleMesh, turn: f64, shift: Vec3) -> TriangleMesh {
        let (s, c) = turn.sin_cos();
        mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], shift)
    }

    fn tilted(mesh: &TriangleMesh, degrees: f64) -> TriangleMesh {
        let (s, c) = degrees.to_radians().sin_cos();
        mesh.transformed([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]], [0.0; 3])
    }

    /// A ball of facets, and what lies below its cap to the plate it rests on.
    fn ball(radius: f64, rings: usize) -> TriangleMesh {
        let point = |i: usize, j: usize| {
            let (lat, lon) =
                (std::f64::consts::PI * i as f64 / rings as f64, std::f64::consts::PI * j as f64 / rings as f64);
            if i == 0 || i == rings {
                return [0.0, 0.0, radius * lat.cos() + radius];
            }
            [radius * lat.sin() * lon.cos(), radius * lat.sin() * lon.sin(), radius * lat.cos() + radius]
        };
        let mut facets = Vec::new();
        for i in 0..rings {
            for j in 0..2 * rings {
                let next = (j + 1) % (2 * rings);
                let (a, b, c, d) = (point(i, j), point(i + 1, j), point(i + 1, next), point(i, next));
                if i + 1 < rings {
                    facets.push([a, b, c]);
                }
                if i > 0 {
                    facets.push([a, c, d]);
                }
            }
        }
        TriangleMesh::weld(facets)
    }

    fn measured(mesh: &TriangleMesh, side: f64) -> SupportVolume {
        let wanted = downward_facets(mesh, 0.0, Angle::degrees(45.0), 1e-9);
        support_volume(mesh, |_| true, &wanted, 0.0, side)
    }

    /// Asserts that the truth lies in a bracket, rounding aside.
    fn holds(bracket: [f64; 2], truth: f64, what: &str) {
        let tie = 1e-9 * truth.abs().max(1.0);
        assert!(bracket[0] - tie <= truth && truth <= bracket[1] + tie, "{what}: {truth} not in {bracket:?}");
    }

    #[test]
    fn the_truth_is_in_the_bracket_wherever_the_part_stands() {
        let mut rng = Lcg(11);
        // A shelf of 10 × 6 mm, 5 mm above a floor of 1 mm that reaches under half of it.
        let wall = cuboid([-1.0, 0.0, 0.0], [0.0, 6.0, 8.0]);
        for _ in 0..300 {
            let (turn, side) = (std::f64::consts::TAU * rng.unit(), 0.1 + 0.6 * rng.unit());
            let shift = [rng.unit(), rng.unit(), 0.0];
            let floor = cuboid([0.5, -1.0, 0.0], [5.0, 7.0, 1.0]);
            let shelf = cuboid([0.5, 0.0, 6.0], [10.5, 6.0, 7.0]);
            let part = about_z(&wall.clone().joined(&floor).joined(&shelf), turn, shift);
            let found = measured(&part, side);
            holds(found.volume_mm3, 6.0 * (4.5 * 5.0 + 5.5 * 6.0), "shelf");
            holds(found.on_plate_mm2, 33.0, "feet on the plate");
            holds(found.on_part_mm2, 27.0, "feet on the part");
            holds([found.shadow_mm2; 2], 60.0, "area from below");
            let shadow = shadow_area(&part, |_| true, side);
            // Wall 6, floor 36 of which 27 lie under the shelf, shelf 60 mm².
            holds(shadow, 6.0 + 36.0 + 60.0 - 27.0, "shadow");
            assert!(shadow[1] - shadow[0] <= 0.1 + 2.0 * side * 2.0 * 60.0, "{side}: {shadow:?}");
            // Only columns with the floor's silhouette, 6 mm of it, and the shelf's, 32 mm, can be open.
            let open = 6.0 * side * 2.0 * (8.0 + 2.0 * 32.0);
            assert!(found.volume_mm3[1] - found.volume_mm3[0] <= open, "{side}: {found:?}");
        }
    }

    #[test]
    fn slopes_and_curves_are_integrated_exactly() {
        let mut rng = Lcg(5);
        for _ in 0..40 {
            let side = 0.1 + 0.7 * rng.unit();
            let turn = std::f64::consts::TAU * rng.unit();
            // A plate tilted by less than 45° hangs over with its underside and one end.
            let degrees = 2.0 + 40.0 * rng.unit();
            let plate = tilted(&cuboid([0.0, 0.0, 0.0], [9.0, 4.0, 1.0]), degrees);
            let lift = 2.0 - plate.bounds().unwrap().0[2];
            let plate = about_z(&plate, turn, [rng.unit(), rng.unit(), lift]);
            let (s, c) = degrees.to_radians().sin_cos();
            let found = measured(&plate, side);
            holds(found.volume_mm3, 9.0 * c * 4.0 * (2.0 + 0.5 * 9.0 * s), "tilted plate");
            assert!(found.on_part_mm2[1] <= 1e-9 + 4.0 * side * 14.0);
            // A ball on the plate: the region below its cap, between the facets and the plate.
            let ball = about_z(&ball(5.0, 40), turn, [rng.unit(), rng.unit(), 0.0]);
            let wanted = downward_facets(&ball, 0.0, Angle::degrees(45.0), 1e-9);
            let truth: f64 = wanted
                .iter()
                .map(|&f| {
                    let v = ball.area_vector(f as usize);
                    -0.5 * v[2] * ball.centroid(f as usize)[2]
                })
                .sum();
            let found = support_volume(&ball, |_| true, &wanted, 0.0, side);
            holds(found.volume_mm3, truth, "ball");
            // Closed form of the smooth ball: ∫ (R − √(R² − ρ²)) 2πρ dρ up to 45°; facets of 4.5° are off by a percent.
            let r: f64 = 5.0;
            let t = r * 45f64.to_radians().sin();
            let smooth = std::f64::consts::PI * (r * t * t - 2.0 / 3.0 * (r.powi(3) - (r * r - t * t).powf(1.5)));
            assert!((truth / smooth - 1.0).abs() < 0.12, "{truth} {smooth}");
            assert!(found.volume_mm3[1] - found.volume_mm3[0] < 0.02 * truth + 1e-9, "{found:?}");
        }
    }

    #[test]
    fn many_bodies_above_each_other_stay_in_the_bracket() {
        let mut rng = Lcg(3);
        for round in 0..60 {
            let plates = 2 + round % 4;
            let mut part = TriangleMesh::default();
            let mut boxes = Vec::new();
            for level in 0..plates {
                let lo = [4.0 * rng.unit(), 4.0 * rng.unit(), 1.0 + 3.0 * level as f64 + rng.unit()];
                let hi = [lo[0] + 1.0 + 5.0 * rng.unit(), lo[1] + 1.0 + 5.0 * rng.unit(), lo[2] + 0.3 + rng.unit()];
                part = part.joined(&cuboid(lo, hi));
                boxes.push((lo, hi));
            }
            let side = 0.05 + 0.5 * rng.unit();
            let found = measured(&part, side);
            // Exact by the cells between all box sides.
            let cuts = |axis: usize| {
                let mut cuts: Vec<f64> = boxes.iter().flat_map(|(lo, hi)| [lo[axis], hi[axis]]).collect();
                cuts.sort_by(f64::total_cmp);
                cuts
            };
            let mut truth = 0.0;
            for x in cuts(0).windows(2) {
                for y in cuts(1).windows(2) {
                    let mut floor = 0.0;
                    for (lo, hi) in &boxes {
                        let over = lo[0] <= x[0] && x[1] <= hi[0] && lo[1] <= y[0] && y[1] <= hi[1];
                        if over {
                            truth += (lo[2] - floor) * (x[1] - x[0]) * (y[1] - y[0]);
                            floor = hi[2];
                        }
                    }
                }
            }
            holds(found.volume_mm3, truth, "plates");
            // Each plate by itself: what lies below it down to the next one or the plate of the machine.
            let wanted = downward_facets(&part, 0.0, Angle::degrees(45.0), 1e-9);
            let own: Vec<Vec<u32>> =
                (0..plates as u32).map(|n| wanted.iter().copied().filter(|f| f / 12 == n).collect()).collect();
            let own: Vec<&[u32]> = own.iter().map(Vec::as_slice).collect();
            let each = support_volumes(&part, |_| true, &own, 0.0, side);
            let sum = |end: usize| each.iter().map(|e| e.volume_mm3[end]).sum::<f64>();
            holds([sum(0), sum(1)], truth, "plates one by one");
            let areas = boxes.iter().map(|(lo, hi)| (hi[0] - lo[0]) * (hi[1] - lo[1]));
            for (e, area) in each.iter().zip(areas) {
                holds([e.shadow_mm2; 2], area, "area of a plate");
            }
            holds(each[0].volume_mm3, (boxes[0].0[2]) * each[0].shadow_mm2, "the lowest plate");
            assert!(
                found.volume_mm3[1] - found.volume_mm3[0] <= 0.05 * truth + 60.0 * side * truth.sqrt(),
                "{found:?}"
            );
        }
    }
}
