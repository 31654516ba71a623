//! A part posed for the build, with the fields and trees that checks share.

mod bounding;
mod frame;
mod printed;

pub use crate::access::Up;
pub use printed::{bead_of, spread_of};

use crate::access::{Question as Asked, Setup, Turn, Turns, axis_directions, lattice_directions, least_hanging};
use crate::error::{Error, Result};
use crate::geometry::health::{self, Meetings, Role};
use crate::geometry::vector::{Vec3, add, sub};
use crate::geometry::{
    Adjacency, BodyPair, Health, InsideRule, MeshDistance, Solid, TriangleMesh, Winding, body_pairs, voxelize,
};
use crate::grid::{BYTES_PER_SAMPLE, Fitting, Grid};
use crate::layer::{Bounding, Ceiling, Floors};
use crate::medial::rod::{Rods, Search, Wanted};
use crate::medial::{Bends, Cover, Features, Question, Side};
use crate::notice::{Notice, number_of};
use crate::once::once;
use crate::units::{Length, report_digits, short};
use bounding::Before;
use printed::Printed;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// A part in the frame of the build: +z up, its box's least corner at the origin.
///
/// Trees and fields are made when first asked for and shared by all checks.
pub struct Part {
    mesh: TriangleMesh,
    as_read: Health,
    health: Health,
    rotation: [Vec3; 3],
    translation: Vec3,
    step: f64,
    notices: Vec<Notice>,
    bounding: Vec<bool>,
    meetings: Meetings,
    /// Whether the mesh is the union of what met itself when it was read.
    united: bool,
    before_union: Option<TriangleMesh>,
    /// The mesh as it was read, where its edges or facets are at fault.
    faulty: Option<TriangleMesh>,
    before: Before,
    /// How far a body is looked for around another, millimetres.
    reach: f64,
    grid: Option<Grid>,
    kept: Kept,
}

/// What is made when first asked for.
#[derive(Default)]
struct Kept {
    distance: OnceLock<MeshDistance>,
    floors: OnceLock<Floors>,
    winding: OnceLock<Winding>,
    bends: OnceLock<Bends>,
    features: [OnceLock<Features>; 2],
    adjacency: OnceLock<Adjacency>,
    covers: [OnceLock<(Question, Cover)>; 2],
    rods: [OnceLock<(Wanted, Rods)>; 2],
    pairs: OnceLock<Vec<BodyPair>>,
    solid: OnceLock<Result<Solid>>,
    printed: OnceLock<Printed>,
    ceilings: OnceLock<([f64; 5], Arc<Vec<Ceiling>>)>,
    turn: OnceLock<(Asked, Option<Turn>)>,
    setups: OnceLock<Result<Vec<Setup>>>,
    sides: OnceLock<Vec3>,
}

/// What one window may take, bytes.
const WINDOW_BYTES: u128 = 1 << 30;

