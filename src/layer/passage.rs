//! The round passage that a ceiling is the crown of: its axis, and its diameter across it.

use super::bridge::{Profile, Reach};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vec3, add, along, angle, cross, dot, norm, sub, unit};
use std::f64::consts::PI;

/// A wall steeper than this (89°) goes straight down.
const UPRIGHT: f64 = 89.0 * PI / 180.0;
/// What is steeper than the steepest facet of a crown goes on across the axis, and not round an end: by half a degree.
const STEEPER: f64 = 0.5 * PI / 180.0;
/// The chord of a polygon's crown falls exactly by half the difference of the slopes at its ends: within this.
const EXACT: f64 = 0.2 * PI / 180.0;
/// An arch over upright walls rises by this share of its width, and strands are level that rise by less between their ends.
pub(super) const SHALLOW: f64 = 0.05;
/// The crown of a regular polygon with twelve sides rises by 0.88 of what a circle's does; one whose top is cut flat by less.
const ROUND: f64 = 0.5;
/// Facets contain the axis whose normals have no more of it than this; while it is sought, than the first of these.
const CONTAINS: [f64; 3] = [0.3, 0.1, 0.05];

/// The diameter of a round passage across the build direction, from the chord below its crown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crown {
    /// Chord over the sine of the mean slope at its ends, midway between the facets that meet there: exact where they are those of a regular
    /// polygon, wherever its corners stand. Where walls go straight down it is the chord. No more than the circle has that has this chord and
    /// rises as far above it.
    pub diameter_mm: f64,
    /// The same with the slopes of the facets.
    pub low_mm: f64,
    pub high_mm: f64,
    /// What the facets take from the diameter: it is judged no finer.
    pub sagitta_mm: f64,
    /// The chord across the axis, level.
    pub chord_mm: f64,
    /// The level direction across the axis.
    pub across: Vec3,
    /// How much the passage rises along its axis for each millimetre in plan.
    pub grade: f64,
    /// Whether facets contain the axis: without one the diameter is that of an arch along the span, and no passage's for certain.
    pub is_straight: bool,
}

/// The directions of a passage: facets all of which contain one direction have it as their axis.
#[derive(Debug, Clone, Copy)]
struct Axis {
    along: Vec3,
    /// The level direction across it, and the one nearest to straight down.
    level: Vec3,
    down: Vec3,
}

impl Axis {
    /// The direction that most of the facets' area contains; `None` where no direction is contained in half of it, or an upright one.
    fn of(mesh: &TriangleMesh, facets: &[u32]) -> Option<Self> {
        let area = |of: &[u32]| of.iter().map(|&f| mesh.facet_area(f as usize)).sum::<f64>();
        let (mut kept, whole) = (facets.to_vec(), area(facets));
        let mut axis = [0.0; 3];
        for share in CONTAINS {
            axis = turned_about(mesh, &kept)?;
            kept = facets.iter().copied().filter(|&f| dot(mesh.normal(f as usize), axis).abs() <= share).collect();
            if area(&kept) < 0.5 * whole {
                return None;
            }
        }
        let level = cross(axis, [0.0, 0.0, 1.0]);
        let down = along([0.0, 0.0, -1.0], axis, axis[2]);
        (norm(level) > 0.5).then(|| Axis { along: axis, level: unit(level), down: unit(down) })
    }

    /// The angle at which a way goes down in the plane across the axis, towards the side that [`Axis::level`] points to.
    fn fall(&self, way: Vec3) -> f64 {
        (dot(way, self.down) / dot(way, self.level)).atan()
    }

    /// Whether a way across falls as the chord of a round crown does whose facets reach down to these slopes, on the side that
    /// [`Axis::level`] points to and on the other: it is level between sides that are equally high, and where facets end at other slopes
    /// on either side it falls by half the difference.
    fn falls_as_a_chord(&self, way: Vec3, [here, there]: [End; 2]) -> bool {
        let fall = self.fall(way);
        fall.abs() <= SHALLOW || (fall - 0.5 * (here.steepest - there.steepest)).abs() <= SHALLOW
    }

