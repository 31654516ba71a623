//! Sharp edges cut back before it is advised: a blunt face across the wedge, and how thick the material is there and behind it.

use super::rods::plain;
use crate::geometry::vector::{Vec3, add, along, cross, dot, scale, sub, unit};
use crate::medial::crease::{Crease, inward, length};
use crate::part::Part;
use crate::units::short;

/// Places along a line of edges that are tried, at least and at most.
const PLACES: (usize, usize) = (3, 24);
/// Depths that are tried where the first one does not do, and how far apart they are in wall limits.
const DEPTHS: (usize, f64) = (24, 0.25);
/// How far behind the blunt face, in wall limits, the material has to be as thick.
const BEHIND: [f64; 3] = [0.0, 0.5, 0.95];
/// A face wider than this many times the wedge, and a wall more, cuts into what stands behind it.
const WEDGE: f64 = 1.5;
/// The middle of a wedge that bends goes no farther aside than this share of a stride.
const BENT: f64 = 0.3;
/// What a ball meets within 60 degrees of the edge's own direction is the end of the edge, and no side of the wedge.
const AHEAD: f64 = 0.5;

/// A round is advised so many times wider than a wall has to be: its facets lie within it.
const ROUNDED: f64 = 1.05;

/// What cutting lines of edges back has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// The least and the greatest depth at which enough is left.
    depths: [f64; 2],
    /// How thick the material is at the blunt face, at least.
    thickness: f64,
    /// Places tried, and those with enough left.
    tried: usize,
    holding: usize,
    /// Places where the cut ends at something thicker than the wedge.
    flush: usize,
    /// Places where a rod as thick as the round that is advised fits into the edge.
    round: usize,
}

/// A place on a sharp edge.
struct Place {
    run: Vec3,
    /// The middle of the wedge, straight from each of these depths on: a point there, and the way inwards.
    middle: Vec<(f64, Vec3, Vec3)>,
    /// Half the angle of the wedge, as its tangent.
    slope: f64,
    /// How far the material reaches inwards.
    reach: f64,
}

impl Cut {
    /// Cuts a line of edges back by a depth, or by another where that leaves less than `wall`.
    ///
    /// # Cost
    /// At most a hundred rays along the wedge and 7 across at each of 24 places; 150 more at those where the depth does not do.
    pub fn of_line(part: &Part, line: &[&Crease], depth: f64, wall: f64) -> Self {
        let places = places(part, line, wall);
        let first = in_hundredths(depth);
        let own = |p: &Place| {
            // What is as wide as the wedge itself is cut where the edge was measured to be a wall; else at the least depth that does.
            let measured = p.is_left(part, first, wall) && !p.is_flush(part, first, wall);
            let others = (1..=DEPTHS.0).map(|n| in_hundredths(DEPTHS.1 * wall * n as f64));
            if measured { Some(first) } else { others.chain([first]).find(|&s| p.is_left(part, s, wall)) }
        };
        let depths: Vec<Option<f64>> = places.iter().map(own).collect();
        let found = || depths.iter().flatten().copied();
        let (least, most) = (found().fold(f64::INFINITY, f64::min), found().fold(0.0, f64::max));
        // One depth for the whole line, if it does everywhere.
        let one = places.iter().all(|p| p.is_left(part, most, wall));
        let mut cut = Cut { depths: [if one { most } else { least }, most], tried: places.len(), ..Cut::default() };
        for (place, depth) in places.iter().zip(&depths) {
            let Some(s) = depth.map(|s| if one { most } else { s }) else { continue };
            cut.holding += 1;
            cut.thickness = cut.thickness.min(place.width(part, s));
            cut.flush += usize::from(place.is_flush(part, s, wall));
            cut.round += usize::from(place.holds_rod(part, ROUNDED * s, ROUNDED * wall));
        }
        cut
    }

    /// What two lines have shown together.
    pub fn joined(self, other: Cut) -> Cut {
        Cut {
            depths: [self.depths[0].min(other.depths[0]), self.depths[1].max(other.depths[1])],
            thickness: self.thickness.min(other.thickness),
            tried: self.tried + other.tried,
            holding: self.holding + other.holding,
            flush: self.flush + other.flush,
            round: self.round + other.round,
        }
    }

    /// The depth at which enough is left at all places that were tried.
    fn enough(&self) -> Option<f64> {
        (self.tried > 0 && self.holding == self.tried).then_some(self.depths[1])
    }

