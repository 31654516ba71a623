//! Holes, pins and struts that are thinner on one side of their section than the largest ball in it: how they go as a whole.

use super::finding::Limits;
use super::sheet::Sheets;
use super::sheet_shape::Sheet;
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, along, angle, cross, distance, dot, norm, scale, sub, unit};
use crate::medial::chord::PARALLEL;
use crate::medial::inscribed::{Largest, Place, Region, Until, largest_ball};
use crate::medial::section::{Plane, across, outlined};
use crate::medial::{Sample, Side};

/// A section is looked at as far as so many of the widest limit from where it is thin.
const WITHIN: f64 = 8.0;
/// The sides of a rod draw together by at most this sine along its axis, and its axis is known as well, radians.
const TAPER: f64 = 0.2588;
const ALIGNED: f64 = 0.05;
/// A ball is larger than another if it is by this, millimetres: four decimals are shown.
const LARGER: f64 = 1e-4;
/// How well bound and ball agree at first, as a share of the ball, and at last, as a share of the limit.
const COARSE: f64 = 0.02;
const FINE: f64 = 0.002;
/// Points that a first look at a section takes, one for its largest ball, and one behind a place.
const FIRST: usize = 1 << 10;
const MOST: usize = 1 << 14;
const BEHIND: usize = 1 << 10;
/// Places of a sheet that are looked across from, beside the thinnest.
const STARTS: usize = 3;
/// Places of a sheet that are looked behind, and those that are looked at at all.
const LOOKED_BEHIND: usize = 24;
const LOOKED_AT: usize = 512;
/// Stations of a line on each side, their distance in radii, and how often their balls are made larger.
const STATIONS: usize = 400;
const STRIDE: f64 = 0.5;
const CLIMBS: usize = 60;
/// Beyond a station whose ball is so much larger the rod has opened into something wider.
const OPENED: f64 = 1.5;
/// A line's clearance is known to this share of the limit, and to the finer one where a limit lies as near.
const CLEAR: f64 = 0.004;
const FINEST: f64 = 5e-4;
/// Places on a way between two balls.
const ON_THE_WAY: usize = 24;
/// An even wall is a web of a section whose largest ball is wider by more than this ratio.
const WEB: f64 = 1.25;
/// What of a sheet is no farther from a rod's line than so many radii of its section lies on the rod.
const ON_ROD: f64 = 1.2;

/// Where a sheet goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goes {
    /// Where it is thinnest.
    AtThinnest,
    /// With all of its section, where that holds a larger ball and nothing comes apart before.
    AsAWhole,
}

/// A closed section of a rod, seen from a place in it.
struct Closed {
    axis: Vec3,
    middle: Vec3,
    /// Of the circle about its middle.
    radius: f64,
    outline: Vec<Vec3>,
}

/// A ball about a point of a line along a rod: where on the axis, its centre and its radius.
type Station = (f64, Vec3, f64);