    /// How a crown ends on the side that [`Axis::level`] points to and on the other.
    fn ends(&self, mesh: &TriangleMesh, facets: &[u32], beside: &[u32]) -> Option<[End; 2]> {
        let on = |side: f64| {
            // Facets on that side look away from it.
            let leaning = move |f: &u32| {
                let normal = mesh.normal(*f as usize);
                Some(-side * dot(normal, self.level).signum() * self.slope(normal)?)
            };
            End::of(facets.iter().filter_map(leaning), beside.iter().filter_map(leaning))
        };
        let (here, there) = (on(1.0)?, on(-1.0)?);
        // Where the surface goes on beside one end alone, it is taken to go on as steeply beside the other.
        let or = |own: End, other: End| End { next: if own.next.is_finite() { own.next } else { other.next }, ..own };
        Some([or(here, there), or(there, here)])
    }

    /// The slope that a facet has across the axis: its angle from the crown's; `None` where it crosses the axis, as an end wall does.
    fn slope(&self, normal: Vec3) -> Option<f64> {
        let out = dot(normal, self.along);
        (out.abs() <= 0.5).then(|| angle(along(normal, self.along, -out), self.down))
    }
}

/// The direction about which normals turn: that of the products of each with their mean.
fn turned_about(mesh: &TriangleMesh, facets: &[u32]) -> Option<Vec3> {
    let normals = || facets.iter().map(|&f| mesh.area_vector(f as usize));
    let mean = unit(normals().fold([0.0; 3], add));
    let turns: Vec<Vec3> = normals().map(|n| cross(mean, n)).collect();
    let first = turns.iter().copied().max_by(|a, b| norm(*a).total_cmp(&norm(*b)))?;
    let sum = turns.into_iter().fold([0.0; 3], |s, t| along(s, t, dot(t, first).signum()));
    (norm(sum) > 0.0).then(|| unit(sum))
}

/// One end of an arch: the slope of its steepest facet there, and that with which the surface goes on.
#[derive(Debug, Clone, Copy)]
struct End {
    steepest: f64,
    next: f64,
}

impl End {
    /// From the slopes of the facets towards it and those of the facets beside them; `None` without any.
    fn of(slopes: impl Iterator<Item = f64>, beside: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        let steepest = slopes.fold(f64::NEG_INFINITY, f64::max);
        // Beside the border across the axis the passage is steeper; a rounded end goes on as it likes.
        let least = |from: f64| beside.clone().filter(|s| *s >= from).fold(f64::INFINITY, f64::min);
        let next = Some(least(steepest + STEEPER)).filter(|s| s.is_finite()).unwrap_or_else(|| least(0.0));
        steepest.is_finite().then_some(End { steepest, next })
    }

    /// The slope with which the surface goes on, no less steeply and down at most.
    fn outer(&self) -> f64 {
        self.next.clamp(self.steepest, (0.5 * PI).max(self.steepest))
    }

    /// The slope of a round passage at the border of its crown, the corner between the last facet that hangs and the first that does not.
    fn middle(&self) -> f64 {
        0.5 * (self.steepest + self.outer())
    }
}

/// An arch across a passage: its chord, how far it rises above it, and its ends.
#[derive(Debug, Clone, Copy)]
struct Arch {
    chord_mm: [f64; 2],
    rise_mm: f64,
    ends: [End; 2],
}