impl Part {
    /// A part from a mesh in millimetres in the frame of the file.
    ///
    /// What is a solid but for cracks is closed where none is wider than [`health::repair_tolerance`], and said so.
    /// Facets are turned to agree with their neighbours and shells that are wound inside out are turned, and said so. Bodies that overlap or
    /// touch, and what passes through itself, are united to one surface, if that is closed and meets itself nowhere. Where the facets do not agree, each is turned so that the
    /// side of greater winding number is inside, and facets that do not bound the solid are set aside. Facets with a corner on the
    /// opposite edge or with an edge shorter than the file tells apart are done away with. `step_mm` is the resolution of the file's coordinates.
    ///
    /// # Errors
    /// [`Error::NoGeometry`] without facets or extent; [`Error::NotSolid`] if the winding number is below ½ everywhere; as [`Up::validate`].
    pub fn new(mesh: TriangleMesh, up: Up, step_mm: f64, reach_mm: f64) -> Result<Self> {
        up.validate()?;
        let rotation = up.rotation();
        let turned = mesh.in_order().transformed(rotation, [0.0; 3]);
        let (lo, hi) = turned.bounds().ok_or_else(|| no_geometry("the file holds no triangles"))?;
        let longest = sub(hi, lo).into_iter().fold(0.0, f64::max);
        if !(longest > 0.0 && longest.is_finite()) {
            return Err(no_geometry("the surface has no extent"));
        }
        let (mut mesh, mut translation) = at_origin(turned, lo);
        let mut as_read = Health::of(&mesh);
        // What holds no volume is not printed, and does not set the plate.
        let solid = health::without_ghosts(&mesh, &as_read);
        if let Some(lo) = solid.as_ref().and_then(|solid| solid.bounds()).map(|(lo, _)| lo).filter(|lo| *lo != [0.0; 3])
        {
            let (moved, shift) = at_origin(mesh, lo);
            (mesh, translation) = (moved, add(translation, shift));
            as_read = Health::of(&mesh);
        }
        let faulty = as_read.is_faulty().then(|| mesh.clone());
        let mut notices = as_read.notices();
        let mut health = None;
        if as_read.miswound_edges.count > 0 {
            let (agreed, turned) = health::agreed(&mesh);
            let text = number_of(turned as u64, health::TURNED);
            notices.push(Notice::new("turned-facets", text).counted(turned as u64));
            health = Some(Health::of(&agreed));
            mesh = agreed;
        }
        if let Some(solid) = health::without_ghosts(&mesh, health.as_ref().unwrap_or(&as_read)) {
            health = Some(Health::of(&solid));
            mesh = solid;
        }
        let wide = health::repair_tolerance(&mesh);
        if let Some((closed, joined)) = health::without_cracks(&mesh, health.as_ref().unwrap_or(&as_read), wide) {
            notices.push(closed_cracks(joined as u64, wide));
            health = Some(Health::of(&closed));
            mesh = closed;
        }
        let step = step_mm.clamp(1e-9, 1e-4);
        if let Some(plain) = health::without_slivers(&mesh, step) {
            health = Some(Health::of(&plain));
            mesh = plain;
        }
        let health = health.unwrap_or_else(|| as_read.clone());
        health::turn_shells(&mut mesh, &health);
        let mut part = Part {
            bounding: vec![true; mesh.triangles.len()],
            meetings: Meetings::default(),
            united: false,
            before_union: None,
            faulty,
            before: Before::default(),
            mesh,
            as_read,
            health,
            rotation,
            translation,
            step,
            notices,
            // Bodies that touch are found whatever else is asked.
            reach: reach_mm.max(2.0 * step),
            grid: None,
            kept: Kept::default(),
        };
        part.choose_bounding_facets()?;
        Ok(part)
    }

    /// The mesh in the frame of the build, outward normals.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The mesh as it was read, with its ghosts, where its edges or facets are at fault; of any other what was not yet united.
    pub fn mesh_as_read(&self) -> &TriangleMesh {
        self.faulty.as_ref().or(self.before_union.as_ref()).unwrap_or(&self.mesh)
    }

    /// Health of the mesh as it was read.
    pub fn health_as_read(&self) -> &Health {
        &self.as_read
    }

    /// Health of the mesh as it is judged, its facets turned to agree with their neighbours.
    pub fn health(&self) -> &Health {
        &self.health
    }

    /// Everything noticed on the way, places in the frame of the file.
    pub fn notices(&self) -> Vec<Notice> {
        let moved = |n: &Notice| Notice { at_mm: n.at_mm.map(|p| self.to_file(p)), ..n.clone() };
        self.notices.iter().map(moved).collect()
    }

    /// Resolution of the file's coordinates, millimetres: none is further from what was meant.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// How far a length may be from what was meant, millimetres: 2√3 steps, since both its ends may be off by one along each axis.
    ///
    /// What misses a limit by less meets it, so that a part that was turned before it was written is judged alike.
    pub fn tie(&self) -> f64 {
        2.0 * 3f64.sqrt() * self.step
    }

    /// Facets of one body that crossed each other, or lay on each other, by more than the resolution of the file, as it was read.
    pub fn meetings(&self) -> Meetings {
        self.meetings
    }

    /// Whether the mesh bounds a solid just as it stands: closed, oriented, bodies apart, nothing passing through itself.
    ///
    /// Where it does not, inside is where the winding number says so, and facets inside the union bound nothing.
    pub fn is_plain(&self) -> bool {
        let touching = || self.body_pairs().iter().any(|p| p.distance <= self.step);
        let sound = self.health.is_solid() && self.health.duplicate_facets.count == 0;
        self.united || sound && self.meetings.crossing.count == 0 && self.meetings.overlapping.count == 0 && !touching()
    }