    /// In words, what a cut for a thicker wall has shown beside one that holds.
    pub fn words_beside(&self, first: &Cut, wall: f64) -> String {
        let limit = short(wall);
        match (first.enough(), self.enough()) {
            (None, _) => String::new(),
            (Some(_), Some(depth)) => format!("; by {} mm for the {limit} mm that a wall should have", plain(depth)),
            (Some(_), None) => format!("; it is then a wall thinner than the {limit} mm that one should have"),
        }
    }

    /// In words, for a wall limit.
    pub fn words(&self, wall: f64) -> String {
        let limit = short(wall);
        if self.holding == 0 {
            let within = plain(DEPTHS.1 * wall * DEPTHS.0 as f64);
            return format!(
                "cutting the edge back does not help: up to {within} mm in from it the material is nowhere {limit} mm thick, checked on the \
                 surface"
            );
        }
        let [least, most] = self.depths.map(plain);
        let thick = short((self.thickness * 100.0).floor() / 100.0);
        let depth = match least == most {
            true => format!("by {most} mm, where at least {thick} mm are left"),
            false => format!("by {least} to {most} mm, to where at least {limit} mm are left"),
        };
        let flush = if self.flush < self.holding { "" } else { ", flush with what stands behind it" };
        let round = match self.round == self.tried {
            true => format!(", or round it with a radius of at least {} mm", plain(0.5 * ROUNDED * wall)),
            false => String::new(),
        };
        let tried = match self.holding == self.tried {
            true => format!("checked on the surface at {} places along it", self.tried),
            false => format!(
                "checked on the surface, that does at {} of {} places along it; elsewhere the material behind it is thinner",
                self.holding, self.tried
            ),
        };
        format!("cut the edge back {depth}{flush}{round}: {tried}")
    }
}

impl Default for Cut {
    fn default() -> Self {
        Cut { depths: [f64::INFINITY, 0.0], thickness: f64::INFINITY, tried: 0, holding: 0, flush: 0, round: 0 }
    }
}

/// A depth as it is printed, rounded up.
fn in_hundredths(depth: f64) -> f64 {
    (100.0 * depth - 1e-4).ceil() / 100.0
}

/// Places evenly over a line of edges.
fn places(part: &Part, line: &[&Crease], wall: f64) -> Vec<Place> {
    let lengths: Vec<f64> = line.iter().map(|c| length(part.mesh(), c)).collect();
    let whole: f64 = lengths.iter().sum();
    let count = ((0.5 * whole / wall).ceil() as usize).clamp(PLACES.0, PLACES.1);
    let mut found = Vec::with_capacity(count);
    let (mut next, mut passed) = (0, 0.0);
    for (crease, length) in line.iter().zip(lengths) {
        while next < count {
            let along_it = (next as f64 + 0.5) / count as f64 * whole - passed;
            if along_it > length {
                break;
            }
            found.extend(Place::on(part, crease, along_it, wall));
            next += 1;
        }
        passed += length;
    }
    found
}

impl Place {
    /// The place on an edge so far from its first end.
    fn on(part: &Part, crease: &Crease, off: f64, wall: f64) -> Option<Place> {
        let [a, b] = crease.ends.map(|v| part.mesh().vertices.get(v as usize).copied());
        let (a, run) = (a?, unit(sub(b?, a?)));
        // In the middle of a blunt edge.
        let aside = scale(part.mesh().normal(*crease.facets.first()? as usize), -0.5 * crease.blunt);
        let (at, inward) = (add(along(a, run, off), aside), inward(part.mesh(), crease)?);
        let far = (DEPTHS.0 as f64 * DEPTHS.1 + 2.0) * wall;
        let slope = (0.5 * crease.angle).tan();
        let mut place = Place { run, middle: vec![(0.0, at, inward)], slope, reach: far };
        place.follow(part, wall);
        Some(place)
    }

    /// Follows the middle of the wedge as far as it may reach, to where a line along it leaves the material.
    ///
    /// Both sides of a horn bend the same way, and a straight line into it comes out at one of them. Where the wedge ends at something wider its
    /// middle leaps aside, and is followed no further.
    fn follow(&mut self, part: &Part, wall: f64) {
        let (stride, mut near) = (DEPTHS.1 * wall, 4.0 * part.step() + 1e-4 * wall);
        let mut from = 0.0;
        while from < self.reach {
            let (p, inward) = self.at(from);
            if let Some((hit, _)) = part.distance().first_hit(p, inward, near, stride.min(self.reach - from)) {
                self.reach = from + hit;
                return;
            }
            (from, near) = (from + stride, 0.0);
            let (next, across) = (along(p, inward, stride), self.across(inward));
            let [ahead, behind] = self.sides(part, from);
            let aside = 0.5 * (ahead - behind);
            if aside.abs() > part.tie() && aside.abs() <= BENT * stride {
                let on_middle = along(next, across, aside);
                self.middle.push((from, on_middle, unit(sub(on_middle, p))));
            }
        }
    }

