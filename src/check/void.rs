//! The voids of a part: sealed ones, and chambers whose way out is narrow.

use super::enclosed::enclosed;
use super::filling::{Filling, ringed};
use super::finding::{Basis, Bracket};
use crate::distance::squared_distance;
use crate::error::Result;
use crate::field::{Field, Indicator};
use crate::geometry::vector::{Vec3, bounds};
use crate::geometry::{Cavity, Solid, TriangleMesh, cavities};
use crate::grid::Grid;
use crate::part::Part;
use crate::topology::{Adjacency, Chamber, Components, Side, border, chambers, components};
use rayon::prelude::*;

/// Half the diagonal of a sample's cube, in units of the spacing.
pub(super) const HALF_DIAGONAL: f64 = 0.866_025_403_784_438_6;
/// A void that the grid calls closed is looked at only if it holds this many free samples: a ball of two samples' radius.
const LEAST_SAMPLES: u64 = 27;
/// A chamber is at least this much wider than its way out; what is less is a passage of uneven width.
pub(super) const LEAST_RISE: f64 = 1.25;

/// A place from which something cannot get out, or only through a narrow mouth.
#[derive(Debug, Clone)]
pub(super) struct Trapped {
    /// A point inside, about the middle of its widest place.
    pub at: Vec3,
    pub extent: (Vec3, Vec3),
    pub volume_mm3: Bracket,
    pub basis: Basis,
    /// Diameter of the widest way out; 0 where sealed.
    pub way_out_mm: Bracket,
    /// Where the way out is narrowest.
    pub throat: Option<Vec3>,
    /// Its surface.
    pub shape: TriangleMesh,
}

impl Trapped {
    /// Whether the middle of one place lies in the box of the other.
    pub fn overlaps(&self, other: &Trapped) -> bool {
        holds(other.extent, self.at) || holds(self.extent, other.at)
    }
}

/// Whether a point lies in a box.
pub(super) fn holds((lo, hi): (Vec3, Vec3), p: Vec3) -> bool {
    (0..3).all(|c| lo[c] <= p[c] && p[c] <= hi[c])
}

/// Whether a chamber is wider than its way out by more than the grid can make up.
pub(super) fn rises(chamber: &Chamber) -> bool {
    let root = |c: u32| f64::from(c).sqrt();
    root(chamber.widest) > LEAST_RISE * chamber.throat.map_or(0.0, |t| root(t.clearance)) + 2.0 * HALF_DIAGONAL
}

/// Diameter of the widest way out of a chamber, mm, for a spacing of h.
pub(super) fn way_out(chamber: &Chamber, h: f64) -> Bracket {
    let diameter = 2.0 * h * chamber.throat.map_or(0.0, |t| f64::from(t.clearance).sqrt());
    let doubt = 4.0 * h * HALF_DIAGONAL;
    Bracket::new(diameter, (diameter - doubt).max(0.0), diameter + doubt)
}

/// The sealed voids of a part, and those the grid cannot tell from sealed.
#[derive(Debug, Default)]
pub(super) struct Sealed {
    pub certain: Vec<Trapped>,
    pub undecided: Vec<Trapped>,
    /// Free samples in closed nooks too small to be looked at.
    pub nooks: u64,
}

/// What the searches share: the part, its solid and the components of what may be void.
pub(super) struct Voids<'a> {
    part: &'a Part,
    pub solid: &'a Solid,
    pub(super) grid: Grid,
    /// Components of the complement of the inner set, corner to corner: what they part is parted for certain.
    loose: Components,
    closed: Vec<bool>,
    cavities: Vec<crate::geometry::Cavity>,
}

impl<'a> Voids<'a> {
    /// On the part's own grid.
    pub fn of(part: &'a Part) -> Result<Self> {
        Voids::within(part, part.solid()?)
    }

    /// On the grid of a solid of the whole part.
    pub fn within(part: &'a Part, solid: &'a Solid) -> Result<Self> {
        let loose = components(&solid.inner.complement(), Adjacency::Corner);
        let closed = loose.at_border().into_iter().map(|open| !open).collect();
        // A shell that crosses itself bounds other voids than its own.
        let whole = part.is_united() || part.meetings().crossing.count == 0;
        let cavities = if whole { cavities(part.mesh(), part.health(), part.step()) } else { Vec::new() };
        Ok(Voids { part, solid, grid: *solid.inner.grid(), loose, closed, cavities })
    }