    /// Whether the mesh is the union of bodies that overlapped or touched when it was read, or of what passed through itself.
    pub fn is_united(&self) -> bool {
        self.united
    }

    /// Whether a facet bounds the solid; ghosts and facets inside the union do not.
    pub fn bounds_solid(&self, facet: usize) -> bool {
        self.bounding.get(facet).copied().unwrap_or(false)
    }

    /// Whether a facet bounds a void that is closed all round: what is put into it stays there. Nothing is said of shells that cross.
    pub fn bounds_sealed_void(&self, facet: usize) -> bool {
        let shell = self.health.facet_shell.get(facet).and_then(|&s| self.health.shells.get(s as usize));
        (self.united || self.meetings.crossing.count == 0) && shell.is_some_and(|shell| shell.role == Role::Cavity)
    }

    /// Side lengths of the box in the frame of the build, millimetres.
    pub fn extent(&self) -> Vec3 {
        self.mesh.bounds().map_or([0.0; 3], |(lo, hi)| sub(hi, lo))
    }

    /// Exact distances to the facets that bound the solid.
    pub fn distance(&self) -> &MeshDistance {
        once(&self.kept.distance, || MeshDistance::to_some(&self.mesh, |f| self.bounds_solid(f)))
    }

    /// The facets that bound the solid and look up.
    pub fn floors(&self) -> &Floors {
        once(&self.kept.floors, || Floors::of(&self.mesh, self))
    }

    /// The generalized winding number.
    pub fn winding(&self) -> &Winding {
        once(&self.kept.winding, || Winding::new(&self.mesh))
    }

    /// The features a ball on one side can touch.
    pub fn features(&self, side: Side) -> &Features {
        let bends = || once(&self.kept.bends, || Bends::of(&self.mesh, |f| self.bounds_solid(f)));
        let features = || Features::of(&self.mesh, side, bends()).of_bodies(&self.health.facet_body);
        once(&self.kept.features[side as usize], features)
    }

    /// The facet across each edge, among those that bound the solid.
    pub fn adjacency(&self) -> &Adjacency {
        once(&self.kept.adjacency, || Adjacency::of(&self.mesh, |f| self.bounds_solid(f)))
    }