    /// The middle of the wedge so deep behind the edge, and the way inwards there.
    fn at(&self, depth: f64) -> (Vec3, Vec3) {
        let before = self.middle.partition_point(|m| m.0 <= depth).saturating_sub(1);
        let &(from, p, inward) = self.middle.get(before).unwrap_or(&(0.0, [0.0; 3], [0.0; 3]));
        (along(p, inward, depth - from), inward)
    }

    fn across(&self, inward: Vec3) -> Vec3 {
        unit(cross(self.run, inward))
    }

    /// Whether a cut so deep stays within the material, with a wall behind it that is nowhere thinner than asked.
    fn is_left(&self, part: &Part, depth: f64, wall: f64) -> bool {
        depth + wall <= self.reach + part.tie()
            && BEHIND.iter().all(|b| self.width(part, depth + b * wall) >= wall - part.tie())
    }

    /// Whether a cut so deep ends at something wider than the wedge.
    fn is_flush(&self, part: &Part, depth: f64, wall: f64) -> bool {
        self.width(part, depth) > 2.0 * WEDGE * depth * self.slope + wall
    }

    /// Width of the material across the wedge, so deep behind the edge.
    fn width(&self, part: &Part, depth: f64) -> f64 {
        self.sides(part, depth).iter().sum()
    }

    /// How far it is from the middle to both sides, so deep behind the edge.
    fn sides(&self, part: &Part, depth: f64) -> [f64; 2] {
        let ((from, inward), far) = (self.at(depth), 8.0 * depth + 1.0);
        let across = self.across(inward);
        [across, across.map(|x| -x)].map(|way| part.distance().first_hit(from, way, 0.0, far).map_or(far, |h| h.0))
    }