impl Sheets<'_> {
    /// A sheet as the section that it is part of goes, if that is the section of a hole, a pin or a strut with a larger ball in it; `None` where it
    /// goes as it is.
    ///
    /// A ball between two sides that lean is no place where an offset changes anything: beside it there is a larger one. What goes with
    /// the section's largest ball is the whole of it, unless a place of the sheet is a bridge, with larger balls before and behind it. Where a limit is less than
    /// that ball, what is thinner than the limit has to lie in balls of the limit's radius: then the opposite offset brings it back. So has an even web that is
    /// much thinner than the whole.
    ///
    /// # Limits
    /// Bridges are looked for at two dozen places of the sheet.
    ///
    /// # Cost
    /// Some thousand nearest points for a sheet in a closed section, some ten thousand where there is a larger ball.
    pub(super) fn as_a_whole(&self, sheet: &Sheet, samples: &[Sample], limits: Limits) -> Option<Sheet> {
        // Of two even sides any place may be the thinnest, and the one that is told may lie at the rim of a mouth.
        let others = samples.iter().skip(samples.len() / (2 * STARTS)).step_by(samples.len().div_ceil(STARTS).max(1));
        let starts = [&sheet.thinnest].into_iter().chain(others);
        starts
            .flat_map(|s| self.axes(s).into_iter().map(move |axis| (s, axis)))
            .find_map(|(from, axis)| self.gone_along((from, axis), sheet, samples, limits))
    }

    /// The same, if the rod runs along an axis where it is looked across from a place of the sheet.
    fn gone_along(
        &self,
        (from, axis): (&Sample, Vec3),
        sheet: &Sheet,
        samples: &[Sample],
        limits: Limits,
    ) -> Option<Sheet> {
        let thin = &sheet.thinnest;
        let (radius, widest) = (0.5 * thin.diameter, 0.5 * self.widest());
        let first = Until { enough: f64::INFINITY, agree: COARSE * radius, most: FIRST };
        let closed = self.closed(from.centre, axis, sub(from.contacts[0], from.centre))?;
        let ball = self.largest(&closed, closed.all(), first, |_| true)?;
        if ball.radius <= radius + LARGER {
            return None;
        }
        let last = Until { enough: widest, agree: FINE * widest, most: MOST };
        let mut ball = self.largest(&closed, closed.all(), last, |_| true)?;
        let line = self.line(&closed, &ball, samples);
        let narrowest = *line.iter().min_by(|a, b| a.2.total_cmp(&b.2))?;
        if narrowest.2 < ball.radius - FINE * widest {
            let there = self.closed(narrowest.1, closed.axis, across(closed.axis)[0])?;
            ball = self.largest(&there, there.all(), last, |_| true)?;
        }
        if ball.radius <= radius + LARGER {
            return None;
        }
        let stride = samples.len().div_ceil(LOOKED_AT).max(1);
        let own: Vec<&Sample> = samples.iter().step_by(stride).chain([thin]).collect();
        let is_on_rod = |s: &&Sample| {
            let near = line.iter().map(|at| distance(at.1, s.centre)).fold(f64::INFINITY, f64::min);
            near <= ON_ROD * closed.radius + radius
        };
        let goes = own.iter().all(is_on_rod) && self.comes_back(&own, &line, limits, ball.radius);
        if !goes || self.has_bridge(&own, &closed, &line) {
            return None;
        }
        let kept = self.radii(limits).filter(|limit| *limit <= ball.radius).fold(0.0, f64::max);
        let agree = (0.5 * (ball.radius - kept)).clamp(FINEST * widest, CLEAR * widest);
        let low = self.clearance(&line, agree).min(ball.radius);
        let contacts = self.contacts(ball.centre, ball.radius)?;
        let (diameter, low, high) = (2.0 * ball.radius, 2.0 * low, 2.0 * ball.high);
        let thinnest = Sample { centre: ball.centre, contacts, diameter, low, ..*thin };
        Some(Sheet { thinnest, low, section_ball: Some(high), ..sheet.clone() })
    }

    /// Directions that the axis of the rod may have whose side a ball touches: across both ways to its contacts, and along the edges there.
    fn axes(&self, s: &Sample) -> Vec<Vec3> {
        let between = cross(sub(s.contacts[0], s.centre), sub(s.contacts[1], s.centre));
        let edges = [s.facet, s.opposite].into_iter().flat_map(|f| {
            let [a, b, c] = self.part.distance().corners(f);
            [sub(b, a), sub(c, b), sub(a, c)]
        });
        let leans = norm(between) > ALIGNED * (0.5 * s.diameter).powi(2);
        let mut axes: Vec<Vec3> = Vec::new();
        for axis in leans.then_some(between).into_iter().chain(edges).map(unit).filter(|a| norm(*a) > 0.5) {
            if axes.iter().all(|known| dot(*known, axis).abs() < ALIGNED.cos()) {
                axes.push(axis);
            }
        }
        axes
    }

    /// The closed section through a point across an axis, if the sides along it hardly lean to that; a side lies in a direction from the point.
    fn closed(&self, point: Vec3, axis: Vec3, towards: Vec3) -> Option<Closed> {
        let within = WITHIN * self.widest();
        let level = along(towards, axis, -dot(towards, axis));
        if norm(level) < 0.5 * norm(towards) {
            return None;
        }
        let (_, start) = self.part.distance().first_hit(point, unit(level), 0.0, within)?;
        let plane = Plane { point, normal: axis };
        let (found, outline) = outlined(self.part.mesh(), self.part.adjacency(), plane, start, within)?;
        let off = angle(found.grain, axis);
        let is_across = off.min(std::f64::consts::PI - off) <= ALIGNED && found.taper <= TAPER;
        is_across.then_some(Closed { axis, middle: found.centre, radius: 0.5 * found.circumscribed, outline })
    }

    /// The largest ball about a point of a section in a region of its plane.
    fn largest(&self, closed: &Closed, region: Region, until: Until, counts: impl Fn(Vec3) -> bool) -> Option<Largest> {
        let place = |p: Vec3, _: &Nearest| {
            let is_within = counts(p) && closed.holds(p) && self.is_on_side(p);
            if is_within { Place::Within } else { Place::Off }
        };
        largest_ball(self.part.distance(), region, until, place)
    }

    fn is_on_side(&self, p: Vec3) -> bool {
        (self.part.winding().at(p) > 0.5) == (self.side == Side::Material)
    }

    fn radius_at(&self, p: Vec3) -> f64 {
        self.part.distance().nearest(p, f64::INFINITY).map_or(0.0, |n| n.distance)
    }

    /// Balls along a rod both ways from one in its section, as far as the samples reach, without those that a face across is as near to as the sides.
    fn line(&self, closed: &Closed, ball: &Largest, samples: &[Sample]) -> Vec<Station> {
        let at = |p: Vec3| dot(sub(p, ball.centre), closed.axis);
        let ends = samples.iter().map(|s| at(s.centre));
        let (lo, hi) = ends.fold((0.0, 0.0), |(lo, hi): (f64, f64), t| (lo.min(t), hi.max(t)));
        let march = |sign: f64, far: f64| {
            let way = scale(closed.axis, sign);
            let mut stations: Vec<Station> = Vec::new();
            let (mut centre, mut radius) = (ball.centre, ball.radius);
            while stations.len() < STATIONS && sign * at(centre) < far {
                let step = STRIDE * ball.radius;
                // A face across, as near as the sides would be.
                if self.part.distance().first_hit(centre, way, 0.0, step + radius).is_some() {
                    break;
                }
                (centre, radius) = self.climbed(along(centre, way, step), closed.axis);
                if radius > OPENED * ball.radius || !self.is_on_side(centre) {
                    break;
                }
                stations.push((at(centre), centre, radius));
            }
            stations
        };
        let (back, ahead) = (march(-1.0, -lo), march(1.0, hi));
        back.into_iter().rev().chain([(0.0, ball.centre, ball.radius)]).chain(ahead).collect()
    }

    /// A ball made larger by moving its centre across an axis.
    fn climbed(&self, mut centre: Vec3, axis: Vec3) -> (Vec3, f64) {
        let [u, v] = across(axis);
        let ways = [u, v, unit(along(u, v, 1.0)), unit(along(u, v, -1.0))];
        let mut radius = self.radius_at(centre);
        let mut step = 0.25 * radius;
        for _ in 0..CLIMBS {
            if step < 0.1 * LARGER {
                break;
            }
            let tries = ways.iter().flat_map(|way| [-step, step].map(|t| along(centre, *way, t)));
            let best = tries.map(|p| (p, self.radius_at(p))).max_by(|a, b| a.1.total_cmp(&b.1));
            match best {
                Some(larger) if larger.1 > radius => (centre, radius) = larger,
                _ => step *= 0.5,
            }
        }
        (centre, radius)
    }

    /// A radius that balls about all points of a line have for certain: the distance to the surface changes by no more than the way.
    fn clearance(&self, line: &[Station], agree: f64) -> f64 {
        let least = line.iter().map(|s| s.2).fold(f64::INFINITY, f64::min);
        let mut open: Vec<[(Vec3, f64); 2]> = line.windows(2).map(|w| [(w[0].1, w[0].2), (w[1].1, w[1].2)]).collect();
        let mut low = least;
        while let Some([a, b]) = open.pop() {
            let apart = distance(a.0, b.0);
            let bound = 0.5 * (a.1 + b.1 - apart);
            if bound >= least - agree || apart <= agree {
                low = low.min(bound);
                continue;
            }
            let middle = [0, 1, 2].map(|x| 0.5 * (a.0[x] + b.0[x]));
            let middle = (middle, self.radius_at(middle));
            open.extend([[a, middle], [middle, b]]);
        }
        low.max(0.0)
    }

    /// The radii of balls as wide as the limits.
    fn radii(&self, limits: Limits) -> impl Iterator<Item = f64> + use<> {
        let tie = self.part.tie();
        [limits.fail, limits.warn].into_iter().flatten().map(move |limit| 0.5 * (limit - tie))
    }

    /// Whether all that is thinner than a limit, where the whole is not, lies in balls of that limit's radius, and all even webs in balls of the
    /// whole's: the opposite offset brings it back.
    fn comes_back(&self, samples: &[&Sample], line: &[Station], limits: Limits, whole: f64) -> bool {
        let kept = self.radii(limits).filter(|limit| *limit <= whole).map(|limit| (limit, limit));
        // What is even and much thinner than the whole is a web or an arm, and is lost before it unless it comes back too.
        let web = (whole - LARGER, whole / WEB);
        let axis = line.first().zip(line.last()).map_or([0.0; 3], |(a, b)| unit(sub(b.1, a.1)));
        kept.chain([web]).all(|(limit, below)| {
            let is_even = |s: &Sample| below == limit || s.separation >= PARALLEL;
            samples.iter().filter(|s| 0.5 * s.diameter < below && is_even(s)).all(|s| {
                let off = |at: &Station| dot(sub(at.1, s.centre), axis).abs();
                let wide = line.iter().filter(|at| at.2 >= limit);
                let nearest = wide.min_by(|a, b| off(a).total_cmp(&off(b)));
                nearest.is_some_and(|at| {
                    let way = sub(at.1, s.centre);
                    let steps = (1..=ON_THE_WAY).map(|k| k as f64 / ON_THE_WAY as f64);
                    steps
                        .map(|t| (t * norm(way), along(s.centre, way, t)))
                        .any(|(far, p)| far <= limit && self.radius_at(p) >= limit)
                })
            })
        })
    }

    /// Whether balls are larger on both sides of a place, away from the line and towards it: there the section comes apart.
    fn has_bridge(&self, samples: &[&Sample], closed: &Closed, line: &[Station]) -> bool {
        let stride = samples.len().div_ceil(LOOKED_BEHIND).max(1);
        // The thinnest is the last.
        samples.iter().rev().step_by(stride).any(|s| {
            let off = |at: &Station| dot(sub(at.1, s.centre), closed.axis).abs();
            let Some(at) = line.iter().min_by(|a, b| off(a).total_cmp(&off(b))) else { return false };
            let radius = self.radius_at(s.centre);
            let way = sub(at.1, s.centre);
            let level = along(way, closed.axis, -dot(way, closed.axis));
            if at.2 <= radius + LARGER || norm(level) <= LARGER {
                return false;
            }
            let back = scale(unit(level), -1.0);
            let Some(here) = self.closed(s.centre, closed.axis, back) else { return false };
            let far = here.radius;
            let region = Region {
                centre: along(s.centre, back, far),
                axes: [back, cross(here.axis, back), here.axis],
                half: [far, 2.0 * far, 0.0],
            };
            let until = Until { enough: radius + 2.0 * LARGER, agree: LARGER, most: BEHIND };
            let behind = self.largest(&here, region, until, |p| dot(sub(p, s.centre), back) >= 0.0);
            behind.is_some_and(|b| b.radius > radius + LARGER)
        })
    }

    /// Where a ball touches the surface, and where that is met on the other side of it.
    fn contacts(&self, centre: Vec3, radius: f64) -> Option<[Vec3; 2]> {
        let near = self.part.distance().nearest(centre, f64::INFINITY)?;
        let back = unit(sub(centre, near.point));
        let far = self.part.distance().first_hit(centre, back, 0.0, 3.0 * radius).map_or(radius, |hit| hit.0);
        Some([near.point, along(centre, back, far)])
    }
}

impl Closed {
    /// The square about all of it.
    fn all(&self) -> Region {
        let [u, v] = across(self.axis);
        Region { centre: self.middle, axes: [u, v, self.axis], half: [self.radius, self.radius, 0.0] }
    }

    /// Whether a point of its plane lies within its outline.
    fn holds(&self, p: Vec3) -> bool {
        let [u, v] = across(self.axis);
        let flat = |q: &Vec3| [dot(sub(*q, p), u), dot(sub(*q, p), v)];
        let next = self.outline.iter().cycle().skip(1);
        let crossed = self.outline.iter().zip(next).filter(|(a, b)| {
            let ([ax, ay], [bx, by]) = (flat(a), flat(b));
            (ay > 0.0) != (by > 0.0) && ax + (bx - ax) * ay / (ay - by) > 0.0
        });
        crossed.count() % 2 == 1
    }
}