    /// How a number that rests on the sets is known.
    pub fn basis(&self) -> Basis {
        if self.part.health().is_solid() { Basis::Certified } else { Basis::Estimated }
    }

    /// The part whose voids they are.
    pub fn part(&self) -> &Part {
        self.part
    }

    /// The spacing of the grid that they are looked at on.
    pub fn spacing_mm(&self) -> f64 {
        self.grid.h()
    }

    fn label(&self, p: Vec3) -> Option<u32> {
        self.grid.sample_at(p).and_then(|index| self.loose.of(index))
    }

    /// Whether a sample lies in a void that is sealed for certain.
    pub fn is_sealed(&self, at: usize) -> bool {
        let index = self.grid.index(at);
        let by_sets = self.loose.of(index).is_some_and(|l| self.closed[l as usize]);
        by_sets || self.cavities.iter().any(|c| c.apart && c.holds(self.grid.position(index)))
    }

    /// Sealed for certain: cavities that a closed shell bounds (exact), and voids parted from the border even in the
    /// complement of the inner set. Undecided: closed at this spacing, where the mesh does not tell.
    pub fn sealed(&self) -> Result<Sealed> {
        let mut found = Sealed::default();
        let mut told = vec![false; self.loose.count()];
        for cavity in self.cavities.iter().filter(|c| c.apart) {
            if let Some(label) = self.label(cavity.on_wall) {
                told[label as usize] = true;
            }
            found.certain.push(Trapped {
                at: self.middle(cavity),
                extent: (cavity.box_mm[0], cavity.box_mm[1]),
                volume_mm3: Bracket::exact(cavity.volume_mm3),
                basis: Basis::Exact,
                way_out_mm: Bracket::exact(0.0),
                throat: None,
                shape: self.shell(cavity.shell),
            });
        }
        let left: Vec<u32> =
            (0..self.closed.len() as u32).filter(|&l| self.closed[l as usize] && !told[l as usize]).collect();
        if !left.is_empty() {
            self.by_sets(&self.loose, &left, true, &mut found.certain)?;
        }
        if !self.is_plain() {
            let free = components(&self.solid.outer.complement(), Adjacency::Face);
            let sizes = free.sizes();
            let firsts = free.first_samples();
            let mut open = Vec::new();
            for (l, at_border) in free.at_border().into_iter().enumerate() {
                if at_border || self.is_sealed(self.grid.offset(firsts[l])) {
                    continue;
                }
                if sizes[l] < LEAST_SAMPLES {
                    found.nooks += sizes[l];
                } else {
                    open.push(l as u32);
                }
            }
            self.by_sets(&free, &open, false, &mut found.undecided)?;
        }
        Ok(found)
    }

    /// Whether the shells tell all there is: then the void has one piece more than there are cavities.
    fn is_plain(&self) -> bool {
        self.part.is_plain() && self.cavities.iter().all(|c| c.apart)
    }

    /// Trapped places from components of free samples: volume from densities, between what is free and what may be.
    fn by_sets(&self, parts: &Components, labels: &[u32], certain: bool, out: &mut Vec<Trapped>) -> Result<()> {
        let unit = self.grid.h().powi(3);
        let density = self.solid.density.field().values();
        for &label in labels {
            let own = parts.select(|m| m == label);
            let set = if certain { own } else { ringed(&own, &self.solid.inner) };
            let share: f64 = set.iter().map(|at| 1.0 - f64::from(density[at])).sum();
            // Shells inside material leave traces without void.
            if share < 1e-3 {
                continue;
            }
            let free = if certain { set.difference(&self.solid.outer)?.count() } else { 0 };
            let high = set.count() as f64;
            let ([lo, hi], half) = (parts.boxes()[label as usize], 0.5 * self.grid.h());
            let extent = (self.grid.position(lo).map(|x| x - half), self.grid.position(hi).map(|x| x + half));
            out.push(Trapped {
                at: self.nearest_free(extent, |at| set.contains(at)),
                extent,
                volume_mm3: Bracket::new(share * unit, free as f64 * unit, high * unit),
                basis: self.basis(),
                way_out_mm: Bracket::exact(0.0),
                throat: None,
                shape: Filling::around(&set, self.solid)?.surface()?,
            });
        }
        Ok(())
    }