    /// Whether a rod as thick as `wall` fits there along the edge.
    fn holds_rod(&self, part: &Part, depth: f64, wall: f64) -> bool {
        let (centre, _) = self.at(depth);
        let met = part.distance().nearest(centre, 0.5 * wall - part.tie());
        met.is_none_or(|met| dot(sub(met.point, centre), self.run).abs() > AHEAD * met.distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::extruded;
    use crate::medial::crease::{Sharpness, creases};
    use crate::part::Up;

    fn sought(wall: f64) -> Sharpness {
        Sharpness { widest: std::f64::consts::FRAC_PI_3, thick: wall, blunt: 0.05 * wall, step: 1e-6 }
    }

    /// What cutting back the only sharp edge of a prism along y of 12 mm shows, with its depth.
    fn cut(outline: &[[f64; 2]], facets: &[[usize; 3]], wall: f64) -> (Cut, f64) {
        let part = Part::new(extruded(outline, facets, 12.0), Up::PlusZ, 1e-6, 1.0).unwrap();
        let found = creases(part.mesh(), part.distance(), part.adjacency(), sought(wall));
        let line: Vec<&Crease> = found.iter().collect();
        assert_eq!(line.len(), 1, "{line:?}");
        (Cut::of_line(&part, &line, line[0].depth, wall), line[0].depth)
    }

    #[test]
    fn a_wedge_is_cut_back_to_the_wall_limit_and_no_deeper() {
        for degrees in [10.0, 20.0, 45.0] {
            let half = 20.0 * (0.5f64 * degrees).to_radians().tan();
            let (cut, depth) = cut(&[[0.0, 0.0], [20.0, -half], [20.0, half]], &[[0, 1, 2]], 0.8);
            assert_eq!((cut.tried, cut.holding, cut.flush, cut.round), (8, 8, 0, 8), "{cut:?}");
            assert!(
                cut.depths[0] == cut.depths[1] && cut.depths[0] >= depth && cut.depths[0] < depth + 0.011,
                "{cut:?}"
            );
            // The blunt face is as wide as the wedge there.
            let wide = 2.0 * cut.depths[0] * (0.5 * degrees.to_radians()).tan();
            assert!((cut.thickness - wide).abs() < 1e-9 && wide >= 0.8, "{cut:?}");
            assert!(cut.words(0.8).ends_with(
                "or round it with a radius of at least 0.42 mm: checked on the surface at 8 places along it"
            ));
        }
    }

    #[test]
    fn a_blunt_edge_is_cut_back_from_its_face() {
        let half = 20.0 * 10f64.to_radians().tan();
        let outline = [[0.0, -0.01], [20.0, -half - 0.01], [20.0, half + 0.01], [0.0, 0.01]];
        let (cut, depth) = cut(&outline, &[[0, 1, 3], [1, 2, 3]], 0.8);
        assert_eq!((cut.tried, cut.holding, cut.flush, cut.round), (8, 8, 0, 8), "{cut:?}");
        let wide = 0.02 + 2.0 * cut.depths[0] * 10f64.to_radians().tan();
        assert!(
            // The middle of the face is met to a tenth of its width.
            cut.depths[0] >= depth && cut.depths[0] < depth + 0.011 && (cut.thickness - wide).abs() < 2e-3,
            "{cut:?}"
        );
    }

    #[test]
    fn a_horn_is_cut_back_to_the_wall_limit_however_its_sides_bend() {
        // What a circle of radius 9 leaves of one of radius 10, its middle 3 mm aside.
        let tip = (19.0f64 + 9.0) / 6.0;
        let (out, inner) = ((tip / 10.0).acos(), ((tip - 3.0) / 9.0).acos());
        for sides in [40, 64, 100, 150] {
            let arc = |from: f64, to: f64, r: f64, x: f64, ends: std::ops::Range<i32>| {
                let at = move |k: i32| (from + (to - from) * f64::from(k) / f64::from(sides)).sin_cos();
                ends.map(at).map(move |(s, c)| [x + r * c, r * s]).collect::<Vec<_>>()
            };
            let turn = std::f64::consts::TAU;
            // Both tips once, on the outer arc.
            let outer = arc(out, turn - out, 10.0, 0.0, 0..sides + 1);
            let back = arc(turn - inner, inner, 9.0, 3.0, 1..sides);
            let outline = [outer, back].concat();
            let n = outline.len();
            let caps: Vec<[usize; 3]> = (0..sides as usize)
                .flat_map(|k| {
                    // Across from a corner of the outer arc.
                    let [c, d] = [k, k + 1].map(|k| (n - k) % n);
                    [[k, k + 1, d], [k, d, c]]
                })
                .filter(|[a, b, c]| a != b && b != c && c != a)
                .collect();
            let part = Part::new(extruded(&outline, &caps, 6.0), Up::PlusZ, 1e-6, 1.0).unwrap();
            let found = creases(part.mesh(), part.distance(), part.adjacency(), sought(0.8));
            assert_eq!(found.len(), 2, "{sides}");
            for edge in &found {
                let cut = Cut::of_line(&part, &[edge], edge.depth, 0.8);
                let is_there = cut.holding == cut.tried && cut.depths[1] < 3.0 && cut.thickness >= 0.8 - 1e-6;
                assert!(is_there, "{sides}: {cut:?} at {}", edge.depth);
            }
        }
    }

    #[test]
    fn a_blade_thinner_than_a_wall_is_not_helped() {
        // A wedge that goes on as a sheet of 0.5 mm.
        let outline = [[0.0, 0.0], [1.0, -0.25], [30.0, -0.25], [30.0, 0.25], [1.0, 0.25]];
        let (cut, _) = cut(&outline, &[[0, 1, 4], [1, 2, 3], [1, 3, 4]], 0.8);
        assert_eq!(cut.holding, 0, "{cut:?}");
        assert!(cut.words(0.8).contains("does not help") && !cut.words(0.8).contains("cut the edge back by"));
    }

    #[test]
    fn a_wedge_too_short_for_its_depth_is_not_cut_through() {
        // A rhombus 1 mm thick in the middle: what is left of either edge is no wall.
        let outline = [[0.0, 0.0], [1.6, -0.5], [3.2, 0.0], [1.6, 0.5]];
        let part = Part::new(extruded(&outline, &[[0, 1, 3], [1, 2, 3]], 12.0), Up::PlusZ, 1e-6, 1.0).unwrap();
        let found = creases(part.mesh(), part.distance(), part.adjacency(), sought(0.8));
        let cut = Cut::of_line(&part, &[&found[0]], found[0].depth, 0.8);
        assert_eq!(cut.holding, 0, "{cut:?} {found:?}");
    }

    #[test]
    fn before_a_block_the_wedge_is_cut_off_and_the_block_is_left() {
        let outline = [[0.0, 0.0], [1.5, 0.0], [9.0, 0.0], [9.0, 6.0], [1.5, 6.0], [1.5, 0.4]];
        let (cut, measured) = cut(&outline, &[[0, 1, 5], [1, 2, 5], [2, 4, 5], [2, 3, 4]], 0.8);
        assert!(cut.holding == cut.tried && cut.depths[0] >= 1.5 && cut.depths[1] < 1.7, "{cut:?}");
        // The ball of 0.8 mm touches the flat side and the edge at (1.5, 0.4).
        assert!((measured - 1.9f64.hypot(0.4)).abs() < 1e-6, "{measured}");
    }
}
