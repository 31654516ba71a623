//! Whether what is thickened or widened has room: such a hint is tried on the surface before it is given.

use super::contract::limits_of;
use crate::geometry::vector::{Vec3, along, dot, sub, unit};
use crate::medial::{Sample, Side};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;
use rustc_hash::FxHashMap;

/// Pairs of contacts of a sheet that are tried, evenly over it.
const TRIED: usize = 64;

/// Cubes that a patch may touch to be noted in each.
const LARGE: i64 = 512;

/// Surface that runs within 6° along a way is not in it: the floor that a wall stands on, the facets of a round face.
const GRAZING: f64 = 0.1;

/// Facets that a way grazes, at most.
const GRAZED: usize = 16;

/// How a hint begins that says that there is none.
pub const NO_ROOM: &str = "there is no room";

/// What has to be left beside what grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// The limit of what lies there.
    Limit,
    /// At least as much as it has grown to: an offset that spares one then spares the other.
    AsMuch,
}

/// Whether there is room for something to grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fit {
    /// There is none.
    Cramped,
    /// There is as long as what is as thin across the gap, and has to grow too, stays as it is.
    Alone,
    /// There is, with all that is to grow grown.
    Roomy,
}

impl Fit {
    /// How many fits are of each kind, the best first.
    pub fn counts(fits: impl IntoIterator<Item = Fit>) -> [usize; 3] {
        fits.into_iter().fold([0; 3], |mut counts, fit| {
            counts[2 - fit as usize] += 1;
            counts
        })
    }
}

/// What else is thin, and where on the surface: it is to grow as well.
pub struct Thin {
    cell: f64,
    /// The least width met on a facet, in each cube.
    least: FxHashMap<(u32, [i64; 3]), f64>,
    /// Patches that touch too many cubes, on each facet.
    large: FxHashMap<u32, Vec<Large>>,
}

/// A large patch: its box, and the width met there.
struct Large {
    sides: (Vec3, Vec3),
    width: f64,
}

impl Thin {
    /// The places of samples, to within a length.
    ///
    /// # Cost
    /// The cubes of that edge that the samples' patches touch.
    pub fn of<'s>(samples: impl IntoIterator<Item = &'s Sample>, cell: f64) -> Self {
        let mut thin = Thin { cell, least: FxHashMap::default(), large: FxHashMap::default() };
        for s in samples {
            let (lo, hi) = (thin.cube(s.sides.0), thin.cube(s.sides.1));
            let [nx, ny, nz] = [0, 1, 2].map(|a| hi[a] - lo[a] + 1);
            let count = nx.saturating_mul(ny).saturating_mul(nz);
            if count > LARGE {
                thin.large.entry(s.facet).or_default().push(Large { sides: s.sides, width: s.diameter });
                continue;
            }
            for n in 0..count {
                let at = [lo[0] + n % nx, lo[1] + n / nx % ny, lo[2] + n / (nx * ny)];
                let least = thin.least.entry((s.facet, at)).or_insert(f64::INFINITY);
                *least = least.min(s.diameter);
            }
        }
        thin
    }

    fn cube(&self, p: Vec3) -> [i64; 3] {
        p.map(|x| (x / self.cell).floor() as i64)
    }

    /// By how much what lies at a point of a facet has to grow to a width.
    fn growth(&self, facet: u32, p: Vec3, to: f64) -> f64 {
        let holds = |(lo, hi): (Vec3, Vec3)| (0..3).all(|a| lo[a] - self.cell <= p[a] && p[a] <= hi[a] + self.cell);
        let large = self.large.get(&facet).into_iter().flatten().filter(|l| holds(l.sides)).map(|l| l.width);
        let small = self.least.get(&(facet, self.cube(p))).copied();
        let width = large.chain(small).fold(f64::INFINITY, f64::min);
        (to - width).max(0.0)
    }
}

/// Something on one side of a part's surface that is to grow.
pub struct Growth<'a> {
    part: &'a Part,
    side: Side,
    /// What has to be left beside it: the gap beside a wall or a pin, the wall beside a gap or a hole; 0 without such a rule.
    pub beside: f64,
    /// What else grows, and to what width.
    others: Option<(&'a Thin, f64)>,
}

