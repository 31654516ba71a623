//! What an offset takes for good: what the opposite offset does not bring back, by the largest ball that contains a thin place.

use super::finding::{Bracket, Limits};
use super::neck::parting;
use super::sheet::Sheets;
use super::sheet_shape::Sheet;
use crate::geometry::vector::Vec3;
use crate::medial::chord::PARALLEL;
use crate::medial::inscribed::{Largest, Region, Until, largest_containing};
use crate::medial::opened::{Asked, Opened, opened};
use crate::medial::{Sample, Side};

/// A ball that is larger than that of the thin place by less than this ratio is as large.
const LARGER: f64 = 1.01;
/// Points that the first search at a sheet may look at: between even sides that are all alike it comes to no end.
const FIRST: usize = 1 << 10;
/// Bound and ball that differ by less than this share of the widest limit are one, and points that a search for the ball may look at.
const AGREE: f64 = 0.004;
const MOST: usize = 1 << 15;
/// Shares of the largest ball up to which a sheet is tried to be proved to come back, and points that the proofs of one may look at.
const PROVED: [f64; 4] = [0.985, 0.97, 0.94, 0.9];
const PROOFS: usize = 1 << 19;
/// The balls that hold a sheet are larger than those that have to pass between them by this ratio, or as large as this share of the largest, which
/// has to be more than what passes.
const PASSING: f64 = 0.99;
const WITHIN: f64 = 0.9995;
const CLOSEST: f64 = 0.998;

/// By what a thin place is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Told {
    /// By the ball that touches both its sides: how thin it is.
    AsThin,
    /// By the largest ball that contains that one's middle: at which offset it goes, and does not come back by the opposite one.
    AsGone,
}

/// What of a sheet goes first: the middle of a thin place, and the diameters between which it does.
pub(super) struct Gone {
    pub at: Vec3,
    /// Middle of the largest ball that contains it.
    pub ball: Vec3,
    pub bracket: Bracket,
}