    /// A free sample of a cavity near the middle of its box, else a point of its wall. What lies in a body within it is not its own.
    fn middle(&self, cavity: &Cavity) -> Vec3 {
        let lies_within = |c: &&Cavity| {
            c.shell != cavity.shell
                && (0..3).all(|a| cavity.box_mm[0][a] < c.box_mm[0][a] && c.box_mm[1][a] < cavity.box_mm[1][a])
        };
        let within: Vec<&Cavity> = self.cavities.iter().filter(lies_within).collect();
        let is_own = |p: Vec3| cavity.holds(p) && !within.iter().any(|c| c.holds(p));
        let at = self.nearest_free((cavity.box_mm[0], cavity.box_mm[1]), |index| {
            !self.solid.outer.contains(index) && is_own(self.grid.position(index))
        });
        if is_own(at) { at } else { cavity.on_wall }
    }

    /// The wanted sample nearest to the middle of a box, from at most seventeen along each axis; else the middle.
    fn nearest_free(&self, (lo, hi): (Vec3, Vec3), wanted: impl Fn([usize; 3]) -> bool) -> Vec3 {
        let middle = [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]));
        let clamped = |p: Vec3| {
            let c = self.grid.continuous_index(p);
            [0, 1, 2].map(|a| c[a].round().clamp(0.0, self.grid.dims()[a] as f64 - 1.0) as usize)
        };
        let (first, last) = (clamped(lo), clamped(hi));
        let steps = |a: usize| (first[a]..=last[a]).step_by(((last[a] - first[a]) / 16).max(1));
        let mut best = (f64::INFINITY, middle);
        for k in steps(2) {
            for j in steps(1) {
                for i in steps(0) {
                    let p = self.grid.position([i, j, k]);
                    let d2: f64 = (0..3).map(|a| (p[a] - middle[a]).powi(2)).sum();
                    if d2 < best.0 && wanted([i, j, k]) {
                        best = (d2, p);
                    }
                }
            }
        }
        best.1
    }

    /// The surface of a shell, outward from the void.
    fn shell(&self, shell: u32) -> TriangleMesh {
        let labels = &self.part.health().facet_shell;
        let mesh = self.part.mesh();
        let own = (0..mesh.triangles.len()).filter(|&f| labels[f] == shell);
        TriangleMesh::weld(own.map(|f| mesh.corners(f))).flipped()
    }

    /// No sample.
    pub fn nothing(&self) -> Indicator {
        Indicator::empty(self.grid)
    }

    /// Squared distance of every free sample to the nearest sample that the part touches, in units of the spacing.
    pub fn clearance(&self) -> Result<Field<u32>> {
        squared_distance(&self.solid.outer)
    }

    /// The clearance while the part stands on the plate: no more than the height above it.
    pub fn above_plate(&self, clearance: &Field<u32>) -> Result<Field<u32>> {
        let [nx, ny, nz] = self.grid.dims();
        let height = |k: usize| self.grid.position([0, 0, k])[2].max(0.0) / self.grid.h();
        let most: Vec<u32> = (0..nz).map(|k| (height(k) * height(k)) as u32).collect();
        let values = clearance
            .values()
            .par_chunks(nx * ny)
            .zip(most)
            .flat_map_iter(|(layer, most)| layer.iter().map(move |&c| c.min(most)));
        Field::from_values(self.grid, values.collect(), 0)
    }

    /// Chambers wide enough for a ball of the limit's diameter whose way out is, or may be, narrower; sealed ones are
    /// left out. `met` holds what has been looked at already, and is added to.
    pub fn narrow(&self, clearance: &Field<u32>, limit_mm: f64, met: &mut Indicator) -> Result<Vec<Trapped>> {
        self.shut(clearance, &self.radii_about(limit_mm), met)
    }

    /// As [`Voids::narrow`], with a clearance that the plate caps: each with the volume that it holds above the plate.
    pub fn on_plate(&self, standing: &Field<u32>, limit_mm: f64) -> Result<Vec<Trapped>> {
        let found = self.shut_chambers(standing, &self.radii_about(limit_mm), &mut self.nothing())?;
        let held =
            |c: &Chamber| Ok(Trapped { volume_mm3: enclosed(c, standing, self.solid)?, ..self.trapped(c, standing)? });
        found.iter().map(held).collect()
    }

    /// What is open at the limit may still be in doubt; it shows as a chamber at the limit and two half diagonals more.
    fn radii_about(&self, limit_mm: f64) -> [f64; 2] {
        let radius = 0.5 * limit_mm / self.grid.h();
        [radius, radius + 2.0 * HALF_DIAGONAL]
    }

    /// Chambers too narrow for a ball of the limit's diameter, down to [`Voids::least_room_mm`], at least a quarter wider than
    /// their way out. `met` is as there.
    pub fn small_rooms(&self, clearance: &Field<u32>, limit_mm: f64, met: &mut Indicator) -> Result<Vec<Trapped>> {
        self.rooms_below(clearance, (limit_mm, self.least_room_mm(limit_mm)), met)
    }

    /// As [`Voids::small_rooms`], shut at diameters from the limit's down to `least_mm`.
    pub fn rooms_below(
        &self,
        clearance: &Field<u32>,
        (limit_mm, least_mm): (f64, f64),
        met: &mut Indicator,
    ) -> Result<Vec<Trapped>> {
        let samples = |diameter: f64| 0.5 * diameter / self.grid.h();
        let least = samples(least_mm);
        // Between the way out of a chamber and its widest place there is always one of these.
        let levels = std::iter::successors(Some(samples(limit_mm) / LEAST_RISE), |r| Some(r / LEAST_RISE));
        self.shut(clearance, &levels.take_while(|&r| r >= least).collect::<Vec<f64>>(), met)
    }

    /// Chambers are looked for down to this diameter: a quarter of the limit's, or what the grid tells from a passage.
    pub fn least_room_mm(&self, limit_mm: f64) -> f64 {
        (0.25 * limit_mm).max(4.0 * HALF_DIAGONAL * self.grid.h())
    }

    /// The chambers that are shut at one of the radii, in units of the spacing.
    fn shut(&self, clearance: &Field<u32>, radii: &[f64], met: &mut Indicator) -> Result<Vec<Trapped>> {
        let found = self.shut_chambers(clearance, radii, met)?;
        found.iter().map(|chamber| self.trapped(chamber, clearance)).collect()
    }

    fn shut_chambers(&self, clearance: &Field<u32>, radii: &[f64], met: &mut Indicator) -> Result<Vec<Chamber>> {
        let mut found = self.closed_at(clearance, radii, met)?;
        found.retain(rises);
        Ok(found)
    }

    /// The chambers that are shut at one of the radii and not sealed.
    pub fn closed_at(&self, clearance: &Field<u32>, radii: &[f64], met: &mut Indicator) -> Result<Vec<Chamber>> {
        let exits = border(&self.grid, &Side::ALL);
        let mut found: Vec<Chamber> = Vec::new();
        for radius in radii {
            let level = (radius * radius).ceil().max(1.0) as u32;
            let known = |at: usize| met.contains(self.grid.index(at)) || self.is_sealed(at);
            for chamber in chambers(clearance, &exits, level, known)? {
                chamber.offsets().for_each(|at| met.set(self.grid.index(at), true));
                if !self.is_sealed(chamber.deepest) {
                    found.push(chamber);
                }
            }
        }
        Ok(found)
    }

    /// The box of a chamber's samples.
    pub fn extent(&self, chamber: &Chamber) -> (Vec3, Vec3) {
        let ends = chamber.region.iter().flat_map(|&(first, n)| [first as usize, (first + n) as usize - 1]);
        bounds(ends.map(|at| self.place(at))).unwrap_or((self.place(chamber.deepest), self.place(chamber.deepest)))
    }

    /// Where a sample is.
    pub fn place(&self, at: usize) -> Vec3 {
        self.grid.position(self.grid.index(at))
    }

    /// A chamber with what it holds and its way out, by the grid.
    pub fn trapped(&self, chamber: &Chamber, clearance: &Field<u32>) -> Result<Trapped> {
        let h = self.grid.h();
        let filling = Filling::of(chamber, clearance, self.solid)?;
        Ok(Trapped {
            at: self.place(chamber.deepest),
            extent: self.extent(chamber),
            volume_mm3: Bracket::new(filling.volume_mm3(), chamber.samples() as f64 * h.powi(3), f64::INFINITY),
            basis: self.basis(),
            way_out_mm: way_out(chamber, h),
            throat: chamber.throat.map(|t| self.place(t.at)),
            shape: filling.surface()?,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::vector::cross;
    use crate::part::Up;
    use crate::random::Lcg;
    use crate::units::Length;

    /// A cube with a cubic room and a square neck upwards; the neck is closed if its width is 0.
    pub(in crate::check) fn flask(edge: f64, room: f64, neck: f64) -> TriangleMesh {
        let (a, b, c) = (0.5 * edge, 0.5 * room, 0.5 * neck);
        let square = |r: f64, z: f64| [[-r, -r, z], [r, -r, z], [r, r, z], [-r, r, z]];
        let mut facets: Vec<[Vec3; 3]> = Vec::new();
        let mut strip = |p: [Vec3; 4], q: [Vec3; 4]| {
            for i in 0..4 {
                let j = (i + 1) % 4;
                facets.push([p[i], p[j], q[j]]);
                facets.push([p[i], q[j], q[i]]);
            }
        };
        strip(square(a, -a), square(a, a));
        strip(square(b, b), square(b, -b));
        if neck > 0.0 {
            strip(square(a, a), square(c, a));
            strip(square(c, a), square(c, b));
            strip(square(c, b), square(b, b));
        }
        let mut lid = |p: [Vec3; 4]| facets.extend([[p[0], p[1], p[2]], [p[0], p[2], p[3]]]);
        let turned = |mut p: [Vec3; 4]| {
            p.reverse();
            p
        };
        lid(turned(square(a, -a)));
        lid(square(b, -b));
        if neck <= 0.0 {
            lid(square(a, a));
            lid(turned(square(b, b)));
        }
        TriangleMesh::weld(facets)
    }

    pub(in crate::check) fn turned(mesh: &TriangleMesh, mut below: impl FnMut() -> f64) -> TriangleMesh {
        let w = crate::geometry::vector::unit([below() - 0.5, below() - 0.5, below() - 0.45]);
        let u = crate::geometry::vector::unit(cross(w, [0.36, -0.48, 0.8]));
        let v = cross(w, u);
        mesh.transformed([u, v, w], [0.0; 3])
    }

    pub(in crate::check) fn part(mesh: TriangleMesh, h: f64, phase: Vec3) -> Part {
        let mut part = Part::new(mesh, Up::PlusZ, 1e-9, 1.0).unwrap();
        let grid = Grid::covering([0.0; 3], part.extent(), Length::mm(h), 1, phase).unwrap();
        part.cast_on(grid);
        part
    }

    #[test]
    fn no_way_out_in_ten_thousand_flasks_lies_outside_its_bracket() {
        let mut state = 11u64;
        let mut below = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let (mut seen, mut sealed, mut wrong) = (0, 0, Vec::new());
        for case in 0..10_000 {
            // From closed through narrower than a sample to as wide as the limit of 4 mm.
            let neck = if case % 8 == 0 { 0.0 } else { 0.05 + 3.9 * below() };
            let mesh = turned(&flask(16.0, 10.0, neck), &mut below);
            let part = part(mesh, 0.7 + 0.5 * below(), [below() - 0.5, below() - 0.5, below() - 0.5]);
            let voids = Voids::of(&part).unwrap();
            let found = voids.sealed().unwrap();
            let clearance = voids.clearance().unwrap();
            let narrow = voids.narrow(&clearance, 4.0, &mut voids.nothing()).unwrap();
            if neck == 0.0 {
                sealed += 1;
                let one = found.certain.len() == 1 && (found.certain[0].volume_mm3.value - 1000.0).abs() < 1e-6;
                if !one || !narrow.is_empty() {
                    wrong.push((case, neck, found.certain.len() as f64, narrow.len() as f64));
                }
                continue;
            }
            if !found.certain.is_empty() {
                wrong.push((case, neck, -1.0, -1.0));
            }
            // A neck narrower than the room and the limit by more than the bracket has to be found.
            if narrow.is_empty() && neck < 4.0 - 4.0 * HALF_DIAGONAL * 1.2 {
                wrong.push((case, neck, -2.0, -2.0));
            }
            for t in &narrow {
                seen += 1;
                if !(t.way_out_mm.low <= neck && neck <= t.way_out_mm.high) {
                    wrong.push((case, neck, t.way_out_mm.low, t.way_out_mm.high));
                }
            }
        }
        assert!(wrong.is_empty(), "{} of 10000: {:?}", wrong.len(), &wrong[..wrong.len().min(8)]);
        assert!(seen > 5000 && sealed == 1250, "{seen} {sealed}");
    }

    #[test]
    fn a_room_narrower_than_the_limit_is_found_behind_its_neck_and_a_passage_is_none() {
        let mut rng = Lcg(29);
        let mut seen = 0;
        for case in 0..1000 {
            // A room of 3 mm under a limit of 4.5 mm, which the doubt of the coarsest grid does not reach; its neck from a fifth of a millimetre to the width of the room.
            let (neck, h) = (0.2 + 2.8 * rng.unit(), 0.12 + 0.13 * rng.unit());
            let mesh = turned(&flask(6.0, 3.0, neck), || rng.unit());
            let part = part(mesh, h, [0, 1, 2].map(|_| rng.unit() - 0.5));
            let voids = Voids::of(&part).unwrap();
            let clearance = voids.clearance().unwrap();
            let mut met = voids.nothing();
            assert!(voids.narrow(&clearance, 4.5, &mut met).unwrap().is_empty(), "{case}: no ball of the limit fits");
            let rooms = voids.small_rooms(&clearance, 4.5, &mut met).unwrap();
            // Distances between samples are known to a half diagonal on either side.
            let surely =
                1.5 - HALF_DIAGONAL * h > LEAST_RISE * (0.5 * neck + HALF_DIAGONAL * h) + 2.0 * HALF_DIAGONAL * h;
            let surely_none = 1.5 + HALF_DIAGONAL * h < LEAST_RISE * (0.5 * neck - HALF_DIAGONAL * h);
            let allowed = usize::from(surely)..=usize::from(!surely_none);
            assert!(allowed.contains(&rooms.len()), "{case}: {} rooms, {neck}", rooms.len());
            for t in &rooms {
                seen += 1;
                assert!(t.way_out_mm.low <= neck && neck <= t.way_out_mm.high, "{case}: {neck} {:?}", t.way_out_mm);
            }
        }
        assert!(seen > 300, "{seen}");
    }

    #[test]
    fn halving_the_spacing_turns_no_certain_answer_round() {
        for neck in [1.0, 2.0, 3.0] {
            let brackets: Vec<Bracket> = [1.0, 0.5, 0.25]
                .map(|h| {
                    let part = part(flask(16.0, 12.0, neck), h, [0.2, -0.3, 0.1]);
                    let voids = Voids::of(&part).unwrap();
                    voids.narrow(&voids.clearance().unwrap(), 6.0, &mut voids.nothing()).unwrap()[0].way_out_mm
                })
                .into();
            for pair in brackets.windows(2) {
                assert!(pair[0].low <= pair[1].high && pair[1].low <= pair[0].high, "{brackets:?}");
            }
            assert!(brackets.iter().all(|b| b.low <= neck && neck <= b.high), "{brackets:?}");
        }
    }

    #[test]
    fn two_bodies_that_close_a_void_together_are_united_and_it_is_exact() {
        // A cup and a lid that overlap: only the shell of their union bounds the void.
        let upright = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let cup = flask(16.0, 10.0, 9.9);
        let lid = flask(4.0, 1.0, 0.0);
        let lid =
            TriangleMesh { vertices: lid.vertices.iter().map(|p| [3.5 * p[0], 3.5 * p[1], p[2]]).collect(), ..lid };
        let lid = lid.transformed(upright, [0.0, 0.0, 7.5]);
        let part = part(cup.joined(&lid), 0.4, [0.0; 3]);
        let found = Voids::of(&part).unwrap().sealed().unwrap();
        let big: Vec<&Trapped> = found.certain.iter().filter(|t| t.volume_mm3.value > 500.0).collect();
        assert!(big.len() == 1 && found.undecided.is_empty(), "{big:?}");
        // The room up to the lid's underside at 5.5 mm.
        let truth = 1000.0 + 9.9 * 9.9 * 0.5;
        assert!((big[0].volume_mm3.value - truth).abs() < 1e-5 * truth, "{:?} {truth}", big[0].volume_mm3);
    }
}