    /// The thin sheets on one side, kept for the first question asked.
    pub fn cover(&self, side: Side, question: &Question) -> Cow<'_, Cover> {
        let search = || Cover::search(self.distance(), self.features(side), question);
        let (kept_for, kept) = self.kept.covers[side as usize].get_or_init(|| (question.clone(), search()));
        if kept_for == question { Cow::Borrowed(kept) } else { Cow::Owned(search()) }
    }

    /// The rods of material or void; kept for the first width asked for.
    pub fn rods(&self, wanted: Wanted) -> Cow<'_, Rods> {
        let search = || {
            let search = Search { mesh: &self.mesh, distance: self.distance(), next: self.adjacency(), wanted };
            search.run(|f| self.bounds_solid(f))
        };
        let (kept_for, kept) = self.kept.rods[wanted.side as usize].get_or_init(|| (wanted, search()));
        if *kept_for == wanted { Cow::Borrowed(kept) } else { Cow::Owned(search()) }
    }

    /// All pairs of bodies nearer than the part's reach, nearest points and exact distance.
    pub fn body_pairs(&self) -> &[BodyPair] {
        once(&self.kept.pairs, || body_pairs(&self.mesh, &self.health, self.reach)).as_slice()
    }

    /// Sets the grid on which [`Part::solid`] is cast.
    pub fn cast_on(&mut self, grid: Grid) {
        self.grid = Some(grid);
        self.kept.solid = OnceLock::new();
    }

    /// The part as tools see it from the directions between a cube's faces, edges and corners, from +z first: 26, or the six
    /// axis directions where inside and outside come from the winding number. The first call's spacing and margin hold.
    ///
    /// # Errors
    /// As [`Setup::cast`].
    pub fn setups(&self, spacing: Length, margin: Length) -> Result<&[Setup]> {
        let rule = if self.health.is_solid() { InsideRule::Crossings } else { InsideRule::Winding };
        let directions = lattice_directions();
        // Where inside comes from the winding number a cast costs more.
        let listed = if rule == InsideRule::Crossings { directions.len() } else { 6 };
        let cast = || {
            let mut setups = Setup::all(&self.mesh, rule, &directions[..listed], spacing, margin)?;
            // Tools of any shape take four stations a direction: the axes make the 24 rotations of a cube.
            let axes = axis_directions();
            setups.iter_mut().filter(|s| !axes.contains(&s.direction)).for_each(|s| s.turns = Turns::Nowhere);
            Ok(setups)
        };
        self.kept.setups.get_or_init(cast).as_deref().map_err(Clone::clone)
    }

    /// The part on its grid: inner, centres, outer and density.
    ///
    /// # Errors
    /// [`Error::Internal`] before [`Part::cast_on`]; otherwise as [`voxelize()`].
    pub fn solid(&self) -> Result<&Solid> {
        let cast = || {
            let grid = self.grid.ok_or_else(|| Error::Internal { problem: "the part has no grid yet".into() })?;
            self.cast(&grid)
        };
        self.kept.solid.get_or_init(cast).as_ref().map_err(Clone::clone)
    }

    /// The part cast finer, or coarser, inside the box `[lo, hi]` of the build's frame only.
    ///
    /// The samples are those that the whole part would have at this spacing and phase 0, and so are their bits and densities (up to the
    /// rounding of corners, h/2^16); what lies outside the box still decides what is inside. To see which samples of a field of reach r
    /// are right, widen the box by r.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more than 1 GiB; otherwise as [`Part::solid`].
    ///
    /// # Cost
    /// O(facets + cubes of the box that are touched + samples/64).
    pub fn window(&self, lo: Vec3, hi: Vec3, spacing: Length) -> Result<Solid> {
        let whole = Grid::covering([0.0; 3], self.extent(), spacing, 1, [0.0; 3])?;
        Fitting::within(sub(hi, lo).map(|x| x.max(0.0)), spacing, BYTES_PER_SAMPLE, WINDOW_BYTES)?;
        self.cast(&whole.window(lo, hi)?)
    }

    /// The part on a grid, by crossings where the surface allows it.
    fn cast(&self, grid: &Grid) -> Result<Solid> {
        // Where the crossings of a row do not add up, the winding number still tells inside from outside.
        let by_crossings = self.health.is_solid().then(|| voxelize(&self.mesh, grid, InsideRule::Crossings));
        match by_crossings {
            Some(Ok(solid)) => Ok(solid),
            Some(Err(Error::Operand { .. })) | None => voxelize(&self.mesh, grid, InsideRule::Winding),
            Some(Err(e)) => Err(e),
        }
    }

    /// The ceilings of the part as `measure` finds them; shared by all who ask with the same key.
    pub fn ceilings(&self, key: [f64; 5], measure: impl Fn() -> Vec<Ceiling>) -> Arc<Vec<Ceiling>> {
        let (of, found) = self.kept.ceilings.get_or_init(|| (key, Arc::new(measure())));
        if *of == key { found.clone() } else { Arc::new(measure()) }
    }

    /// The turn of the part in which least hangs over, [`least_hanging`]; shared by all who ask the same.
    pub fn least_hanging(&self, asked: &Asked) -> Option<Turn> {
        let find = || least_hanging(&self.mesh, self, asked);
        let (of, found) = self.kept.turn.get_or_init(|| (asked.clone(), find()));
        if of == asked { *found } else { find() }
    }
}

impl Bounding for Part {
    fn bounds_solid(&self, facet: usize) -> bool {
        Part::bounds_solid(self, facet)
    }

    fn is_covered(&self, facet: u32) -> bool {
        !self.bounds_solid(facet as usize) || !self.is_plain() && self.is_inside_before(facet, 20.0 * self.step)
    }
}

fn no_geometry(problem: &str) -> Error {
    Error::NoGeometry { problem: problem.into(), remedy: "export the part again; it must be a closed surface".into() }
}

/// Says that the vertices on both sides of cracks were taken for one.
fn closed_cracks(joined: u64, wide: f64) -> Notice {
    let words =
        ["vertex at a crack was judged as one with another", "vertices at cracks were judged as one with others"];
    let text = format!("{}, no farther than {} mm away", number_of(joined, words), short(report_digits(wide)));
    Notice::new("closed-cracks", text).counted(joined)
}