impl Sheets<'_> {
    /// Where a sheet that is thinnest between sides that lean goes first: at half its local thickness there, or where its sides are parallel.
    ///
    /// An ellipse, a lens or a half circle is thinner beside its middle than in it. An offset larger than half of that narrows it, and the
    /// opposite one brings it back as long as a ball of the offset's radius contains the place. Where the contacts of a ball oppose each other
    /// the distance is critical, and the part becomes another as soon as the ball goes; so it does at the section of a neck, whatever larger
    /// balls on both sides contain. The upper end is a bound on the balls that contain one of the places, or lie in that section; up to the lower
    /// end all of the sheet that is as deep as its thinnest place is proved to be kept, in one piece. Where that was proved of no larger ball it
    /// may be a neck: then it goes between where it is thinnest, which is told, and that bound. `None` where it goes as soon as it is thin.
    ///
    /// # Cost
    /// A thousand nearest points for a sheet, some hundred thousand for one that larger balls contain.
    pub(super) fn gone(&self, sheet: &Sheet, samples: &[Sample], limits: Limits) -> Option<Gone> {
        let (at, thin) = (sheet.thinnest.centre, 0.5 * sheet.thinnest.diameter);
        if sheet.thinnest.separation >= PARALLEL {
            return None;
        }
        let enough = 0.5 * self.widest();
        let within = |at: Vec3, agree: f64, most: usize| {
            let ball = largest_containing(self.part.distance(), (at, 0.0), Until { enough, agree, most })?;
            (ball.radius > LARGER * thin).then_some((at, ball))
        };
        within(at, (LARGER - 1.0) * thin, FIRST)?;
        let last = |at: Vec3| within(at, AGREE * enough, MOST);
        let mut first = last(at)?;
        let parallel = samples.iter().filter(|s| s.separation >= PARALLEL);
        let narrowest = parallel.min_by(|a, b| a.diameter.total_cmp(&b.diameter));
        let critical = narrowest.filter(|s| LARGER * 0.5 * s.diameter < first.1.radius);
        if let Some(s) = critical {
            first = (s.centre, Largest { centre: s.centre, radius: 0.5 * s.diameter, ..first.1 });
        }
        let neck = parting((self.part, self.side), (&sheet.thinnest, sheet.axis), enough);
        if let Some(ball) = neck.filter(|ball| LARGER * ball.radius < first.1.radius) {
            first = (at, ball);
        }
        let (mut left, mut low) = (PROOFS, 0.5 * sheet.low);
        let mut tried = f64::INFINITY;
        while let Some(passing) = self.next_below(tried, limits, &first.1).filter(|r| *r > low) {
            tried = passing;
            let radius = (passing / PASSING).min(WITHIN * first.1.radius);
            match self.opened_by(sheet, (radius, passing), first.1.centre, &mut left) {
                Opened::Kept => low = passing,
                // A neck, or balls that pass were not found: smaller ones may.
                Opened::Parted => {}
                Opened::Open => break,
                // A place that goes before: it is as deep, and lies in smaller balls alone.
                Opened::Doubtful(at) => {
                    let before = last(at)?;
                    first = if before.1.radius < first.1.radius { before } else { first };
                }
            }
        }
        let (at, ball) = first;
        // What was not proved to be kept in one piece, by no ball larger than itself, may go as soon as it is thin.
        let is_open = low <= 0.5 * sheet.low;
        let low = critical.map_or(low, |s| low.min(0.5 * s.low.max(sheet.low)));
        let (at, told) = if is_open { (sheet.thinnest.centre, thin) } else { (at, ball.radius) };
        let bracket = Bracket::new(2.0 * told, 2.0 * low, 2.0 * ball.high);
        (ball.radius > LARGER * thin).then_some(Gone { at, ball: ball.centre, bracket })
    }

    /// The largest radius below one at which it is of use to know that a sheet comes back: of a limit, or a little less than that of a ball.
    fn next_below(&self, below: f64, limits: Limits, ball: &Largest) -> Option<f64> {
        let limits = [limits.fail, limits.warn].into_iter().flatten().map(|l| 0.5 * (l - self.part.tie()));
        let radii = limits.chain(PROVED.map(|share| share * ball.radius));
        radii.filter(|r| *r <= CLOSEST * ball.radius && *r < below).max_by(f64::total_cmp)
    }

    /// What an opening does to all of a sheet that is as deep as its thinnest place.
    fn opened_by(&self, sheet: &Sheet, (radius, passing): (f64, f64), by: Vec3, left: &mut usize) -> Opened {
        let region = Region::between(sheet.extent.0, sheet.extent.1);
        let is_on_side = |p: Vec3| (self.part.winding().at(p) > 0.5) == (self.side == Side::Material);
        opened(
            self.part.distance(),
            region,
            Asked { depth: 0.5 * sheet.low, radius, passing, by: Some(by) },
            left,
            is_on_side,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Finding;
    use super::super::offset;
    use crate::geometry::{TriangleMesh, cuboid};

    fn found(mesh: TriangleMesh, limit: f64) -> Vec<Finding> {
        offset::tests::found(mesh, &format!("{limit}mm,{limit}mm"))
    }

    /// The prism over a counter-clockwise outline that is seen from the origin, from a height to another; around it out to so many times
    /// the outline if that is given.
    fn prism_of(outline: &[[f64; 2]], [from, to]: [f64; 2], around: Option<f64>) -> TriangleMesh {
        let at = |[x, y]: [f64; 2], times: f64, z: f64| [times * x, times * y, z];
        let next = outline.iter().cycle().skip(1);
        let facets = outline.iter().zip(next).flat_map(|(&p, &q)| {
            let quad = |a, b, c, d| [[a, b, c], [a, c, d]];
            // The side nearer to the axis first: what is around an outline has its own side turned in.
            let (near, far) = around.map_or((0.0, 1.0), |times| (1.0, times));
            let [low, high] = [from, to].map(|z| [at(p, near, z), at(q, near, z), at(q, far, z), at(p, far, z)]);
            let outer = quad(low[3], low[2], high[2], high[3]);
            let caps = [quad(low[0], low[1], low[2], low[3]), quad(high[0], high[3], high[2], high[1])].concat();
            let inner = around.map_or(Vec::new(), |_| quad(low[1], low[0], high[0], high[1]).to_vec());
            [outer.to_vec(), caps, inner].concat()
        });
        let mesh = TriangleMesh::weld(facets.filter(|[a, b, c]| a != b && b != c && c != a));
        assert!(mesh.signed_volume() > 0.0);
        mesh
    }

    /// A section as a pin on a plate, as a strut between two and as a hole, turned.
    fn pin_strut_and_hole(outline: &[[f64; 2]]) -> [(TriangleMesh, &'static str); 3] {
        let rod = || prism_of(outline, [0.0, 5.0], None);
        let plate = |z: f64| cuboid([-3.0, -3.0, z], [3.0, 3.0, z + 2.0]);
        let united = |m: TriangleMesh| crate::geometry::union::united(&m, 1e-7).unwrap();
        let pin = united(plate(-1.9).joined(&rod()));
        let strut = united(plate(-1.9).joined(&rod()).joined(&plate(4.9)));
        let hole = prism_of(outline, [0.0, 5.0], Some(6.0));
        let (s, c) = 0.7f64.sin_cos();
        let rows = [[c, -s, 0.0], [0.6 * s, 0.6 * c, -0.8], [0.8 * s, 0.8 * c, 0.6]];
        [(pin, "lost"), (strut, "lost"), (hole, "closed")].map(|(m, kind)| (m.transformed(rows, [0.3, 0.1, 0.2]), kind))
    }

    /// An outline of so many corners: of a circle, drawn to other half axes.
    fn ellipse(a: f64, b: f64, corners: usize) -> Vec<[f64; 2]> {
        let turns = (0..corners).map(|k| (std::f64::consts::TAU * k as f64 / corners as f64).sin_cos());
        turns.map(|(s, c)| [a * c, b * s]).collect()
    }

    /// A cross with arms of 0.5 mm that reach so far from its middle.
    fn cross(r: f64) -> Vec<[f64; 2]> {
        let w = 0.25;
        let quarter = [[w, -w], [r, -w], [r, w]];
        (0..4).flat_map(|k| quarter.map(|[x, y]| [[x, y], [-y, x], [-x, -y], [y, -x]][k])).collect()
    }

    #[test]
    fn a_section_goes_at_the_radius_of_its_largest_ball_however_thin_it_is_beside_that() {
        let half: Vec<[f64; 2]> = (0..=24)
            .map(|k| (std::f64::consts::PI * f64::from(k) / 24.0).sin_cos())
            .map(|(s, c)| [0.55 * c, 0.55 * s - 0.25])
            .collect();
        // The largest circle in a half one touches the middle of the side across, and the arc where facets are.
        for (outline, radius, least) in [(ellipse(0.55, 0.27, 64), 0.27, 0.2695), (half, 0.275, 0.2735)] {
            for (mesh, kind) in pin_strut_and_hole(&outline) {
                let all = found(mesh.clone(), 0.3);
                let told: Vec<(&str, f64, f64, f64)> =
                    all.iter().map(|f| (f.kind.as_str(), f.value, f.low, f.high)).collect();
                assert!(told.len() == 1 && told[0].0 == kind, "{radius}: {told:?}");
                let (_, value, low, high) = told[0];
                assert!(least <= high && low <= radius + 1e-6 && low > 0.98 * least, "{radius}: {told:?}");
                assert!(least - 1e-4 <= value && value <= radius + 1e-6, "{radius}: {told:?}");
                assert_eq!(found(mesh, 0.98 * least), [], "{radius}");
            }
        }
    }

    #[test]
    fn what_an_offset_narrows_and_the_opposite_one_brings_back_is_not_lost() {
        for outline in [ellipse(0.7, 0.32, 64), ellipse(0.96, 0.32, 96)] {
            for (mesh, kind) in pin_strut_and_hole(&outline) {
                assert_eq!(found(mesh, 0.3), [], "{kind} {:?}", outline.first());
            }
        }
    }

    /// A neck of an odd number of sides, in a hole and in a pin: no two of its sides oppose each other, and it goes all the same.
    #[test]
    fn a_neck_goes_at_its_own_radius_though_larger_balls_on_both_sides_hold_all_of_it() {
        for sides in [7, 11, 25, 31] {
            let neck = 0.25 * (std::f64::consts::PI / f64::from(sides)).cos();
            let hole = [[0.75, 0.0], [3.0, 0.0], [3.0, 1.0], [0.75, 1.0], [0.25, 0.5]];
            let pin = [
                [0.0, 0.0],
                [3.0, 0.0],
                [3.0, 1.0],
                [1.5, 1.0],
                [0.25, 2.0],
                [1.5, 3.0],
                [3.0, 3.0],
                [3.0, 4.0],
                [0.0, 4.0],
            ];
            for (outline, kind) in [(&hole[..], "closed"), (&pin[..], "lost")] {
                let all = found(crate::geometry::revolved(outline, sides as usize), 0.3);
                let told: Vec<(&str, f64, f64, f64)> =
                    all.iter().map(|f| (f.kind.as_str(), f.value, f.low, f.high)).collect();
                let tells = |t: &(&str, f64, f64, f64)| {
                    let holds = t.2 > 0.9 * neck && t.2 <= neck + 1e-6 && neck <= t.3 + 1e-6 && t.3 < 1.01 * neck;
                    t.0 == kind && (t.1 - neck).abs() < 1e-3 && holds
                };
                assert!(told.iter().any(tells), "{sides} {kind}: {neck} {told:?}");
            }
        }
    }

    #[test]
    fn arms_that_stay_lost_and_bridges_that_part_are_told_as_thin_as_they_are() {
        // Short arms and arms 2 mm long, an L, a T with a web of 0.3 mm, and two round halves that meet in 0.3
        // and in 0.5 mm.
        let l = [[-0.25, -0.25], [0.9, -0.25], [0.9, 0.25], [0.25, 0.25], [0.25, 0.9], [-0.25, 0.9]];
        let letter = [
            [0.15, -0.25],
            [1.0, -0.25],
            [1.0, 0.25],
            [-1.0, 0.25],
            [-1.0, -0.25],
            [-0.15, -0.25],
            [-0.15, -1.5],
            [0.15, -1.5],
        ];
        let lobes = |half: f64| {
            let end = std::f64::consts::PI - (half / 0.3).asin() - 0.03;
            let side = |sign: f64| {
                let turns = (0..=24).map(move |k| end * (f64::from(k) / 12.0 - 1.0));
                turns.map(move |t: f64| [sign * (0.35 + 0.3 * t.cos()), sign * 0.3 * t.sin()])
            };
            side(1.0).chain([[0.0, half]]).chain(side(-1.0)).chain([[0.0, -half]]).collect()
        };
        for (outline, radius) in [
            (cross(0.6), 0.25),
            (cross(2.25), 0.25),
            (l.to_vec(), 0.25),
            (letter.to_vec(), 0.15),
            (lobes(0.15), 0.15),
            (lobes(0.25), 0.25),
        ] {
            for (mesh, kind) in pin_strut_and_hole(&outline) {
                let all = found(mesh, 0.31);
                let told: Vec<(&str, f64)> = all.iter().map(|f| (f.kind.as_str(), f.value)).collect();
                assert!(!told.is_empty() && told.iter().all(|t| t.0 == kind), "{radius}: {told:?}");
                assert!((told[0].1 - radius).abs() < 1e-3, "{radius}: {told:?}");
            }
        }
    }
}