/// The round passage that a ceiling is the crown of, from its greatest span and how the surface runs above that; `beside` are the facets
/// with which the surface goes on towards the void.
///
/// A strand may cross the passage askew, as beside a slanted mouth, and the passage may climb: chord, rise and slopes are those in the plane
/// across the axis, the direction that the facets contain. Where they contain none, as in a passage that bends or narrows, they are
/// those along the span.
pub(super) fn crown(mesh: &TriangleMesh, facets: &[u32], beside: &[u32], span: Reach, above: Profile) -> Option<Crown> {
    let normal = |f: &u32| mesh.normal(*f as usize);
    let in_plan = |p: Vec3| [p[0], p[1], 0.0];
    let way = sub(in_plan(span.ends[1]), in_plan(span.ends[0]));
    let axis = Axis::of(mesh, facets);
    match axis {
        None => {
            let slope = |f: &u32| Some(angle(normal(f), [0.0, 0.0, -1.0]));
            let end = End::of(facets.iter().filter_map(slope), beside.iter().filter_map(slope))?;
            let arch = Arch { chord_mm: [span.low_mm, span.high_mm], rise_mm: above.rise_mm, ends: [end; 2] };
            arch.crown(unit(way), None)
        }
        Some(axis) => {
            let ends = axis.ends(mesh, facets, beside)?;
            let fall = axis.fall(sub(span.ends[1], span.ends[0]));
            // The greatest span of a roof with two slopes may join sides of different heights, which are no passage's.
            if !axis.falls_as_a_chord(above.tilt, ends)
                && (fall - 0.5 * (ends[0].middle() - ends[1].middle())).abs() > EXACT
            {
                return None;
            }
            let places = facets.iter().flat_map(|&f| mesh.corners(f as usize)).map(|p| dot(p, axis.level));
            let [lo, hi] = places.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], t| [lo.min(t), hi.max(t)]);
            let chord = dot(way, axis.level).abs();
            // Strands along the passage tell nothing of its width.
            if chord < 0.5 * (hi - lo) {
                return None;
            }
            let flat = axis.along[0].hypot(axis.along[1]);
            let (longer, rise_mm) = (1.0 / fall.cos(), above.rise_mm * flat * fall.cos());
            let arch = Arch { chord_mm: [chord, chord.max(hi - lo)].map(|c| c * longer), rise_mm, ends };
            let crown = arch.crown(axis.level, Some(axis.along[2].abs() / flat));
            crown.map(|crown| Crown { chord_mm: chord, ..crown })
        }
    }
}

impl Arch {
    /// The passage, if the arch rises as a crown does; its grade where its axis is known.
    fn crown(&self, across: Vec3, grade: Option<f64>) -> Option<Crown> {
        let [chord_mm, widest] = self.chord_mm;
        // The chord from a slope on one side to another on the other is that between ends that slope by their mean.
        let mean = |of: fn(&End) -> f64| 0.5 * self.ends.iter().map(of).sum::<f64>();
        let (outer, steepest) = (mean(End::outer), mean(|end| end.steepest));
        let upright = outer > UPRIGHT;
        let (middle, least) = if upright { (outer, outer) } else { (0.5 * (outer + steepest), steepest) };
        let by_slope = chord_mm / middle.sin();
        // One circle has this chord and this rise. Facets make it rise by less, so what rises by more is narrower than the slopes say: they
        // are not those of the chord's ends, as where rings of different corners meet.
        let by_rise = 0.25 * chord_mm * chord_mm / self.rise_mm.max(f64::MIN_POSITIVE) + self.rise_mm;
        let diameter_mm = by_slope.min(by_rise);
        let sagitta_mm = if upright { 0.0 } else { diameter_mm * (1.0 - (0.5 * (outer - steepest)).cos()) };
        let round = 0.5 * by_slope * (1.0 - middle.cos());
        // Any arch over upright walls is one; one that goes on at a slope is round.
        let expected = if upright { SHALLOW * chord_mm } else { ROUND * round };
        (self.rise_mm >= expected).then(|| Crown {
            diameter_mm,
            low_mm: diameter_mm.min(chord_mm / outer.sin()),
            high_mm: widest / least.sin(),
            sagitta_mm,
            chord_mm,
            across,
            grade: grade.unwrap_or(0.0),
            is_straight: grade.is_some(),
        })
    }
}