impl<'a> Growth<'a> {
    /// With the limit of what lies beside: `narrow-gap` for material, `thin-wall` for void.
    pub fn new(part: &'a Part, process: &Process, side: Side) -> Self {
        let rule = if side == Side::Material { "narrow-gap" } else { "thin-wall" };
        let beside = limits_of(process, rule).and_then(|l| l.fail.or(l.warn)).unwrap_or(0.0);
        Growth { part, side, beside, others: None }
    }

    /// The same, with what is to be left beside something that has grown to a width.
    pub fn leaving(self, beside: Beside, width: f64) -> Self {
        let least = if beside == Beside::AsMuch { width } else { 0.0 };
        Growth { beside: self.beside.max(least), ..self }
    }

    /// The same, where all else that is thinner than a width grows to it as well.
    pub fn among(self, thin: &'a Thin, to: f64) -> Self {
        Growth { others: Some((thin, to)), ..self }
    }

    /// Whether a sheet can grow to a width at all pairs of contacts that are tried: on one side, or by half on both.
    ///
    /// # Cost
    /// At most 128 rays.
    pub fn fits<'s>(&self, samples: impl ExactSizeIterator<Item = &'s Sample>, width: f64) -> Fit {
        let stride = samples.len().div_ceil(TRIED).max(1);
        let tries = samples.step_by(stride).map(|s| self.fits_between(s.contacts, width - s.diameter));
        tries.min().unwrap_or(Fit::Roomy)
    }

    /// Whether two contacts can move apart by a length, and leave beside them what has to be left.
    ///
    /// What is thin across a gap grows too: by all it needs towards what grows on one side, by half where that grows by half on both sides.
    /// So each can be done by what it was told, whatever the others choose.
    pub fn fits_between(&self, [a, b]: [Vec3; 2], by: f64) -> Fit {
        let outward = unit(sub(b, a));
        if by <= 0.0 || outward == [0.0; 3] {
            // Contacts that coincide tell no direction to grow in.
            return if by <= 0.0 { Fit::Roomy } else { Fit::Cramped };
        }
        let sides = [self.free(a, outward.map(|x| -x), by), self.free(b, outward, by)];
        let enough = |free: f64, by: f64| free >= by + self.beside - self.part.tie();
        let fits = |grown: fn(f64) -> f64| {
            let left = |share: f64| sides.map(|(free, other)| free - grown(share * other));
            let ([a, b], [c, d]) = (left(1.0), left(0.5));
            enough(a.max(b), by) || enough(c.min(d), 0.5 * by)
        };
        if fits(|other| other) {
            Fit::Roomy
        } else if fits(|_| 0.0) {
            Fit::Alone
        } else {
            Fit::Cramped
        }
    }

    /// How far it is to what lies beside, as far as that matters, and by how much that has to grow itself.
    fn free(&self, from: Vec3, way: Vec3, by: f64) -> (f64, f64) {
        let (mut near, far) = (self.part.step(), by + self.beside + self.others.map_or(0.0, |(_, to)| to));
        for _ in 0..GRAZED {
            let Some((at, facet)) = self.part.distance().first_hit(from, way, near, far) else { break };
            if dot(self.part.distance().normal(facet), way).abs() < GRAZING {
                near = at + self.part.step();
                continue;
            }
            let met = along(from, way, at);
            return (at, self.others.map_or(0.0, |(thin, to)| thin.growth(facet, met, to)));
        }
        (far, 0.0)
    }

    /// The hint that asks for so much, with what trying it has shown: at how many places there is room, room as long as what is thin
    /// beside it stays as it is, and none.
    pub fn tried(&self, hint: String, verb: &str, width: f64, [roomy, alone, cramped]: [usize; 3]) -> String {
        let beside = short(self.beside);
        let left = match (self.beside > 0.0, self.side) {
            (true, _) => format!("less than {beside} mm would be left beside it"),
            (false, Side::Material) => "it would meet what is beside it".to_string(),
            (false, Side::Void) => "nothing would be left beside it".to_string(),
        };
        let left = match (alone, self.side) {
            (0, _) => left,
            (_, Side::Material) => format!("{left} once what is thin there is thickened too"),
            (_, Side::Void) => format!("{left} once what is narrow there is widened too"),
        };
        match [roomy, alone + cramped] {
            [0, 0] => hint,
            [_, 0] => format!("{hint}: there is room for it, checked on the surface"),
            [0, _] => format!("{NO_ROOM} to {verb} it to {} mm: {left}", short(width)),
            [n, m] => {
                format!("{hint}: checked on the surface, there is room at {n} of {} places; elsewhere {left}", n + m)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid};
    use crate::part::Up;

    /// Two plates of 0.4 mm, upright, with a gap between their faces, and a third one beyond the second.
    fn plates(gap: f64, next: f64) -> TriangleMesh {
        let plate = |x: f64| cuboid([x, 0.0, 0.0], [x + 0.4, 10.0, 10.0]);
        plate(0.0).joined(&plate(0.4 + gap)).joined(&plate(0.8 + gap + next))
    }

    fn part(mesh: TriangleMesh) -> Part {
        Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap()
    }

    #[test]
    fn walls_that_all_grow_need_room_for_each_other() {
        let process = Process::named("fdm").unwrap();
        // Three plates of 0.4 mm that are to be 0.6 mm thick, 0.2 mm apart at the least.
        let fit = |gap: f64| {
            let part = part(plates(gap, gap));
            let question = crate::check::search::question(
                &part,
                &process,
                &crate::check::Context { refine: 64_000_000, spacing_mm: 0.1 },
                Side::Material,
                &[0.6],
            );
            let cover = part.cover(Side::Material, &question);
            let thin = Thin::of(&cover.samples, 0.3);
            let growth = Growth::new(&part, &process, Side::Material).among(&thin, 0.6);
            growth.fits_between([0.4 + gap, 0.8 + gap].map(|x| [x, 5.0, 5.0]), 0.2)
        };
        // Half on both sides of both leaves as much less; one of them alone has more room.
        assert_eq!([0.41, 0.39, 0.31, 0.29].map(fit), [Fit::Roomy, Fit::Alone, Fit::Alone, Fit::Cramped]);
    }

    #[test]
    fn the_floor_that_a_wall_stands_on_is_not_in_its_way() {
        // A blind hole as deep as the wall round it is high, so that contacts lie on the floor's height.
        let profile =
            [[0.0, 4.0], [0.5, 4.0], [0.5, 12.0], [1.1, 12.0], [1.1, 4.0], [8.0, 4.0], [8.0, 0.0], [0.0, 0.0]];
        let part = part(crate::geometry::revolved(&profile, 32).flipped());
        assert!(part.mesh().signed_volume() > 0.0);
        let growth = Growth::new(&part, &Process::named("sls").unwrap(), Side::Material);
        assert_eq!(growth.fits_between([[0.5, 0.0, 4.0], [1.1, 0.0, 4.0]], 0.1), Fit::Roomy);
        assert_eq!(growth.fits_between([[0.5, 0.0, 8.0], [1.1, 0.0, 8.0]], 0.1), Fit::Roomy);
    }

    #[test]
    fn a_wall_grows_where_the_gaps_beside_it_leave_room() {
        // fdm asks for gaps of 0.2 mm between what is fused.
        let process = Process::named("fdm").unwrap();
        for (gap, next, by, fits) in [
            (1.0, 1.0, 0.4, true),
            (0.3, 1.0, 0.4, true),
            (0.3, 0.3, 0.4, false),
            // Half on both sides.
            (0.41, 0.41, 0.4, true),
            (0.41, 0.41, 0.45, false),
        ] {
            let part = part(plates(gap, next));
            let growth = Growth::new(&part, &process, Side::Material);
            let contacts = [0.4 + gap, 0.8 + gap].map(|x| [x, 5.0, 5.0]);
            let fits = if fits { Fit::Roomy } else { Fit::Cramped };
            assert_eq!(growth.fits_between(contacts, by), fits, "{gap} {next} + {by}, {}", growth.beside);
        }
        let part = part(plates(1.0, 1.0));
        let growth = Growth::new(&part, &process, Side::Void);
        // Behind both faces of the gap stand walls of 0.4 mm, too thin to lose anything.
        let fits = growth.fits_between([[0.4, 5.0, 5.0], [1.4, 5.0, 5.0]], 0.1);
        assert!(fits == Fit::Cramped && growth.beside > 0.4);
        assert_eq!(
            growth.tried("widen".into(), "widen", 1.0, [1, 0, 0]),
            "widen: there is room for it, checked on the surface"
        );
    }
}