/// A mesh with the least corner of its box moved to the origin, and by how much it was moved.
fn at_origin(mesh: TriangleMesh, lo: Vec3) -> (TriangleMesh, Vec3) {
    let translation = lo.map(|x| 0.0 - x);
    (mesh.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation), translation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Indicator;
    use crate::geometry::Primitive;

    /// Two balls that cross, so that samples with winding number 2 occur; turned so that no facet lies along the lattice.
    fn pair_of_balls() -> TriangleMesh {
        let ball = Primitive::Ball { radius: Length::mm(3.0) }.mesh(Length::mm(0.05));
        let (s, c) = 0.5f64.sin_cos();
        let turned = ball.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [4.0, 0.5, 0.25]);
        ball.joined(&turned)
    }

    #[test]
    fn a_direction_that_points_nowhere_is_refused_by_name() {
        for nowhere in [[0.0; 3], [0.0, f64::NAN, 1.0], [f64::INFINITY, 0.0, 0.0]] {
            let refused = Part::new(crate::geometry::cuboid([0.0; 3], [9.0; 3]), Up::Along(nowhere), 1e-6, 1.0);
            let Some(Error::Usage { problem, .. }) = refused.err() else { panic!("{nowhere:?}") };
            assert!(problem.contains(&format!("{nowhere:?}")), "{problem}");
        }
    }

    #[test]
    fn a_window_is_the_same_samples_of_a_finer_whole() {
        let torn = TriangleMesh { triangles: pair_of_balls().triangles[3..].to_vec(), ..pair_of_balls() };
        for (mesh, h) in [(pair_of_balls(), 0.11), (pair_of_balls(), 0.25), (torn, 0.2)] {
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).expect("a part");
            let spacing = Length::mm(h);
            let whole = part.window([-0.01; 3], part.extent().map(|x| x + 0.01), spacing).expect("the whole");
            for (lo, hi) in
                [([2.0, 1.0, 3.0], [7.0, 4.0, 4.0]), ([-1.0, 2.0, 2.0], [3.0, 9.0, 2.0]), ([4.0; 3], [4.0; 3])]
            {
                let window = part.window(lo, hi, spacing).expect("a window");
                window.validate().expect("a solid");
                let first = whole.centres.grid().continuous_index(window.centres.grid().origin());
                let (first, dims) = (first.map(|c| c.round() as isize), window.centres.grid().dims());
                let same = |of_whole: &Indicator, of_window: &Indicator| {
                    let cut = of_whole.placed(first, *of_window.grid()).expect("a window");
                    assert_eq!(&cut, of_window, "{h} {lo:?}");
                };
                same(&whole.centres, &window.centres);
                same(&whole.inner, &window.inner);
                same(&whole.outer, &window.outer);
                for at in 0..window.centres.grid().samples() {
                    let i = window.centres.grid().index(at);
                    let of_whole = whole.density.field().at([0, 1, 2].map(|a| first[a] + i[a] as isize));
                    assert!((of_whole - window.density.field().values()[at]).abs() < 1e-4, "{h} {i:?} of {dims:?}");
                }
            }
        }
    }

    #[test]
    fn a_window_too_large_is_refused_before_it_is_taken() {
        let part = Part::new(pair_of_balls(), Up::PlusZ, 1e-6, 1.0).expect("a part");
        let refused = part.window([0.0; 3], part.extent(), Length::mm(1e-3));
        assert!(matches!(refused, Err(Error::TooLarge { .. })), "{refused:?}");
    }

    #[test]
    fn a_ball_whose_facets_cracks_part_is_judged_as_a_ball() {
        let ball = Primitive::Ball { radius: Length::mm(5.0) }.mesh(Length::mm(0.02));
        let mut random = crate::random::Lcg(11);
        let loose = TriangleMesh::weld(
            (0..ball.triangles.len()).map(|f| ball.corners(f).map(|p| add(p, random.point(-1e-5, 1e-5)))),
        );
        let part = Part::new(loose, Up::PlusZ, 1e-9, 1.0).unwrap();
        assert_eq!(part.health_as_read().open_edges.count, 3 * ball.triangles.len() as u64);
        assert!(part.is_plain() && part.notices().iter().any(|n| n.code == "closed-cracks"), "{:?}", part.notices());
        assert_eq!((part.mesh().triangles.len(), part.health().bodies.len()), (ball.triangles.len(), 1));
        // No corner is off by more than √3 · 10⁻⁵, and the area is less than 314.2 mm².
        assert!((part.health().volume_mm3() - ball.signed_volume()).abs() < 0.006, "{}", part.health().volume_mm3());
    }
}
