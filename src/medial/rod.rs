//! Rods: material or void that is about as wide in every direction across an axis. Pins, struts; bores, passages.

use super::feature::Side;
use super::head::mark_heads;
use super::rod_end::{apex, run_out};
use super::section::{Plane, Section, across, eight_across, section};
use super::seed::Seed;
use super::waist::narrowest;
use crate::geometry::vector::{Vec3, add, along, angle, bounds, cross, distance, dot, norm2, scale, sub, unit};
use crate::geometry::{Adjacency, MeshDistance, TriangleMesh};
use rayon::prelude::*;

/// Steepest taper of a rod, as a sine: its sides draw together by at most 30 degrees.
pub(super) const TAPER: f64 = 0.2588;
/// Stations on either side of the place a rod was found at.
const STATIONS: usize = 2000;
/// Two ways across a round section differ by at most this share.
const ALIKE: f64 = 0.05;
/// A rod that thins to this share of the width searched for, and of its widest section, runs out to a point.
const POINT: f64 = 0.05;
const SHRUNK: f64 = 0.5;
/// It is followed no further than to this share of the section it was found at.
const VANISHED: f64 = 0.02;

/// Half the tangent of half a rod's steepest taper: how far before a base the balls are that touch its rim, in diameters.
const BEFORE_BASE: f64 = 0.134;

/// Planes that are tried for a section.
const TURNS: usize = 10;
/// Where the facets of a bend meet, a section this near across its grain, in radians, is one: its area is 0.05 % too large.
const JUMP: f64 = 0.03;

/// How a rod ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// With a face across it: the free end of a pin, the bottom of a blind hole.
    Closed,
    /// Into something wider.
    Open,
    /// Into something wider that nothing else holds, off the plate: the head of a pin.
    Head,
    /// With a step, beyond which a narrower rod goes on.
    Narrower,
    /// It tapers to a point.
    Point,
    /// It comes back to where it began.
    Ring,
}

/// Material or void round an axis, as long as its sections stay alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// The section of least area.
    pub narrowest: Section,
    /// The section at the other end of what runs out to a point: the mouth of a pit, the root of a spike.
    pub base: Option<Section>,
    /// Centres of sections from end to end, with their equal-area diameters.
    pub line: Vec<(Vec3, f64)>,
    /// Length of that line, caps included.
    pub length: f64,
    /// Length over which sections are alike, caps left out: short for a ball.
    pub run: f64,
    pub ends: [End; 2],
    /// Whether it is void that widens beyond both ends: however short, nothing wider passes.
    pub is_orifice: bool,
    /// Box of the line, widened by its largest radius.
    pub extent: (Vec3, Vec3),
}

impl Rod {
    /// Equal-area diameter of the narrowest section.
    pub fn diameter(&self) -> f64 {
        self.narrowest.diameter()
    }

    /// Diameter of the cylinder of equal length and volume.
    pub fn mean_diameter(&self) -> f64 {
        let volume: f64 =
            self.line.windows(2).map(|w| distance(w[0].0, w[1].0) * 0.5 * (w[0].1.powi(2) + w[1].1.powi(2))).sum();
        if self.length > 0.0 { (volume / self.length).sqrt() } else { self.diameter() }
    }

    /// Box of its sections, which end where its line does: those of circles across the line.
    pub fn sides(&self) -> (Vec3, Vec3) {
        let discs = self.line.windows(2).flat_map(|w| {
            let way = unit(sub(w[1].0, w[0].0));
            let reach = move |width: f64| way.map(|along| 0.5 * width * (1.0 - along * along).max(0.0).sqrt());
            [w[0], w[1]].into_iter().flat_map(move |(p, width)| [sub(p, reach(width)), add(p, reach(width))])
        });
        let centre = self.narrowest.centre;
        bounds(discs.chain([centre])).unwrap_or((centre, centre))
    }

    /// Whether a point is no farther from the rod's line than so many of its radii.
    pub fn nears(&self, p: Vec3, radii: f64) -> bool {
        self.line.windows(2).any(|w| {
            let d = sub(w[1].0, w[0].0);
            let t = if norm2(d) > 0.0 { (dot(sub(p, w[0].0), d) / norm2(d)).clamp(0.0, 1.0) } else { 0.0 };
            distance(p, along(w[0].0, d, t)) <= 0.5 * radii * w[0].1.max(w[1].1)
        })
    }

    /// Whether a point lies in the rod, not nearer to its side than half its radius.
    pub fn holds(&self, p: Vec3) -> bool {
        let (lo, hi) = self.extent;
        if (0..3).any(|a| p[a] < lo[a] || p[a] > hi[a]) {
            return false;
        }
        let near = |w: &[(Vec3, f64)]| {
            let d = sub(w[1].0, w[0].0);
            let t = if norm2(d) > 0.0 { dot(sub(p, w[0].0), d) / norm2(d) } else { 0.0 };
            // A little beyond both ends, so that a bent line has no gaps; what follows an end is another rod.
            (-0.1..=1.1).contains(&t) && distance(p, along(w[0].0, d, t)) <= 0.25 * w[0].1.max(w[1].1)
        };
        // A ball that touches the rim of a mouth or a root from within has its centre before it.
        let before = |m: &Section| distance(p, m.centre) <= BEFORE_BASE * m.diameter();
        self.line.windows(2).any(near) || self.base.as_ref().is_some_and(before)
    }
}

/// What rods are searched for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    pub side: Side,
    /// Largest equal-area diameter, millimetres.
    pub within: f64,
    /// Of material, the largest ratio of a section's greatest width to its least; of void, of its length to that: there 1.5 takes triangles,
    /// squares, hexagons and D-shapes, and no slots.
    pub elongation: f64,
}

impl Wanted {
    /// Whether a section is a wall's or a slot's.
    pub(super) fn is_too_long(&self, s: &Section) -> bool {
        let of = if self.side == Side::Material { s.elongation } else { s.aspect };
        of > self.elongation
    }
}

/// The surface in which rods are searched.
pub struct Search<'a> {
    pub mesh: &'a TriangleMesh,
    pub distance: &'a MeshDistance,
    pub next: &'a Adjacency,
    pub wanted: Wanted,
}

/// All rods found, and from how many places.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rods {
    pub rods: Vec<Rod>,
    /// Places of the surface from which was looked across.
    pub places: u64,
    /// Greatest distance between a facet's middle, or a place beside its corner, and one like it that was looked from instead, millimetres.
    pub spacing: f64,
}

impl Search<'_> {
    /// The rods on whose side the middle of a facet lies, or a place beside a corner of a long one, in the order of these.
    ///
    /// From each such place (one for each cell of an eighth of the width and direction) a ray goes straight across; where a second one, at
    /// right angles, meets two sides about as near, the plane of both cuts the surface in a closed curve, and the axis is turned until
    /// the normals along that curve lie in the plane. The section is then followed both ways.
    ///
    /// # Cost
    /// A few rays for each place, and the curves of what is found.
    pub fn run(&self, counts: impl Fn(usize) -> bool + Sync) -> Rods {
        let places = self.seeds(&counts);
        let ranks = self.distance.tree().ranks(self.mesh.triangles.len());
        let mut in_turn: Vec<(usize, Seed)> = places.iter().copied().enumerate().collect();
        in_turn.par_sort_unstable_by_key(|&(n, seed)| (ranks[seed.facet as usize], n));
        let across = |&(n, seed): &(usize, Seed)| Some((n, self.across(seed)?));
        let mut found: Vec<(usize, Section)> =
            in_turn.par_iter().with_min_len(64).with_max_len(256).filter_map(across).collect();
        found.sort_unstable_by_key(|(n, _)| *n);
        let mut rods: Vec<Rod> = Vec::new();
        for (_, section) in found {
            if !rods.iter().any(|r| r.holds(section.centre)) {
                rods.push(self.follow(section));
            }
        }
        self.add_orifices(&mut rods, &counts);
        if self.wanted.side == Side::Material {
            mark_heads(self, &mut rods, counts);
        }
        Rods { rods, places: places.len() as u64, spacing: self.spacing() }
    }

    /// The section across a place of the surface, if it is a rod's.
    fn across(&self, Seed { facet, at: from }: Seed) -> Option<Section> {
        let sign = self.wanted.side.sign();
        let inward = scale(self.mesh.normal(facet as usize), -sign);
        let (wide, onto) = self.distance.first_hit(from, inward, 1e-6, self.wanted.elongation * self.wanted.within)?;
        if sign * dot(self.distance.normal(onto), inward) < 0.5 {
            return None;
        }
        let c = along(from, inward, 0.5 * wide);
        let [u, v] = across(inward);
        let most = self.wanted.elongation * wide;
        // At right angles to the facet's own edges, one of which often runs along the axis, and in four more directions.
        let corners = self.mesh.corners(facet as usize);
        let edges = [0, 1, 2].map(|i| unit(cross(inward, sub(corners[(i + 1) % 3], corners[i]))));
        let lines = edges.into_iter().chain([add(u, v), u, sub(u, v), v].map(unit));
        let widths = lines.filter_map(|e| {
            let (ahead, _) = self.distance.first_hit(c, e, 0.0, most)?;
            let (behind, _) = self.distance.first_hit(c, scale(e, -1.0), 0.0, most - ahead)?;
            Some((ahead + behind, along(c, e, 0.5 * (ahead - behind)), e))
        });
        let widths: Vec<(f64, Vec3, Vec3)> = widths.collect();
        let off = |width: f64| (width / wide - 1.0).abs();
        let narrowest = widths.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let settled = |(_, middle, e): &(f64, Vec3, Vec3)| self.settled(*middle, unit(cross(inward, *e)));
        // A disc is narrowest along its axis, or slantwise; what is as wide as the first way across shows the axis first.
        let alike = widths.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0))).filter(|w| off(w.0) < ALIKE);
        alike.and_then(settled).or_else(|| settled(narrowest))
    }

    /// The section of a rod through a point, across the axis that its own side shows.
    pub(super) fn settled(&self, point: Vec3, axis: Vec3) -> Option<Section> {
        let (mut point, mut axis) = (point, axis);
        let within = 0.5 * self.wanted.elongation * self.wanted.within;
        let mut nearest: Option<(f64, Section)> = None;
        for turn in 0..TURNS {
            let (_, start) = self.distance.first_hit(point, across(axis)[0], 0.0, within)?;
            let found = section(self.mesh, self.next, Plane { point, normal: axis }, start, 1.5 * within)?;
            let off = angle(found.grain, axis);
            if off < 1e-5 || (turn > 2 && off < 1e-3) {
                return self.is_rod(&found).then_some(found);
            }
            if off > 0.9 {
                return None;
            }
            // Between two rings of a bend's facets the grain jumps: from the third turn on less and less of it is gone.
            (point, axis) = (found.centre, unit(along(scale(axis, turn.saturating_sub(1) as f64), found.grain, 1.0)));
            if nearest.as_ref().is_none_or(|n| off < n.0) {
                nearest = Some((off, found));
            }
        }
        nearest.filter(|n| n.0 < JUMP).map(|n| n.1).filter(|found| self.is_rod(found))
    }

    /// Whether a section is round enough, small enough and full.
    fn is_rod(&self, s: &Section) -> bool {
        let w = &self.wanted;
        if s.diameter() > w.within || w.is_too_long(s) || s.taper > TAPER {
            return false;
        }
        let radius = 0.5 * s.inscribed;
        eight_across(s.axis).into_iter().all(|d| {
            // From within, the first side met is the curve's own, and it looks the right way.
            let met = self.distance.first_hit(s.centre, d, 0.0, s.circumscribed);
            met.is_some_and(|(at, f)| at >= 0.99 * radius && w.side.sign() * dot(self.distance.normal(f), d) > 0.0)
        })
    }

    /// The whole rod that a section belongs to.
    fn follow(&self, seed: Section) -> Rod {
        let (mut back, first) = self.march(&seed, -1.0);
        let (mut ahead, last) = if first == End::Ring { (Vec::new(), End::Ring) } else { self.march(&seed, 1.0) };
        // What is as thin all along is a wire, wherever it was found.
        let widest = back.iter().chain(&ahead).map(Section::diameter).fold(seed.diameter(), f64::max);
        let point = (POINT * self.wanted.within).min(SHRUNK * widest);
        let [first, last] =
            [(&mut back, first), (&mut ahead, last)].map(|(way, kind)| run_out(way, point).unwrap_or(kind));
        let sections: Vec<Section> = back.into_iter().rev().chain([seed.clone()]).chain(ahead).collect();
        let base = match [first, last] {
            [End::Point, End::Open] => sections.last().cloned(),
            [End::Open, End::Point] => sections.first().cloned(),
            _ => None,
        };
        let run = sections.windows(2).map(|w| distance(w[0].centre, w[1].centre)).sum();
        let mut line: Vec<(Vec3, f64)> = sections.iter().map(|s| (s.centre, s.diameter())).collect();
        let caps = [(sections.first(), sections.get(1), first), (sections.last(), sections.iter().rev().nth(1), last)]
            .map(|(end, inner, kind)| (end, inner, if self.narrows(end, inner, kind) { End::Narrower } else { kind }));
        let [first, last] = caps.map(|c| c.2);
        let [before, after] = caps.map(|(end, inner, kind)| self.closed(end?, inner?, kind));
        let narrowest = narrowest(&sections, [before, after].map(|cap| cap.map(|c| c.0))).unwrap_or(seed);
        let narrowest = self.waist(&sections, narrowest);
        let ends = [(before, first), (after, last)].map(|(cap, kind)| if cap.is_some() { End::Closed } else { kind });
        let [before, after] = [(before, caps[0]), (after, caps[1])]
            .map(|(cap, (end, inner, kind))| cap.or_else(|| apex(end?, inner?).filter(|_| kind == End::Point)));
        let is_orifice = self.widens_beyond(&sections, ends);
        line.splice(0..0, before);
        line.extend(after);
        let length = line.windows(2).map(|w| distance(w[0].0, w[1].0)).sum();
        let radius = 0.5 * line.iter().map(|s| s.1).fold(0.0, f64::max);
        let (lo, hi) = bounds(line.iter().map(|s| s.0)).unwrap_or_default();
        let extent = (lo.map(|x| x - radius), hi.map(|x| x + radius));
        Rod { narrowest, base, line, length, run, ends, is_orifice, extent }
    }

    /// Sections after a seed in one direction, to where they stop being alike.
    fn march(&self, seed: &Section, direction: f64) -> (Vec<Section>, End) {
        let mut sections: Vec<Section> = Vec::new();
        let mut heading = scale(seed.axis, direction);
        let mut last = seed.clone();
        while sections.len() < STATIONS {
            if last.diameter() < VANISHED * seed.diameter() {
                return (sections, End::Point);
            }
            let step = 0.25 * last.diameter();
            let Some(next) = self.next_alike(&last, heading, step) else {
                // The end lies within this step: halve it.
                let (mut good, mut bad) = (0.0, step);
                let mut end = None;
                for _ in 0..12 {
                    let half = 0.5 * (good + bad);
                    match self.next_alike(&last, heading, half) {
                        Some(s) => (good, end) = (half, Some(s)),
                        None => bad = half,
                    }
                }
                sections.extend(end);
                return (sections, End::Open);
            };
            heading = if dot(next.axis, heading) < 0.0 { scale(next.axis, -1.0) } else { next.axis };
            let home = distance(next.centre, seed.centre) < 0.5 * step;
            last = next.clone();
            sections.push(next);
            if sections.len() > 12 && home {
                return (sections, End::Ring);
            }
        }
        (sections, End::Open)
    }

    /// The section a step further, if it is much like the last.
    fn next_alike(&self, last: &Section, heading: Vec3, step: f64) -> Option<Section> {
        let at = along(last.centre, heading, step);
        let next = self.settled(at, heading)?;
        let turned = angle(next.axis, heading);
        let change = (next.diameter() - last.diameter()).abs();
        let alike = distance(next.centre, at) <= 0.35 * last.diameter()
            && turned.min(std::f64::consts::PI - turned) <= 0.55
            && change <= 0.54 * step + 0.01 * last.diameter();
        (alike && dot(sub(next.centre, last.centre), heading) > 0.0).then_some(next)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geometry::{Primitive, revolved};
    use crate::units::Length;

    #[test]
    fn a_waist_between_cones_is_as_narrow_as_they_are_where_they_meet() {
        for (waist, sides) in [(0.6, 48), (0.63, 7), (0.45, 24)] {
            let hourglass =
                revolved(&[[0.0, 0.0], [waist + 1.0, 0.0], [waist, 4.1], [waist + 1.0, 8.3], [0.0, 8.3]], sides);
            let turn = std::f64::consts::TAU / sides as f64;
            let diameter = 2.0 * waist * (turn.sin() / turn).sqrt();
            let rods = rods_of(&hourglass, Side::Material, 2.5);
            let narrowest = rods.iter().map(Rod::diameter).fold(f64::INFINITY, f64::min);
            assert!((narrowest - diameter).abs() < 1e-4, "{narrowest} for {diameter}");
        }
    }

    #[test]
    fn a_round_end_is_no_neck_and_a_taper_is_narrowest_at_its_end() {
        let round = (0..=24).map(|i| (f64::from(i) * 3.75f64.to_radians()).sin_cos()).map(|(s, c)| [c, 8.0 + s]);
        let mut pin: Vec<[f64; 2]> = vec![[0.0, 0.0], [1.0, 0.0]];
        pin.extend(round);
        let (s, c) = 0.7f64.sin_cos();
        let aslant = |mesh: TriangleMesh| {
            mesh.transformed([[c, -s, 0.0], [0.6 * s, 0.6 * c, -0.8], [0.8 * s, 0.8 * c, 0.6]], [0.3, 0.1, 0.2])
        };
        let rods = rods_of(&aslant(revolved(&pin, 64)), Side::Material, 3.0);
        assert!(!rods.is_empty() && rods.iter().all(|r| (r.diameter() - 2.0).abs() < 0.02), "{rods:?}");
        let cone = revolved(&[[0.0, 0.0], [1.0, 0.0], [0.6, 3.0], [0.0, 3.0]], 64);
        let rods = rods_of(&aslant(cone), Side::Material, 3.0);
        let narrowest = rods.iter().map(Rod::diameter).fold(f64::INFINITY, f64::min);
        assert!((narrowest - 1.2).abs() < 0.02, "{rods:?}");
    }

    fn rods_of(mesh: &TriangleMesh, side: Side, within: f64) -> Vec<Rod> {
        let (distance, next) = (MeshDistance::new(mesh), Adjacency::of(mesh, |_| true));
        let wanted = Wanted { side, within, elongation: 1.5 };
        Search { mesh, distance: &distance, next: &next, wanted }.run(|_| true).rods
    }

    #[test]
    fn a_cylinder_is_one_rod_with_its_diameter_and_height() {
        let mesh = Primitive::Cylinder { radius: Length::mm(1.0), height: Length::mm(9.0) }.mesh(Length::mm(0.001));
        let rods = rods_of(&mesh, Side::Material, 3.0);
        assert_eq!(rods.len(), 1);
        let rod = &rods[0];
        assert!((rod.diameter() - 2.0).abs() < 0.002 && rod.narrowest.circumscribed >= 2.0 - 1e-9, "{rod:?}");
        assert!((rod.length - 9.0).abs() < 1e-6 && rod.ends == [End::Closed; 2], "{} {:?}", rod.length, rod.ends);
        assert!(rods_of(&mesh, Side::Void, 3.0).is_empty() && rods_of(&mesh, Side::Material, 1.9).is_empty());
    }

    /// A wire of `sides` along a line of places with unit directions, closed at its ends or joined to a ring.
    pub(crate) fn wire(line: &[(Vec3, Vec3)], radius: f64, sides: usize, ring: bool) -> TriangleMesh {
        let hoop = |k: usize| {
            let (c, d) = line[k % line.len()];
            let [u, v] = [unit(cross(d, [0.31, 0.47, 0.83])), cross(d, unit(cross(d, [0.31, 0.47, 0.83])))];
            (0..sides).map(move |n| {
                let (s, co) = (std::f64::consts::TAU * n as f64 / sides as f64).sin_cos();
                [0, 1, 2].map(|a| c[a] + radius * (co * u[a] + s * v[a]))
            })
        };
        let hoops: Vec<Vec<Vec3>> = (0..line.len()).map(|k| hoop(k).collect()).collect();
        let mut facets = Vec::new();
        for k in 0..line.len() - usize::from(!ring) {
            let (a, b) = (&hoops[k], &hoops[(k + 1) % line.len()]);
            for n in 0..sides {
                let m = (n + 1) % sides;
                facets.extend([[a[n], a[m], b[m]], [a[n], b[m], b[n]]]);
            }
        }
        if !ring {
            for n in 0..sides {
                let (first, last, m) = (&hoops[0], &hoops[line.len() - 1], (n + 1) % sides);
                facets.extend([[line[0].0, first[m], first[n]], [line[line.len() - 1].0, last[n], last[m]]]);
            }
        }
        let mesh = TriangleMesh::weld(facets);
        if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
    }

    #[test]
    fn what_bends_is_one_rod() {
        let turn = |k: usize, of: usize| (std::f64::consts::TAU * k as f64 / of as f64).sin_cos();
        for (rings, sides) in [(96, 48), (50, 12), (200, 30)] {
            let only = |line: &[(Vec3, Vec3)], ring: bool, ends: [End; 2], length: f64| {
                let rods = rods_of(&wire(line, 0.7, sides, ring), Side::Material, 2.0);
                assert!(
                    rods.len() == 1 && rods[0].ends == ends,
                    "{rings} {sides}: {:?}",
                    rods.iter().map(|r| (r.ends, r.length)).collect::<Vec<_>>()
                );
                // The line of stations cuts the bend short by its sagitta, and a ring's last step may be home early.
                assert!((rods[0].length - length).abs() < 0.01 * length, "{} {length}", rods[0].length);
            };
            let ring: Vec<_> =
                (0..rings).map(|k| turn(k, rings)).map(|(s, c)| ([5.0 * c, 5.0 * s, 0.1], [-s, c, 0.0])).collect();
            only(&ring, true, [End::Ring; 2], 10.0 * std::f64::consts::PI);
            // An elbow: 6 mm, a quarter of a round of 4 mm, 6 mm.
            let q = rings / 4;
            let mut elbow: Vec<(Vec3, Vec3)> = vec![([4.0, -6.0, 0.0], [0.0, 1.0, 0.0])];
            elbow.extend((0..=q).map(|k| turn(k, 4 * q)).map(|(s, c)| ([4.0 * c, 4.0 * s, 0.0], [-s, c, 0.0])));
            elbow.push(([-6.0, 4.0, 0.0], [-1.0, 0.0, 0.0]));
            only(&elbow, false, [End::Closed; 2], 12.0 + 2.0 * std::f64::consts::PI);
            let (around, rise) = (std::f64::consts::TAU / rings as f64, 3.0 / rings as f64);
            let coil = |k: usize| {
                let (s, c) = turn(k, rings);
                ([4.0 * c, 4.0 * s, rise * k as f64], unit([-4.0 * s * around, 4.0 * c * around, rise]))
            };
            let helix: Vec<(Vec3, Vec3)> = (0..3 * rings).map(coil).collect();
            only(&helix, false, [End::Closed; 2], (3 * rings - 1) as f64 * (4.0 * around).hypot(rise));
        }
    }

    #[test]
    fn three_and_five_sides_make_a_rod_that_no_wall_rule_sees() {
        for (sides, faced) in [(3, false), (4, true), (5, false), (6, true), (7, true), (9, true)] {
            let rods =
                rods_of(&revolved(&[[0.0, 0.0], [0.5, 0.0], [0.5, 6.0], [0.0, 6.0]], sides), Side::Material, 2.0);
            assert!(rods.len() == 1 && rods[0].narrowest.is_faced == faced, "{sides}: {rods:?}");
            let area = 0.125 * sides as f64 * (std::f64::consts::TAU / sides as f64).sin();
            assert!((rods[0].narrowest.area - area).abs() < 1e-9, "{sides}: {rods:?}");
        }
    }

    #[test]
    fn a_shaft_with_a_flat_and_a_hole_with_a_key_are_rods_of_equal_area_and_a_star_and_a_slot_are_none() {
        let arc = |from: f64, to: f64| {
            (0..=48).map(move |k| (from + (to - from) * f64::from(k) / 48.0).sin_cos()).map(|(s, c)| [0.5 * c, 0.5 * s])
        };
        let flat: f64 = (0.2f64 / 0.5).acos();
        let shaft: Vec<[f64; 2]> = arc(flat, std::f64::consts::TAU - flat).collect();
        let key = (0.15f64 / 0.5).asin();
        let mut keyed: Vec<[f64; 2]> = arc(key, std::f64::consts::TAU - key).collect();
        keyed.extend([[0.7, -0.15], [0.7, 0.15]]);
        let star = (0..12).map(|k| (f64::from(k) * 30f64.to_radians(), if k % 2 == 0 { 0.7 } else { 0.3 }));
        let star: Vec<[f64; 2]> = star.map(|(t, r)| [r * t.cos(), r * t.sin()]).collect();
        let slot = vec![[-0.5, -0.25], [0.5, -0.25], [0.5, 0.25], [-0.5, 0.25]];
        for (outline, is_rod) in [(shaft, true), (keyed, true), (star, false), (slot, false)] {
            let n = outline.len();
            let fan: Vec<[usize; 3]> = (0..n).map(|k| [k, (k + 1) % n, n]).collect();
            let outline: Vec<[f64; 2]> = outline.into_iter().chain([[0.0; 2]]).collect();
            let rods = rods_of(&extruded_with_middle(&outline, &fan, 6.0), Side::Material, 2.0);
            assert_eq!(rods.len() == 1, is_rod, "{n}: {:?}", rods.iter().map(|r| &r.narrowest).collect::<Vec<_>>());
            let area =
                (0..n).map(|k| (outline[k], outline[(k + 1) % n])).map(|(p, q)| 0.5 * (p[0] * q[1] - p[1] * q[0]));
            let area: f64 = area.sum();
            assert!(rods.iter().all(|r| (r.narrowest.area - area).abs() < 1e-9 && (r.length - 6.0).abs() < 1e-6));
        }
    }

    /// An outline, star-shaped about its last point, made a prism.
    fn extruded_with_middle(outline: &[[f64; 2]], fan: &[[usize; 3]], height: f64) -> TriangleMesh {
        let n = outline.len() - 1;
        let at = |k: usize, z: f64| [outline[k][0], outline[k][1], z];
        let caps = fan.iter().flat_map(|t| {
            [[at(t[0], height), at(t[1], height), at(t[2], height)], [at(t[1], 0.0), at(t[0], 0.0), at(t[2], 0.0)]]
        });
        let sides = (0..n).map(|k| (k, (k + 1) % n));
        let sides = sides
            .flat_map(|(k, m)| [[at(k, 0.0), at(m, 0.0), at(m, height)], [at(k, 0.0), at(m, height), at(k, height)]]);
        TriangleMesh::weld(caps.chain(sides))
    }

    #[test]
    fn a_pointed_end_is_an_end() {
        // Half angles of 20° and 53°, past what a rod may taper.
        for (tip, sides) in [(1.1, 64), (0.3, 64), (1.1, 16)] {
            let pin = revolved(&[[0.0, 0.0], [0.4, 0.0], [0.4, 6.0], [0.0, 6.0 + tip]], sides);
            let rods = rods_of(&pin, Side::Material, 2.0);
            assert!(rods.len() == 1 && rods[0].ends == [End::Closed; 2], "{tip}: {rods:?}");
            assert!((rods[0].length - 6.0 - tip).abs() < 0.05 * tip + 0.05, "{tip}: {}", rods[0].length);
        }
        // Discs on top of each other are no point, whatever they look like from afar.
        let mut stack: Vec<[f64; 2]> = vec![[0.0, 0.0]];
        stack.extend(
            (0..6).flat_map(|n| {
                [[0.6 - 0.1 * f64::from(n), f64::from(n)], [0.6 - 0.1 * f64::from(n), f64::from(n) + 1.0]]
            }),
        );
        stack.push([0.0, 6.0]);
        let rods = rods_of(&revolved(&stack, 64), Side::Material, 2.0);
        assert!(
            rods.len() > 3 && rods.iter().all(|r| r.length < 1.01),
            "{:?}",
            rods.iter().map(|r| (r.ends, r.length)).collect::<Vec<_>>()
        );
        // A nozzle opens again behind its throat, and a stem on a head does not end there.
        let nozzle = [[0.0, 0.0], [0.4, 0.0], [0.4, 6.0], [0.2, 6.6], [3.0, 8.0], [3.0, 9.0], [0.0, 9.0]];
        let rods = rods_of(&revolved(&nozzle, 64), Side::Material, 2.0);
        assert!(
            rods.iter().all(|r| r.ends.contains(&End::Open)),
            "{:?}",
            rods.iter().map(|r| r.ends).collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_plate_and_a_ball_are_no_rods() {
        let edges = [6.0, 5.0, 2.0].map(Length::mm);
        assert!(rods_of(&Primitive::Box { edges }.mesh(Length::mm(0.1)), Side::Material, 4.0).is_empty());
        let ball = Primitive::Ball { radius: Length::mm(1.0) }.mesh(Length::mm(0.01));
        assert!(rods_of(&ball, Side::Material, 4.0).iter().all(|r| r.run < 0.5 * r.diameter()));
    }

    /// A plate of `lengths` with a round hole whose side is `margin` away from two of the plate's.
    pub(crate) fn plate_with_hole(lengths: Vec3, radius: f64, margin: f64) -> TriangleMesh {
        let (centre, [x, y, z]) = (margin + radius, lengths);
        let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]].map(|p: [f64; 2]| (p[1] - centre).atan2(p[0] - centre));
        let mut angles: Vec<f64> = (0..64).map(|n| std::f64::consts::TAU * (f64::from(n) / 64.0 - 0.5)).collect();
        angles.extend(corners);
        angles.sort_by(f64::total_cmp);
        angles.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let at = |k: usize| {
            let (sin, cos) = angles[k % angles.len()].sin_cos();
            let to = |d: f64, far: f64| if d > 0.0 { (far - centre) / d } else { centre / -d.min(-1e-9) };
            let out = to(cos, x).min(to(sin, y));
            [radius, out].map(|t| [centre + t * cos, centre + t * sin])
        };
        let facets = (0..angles.len()).flat_map(|k| {
            let ([a, b], [c, d]) = (at(k), at(k + 1));
            let [low, high] = [0.0, z].map(|z| move |p: [f64; 2]| [p[0], p[1], z]);
            let quads = [
                [high(a), high(b), high(d), high(c)],
                [low(c), low(d), low(b), low(a)],
                [low(b), low(d), high(d), high(b)],
                [low(c), low(a), high(a), high(c)],
            ];
            quads.into_iter().flat_map(|[p, q, r, s]| [[p, q, r], [p, r, s]]).collect::<Vec<_>>()
        });
        TriangleMesh::weld(facets)
    }

    #[test]
    fn strips_beside_a_hole_near_a_corner_are_held_at_both_ends() {
        for (thick, margin) in [(1.2, 1.0), (1.6, 1.0), (1.6, 1.3), (2.0, 1.3)] {
            for radius in [1.6, 2.1, 2.5, 3.0] {
                let mesh = plate_with_hole([30.0, 20.0, thick], radius, margin);
                for turn in [0.0, 0.3, 0.5 * std::f64::consts::PI] {
                    let (s, c) = f64::sin_cos(turn);
                    let turned = mesh.transformed([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], [0.3, 0.1, 0.2]);
                    let rods = rods_of(&turned, Side::Material, 2.0);
                    let free = rods.iter().filter(|r| r.ends.contains(&End::Closed)).count();
                    assert_eq!(free, 0, "{thick} {margin} {radius} {turn}");
                }
            }
        }
    }

    #[test]
    fn a_square_bar_in_any_direction_is_a_rod_of_equal_area() {
        let edges = [2.0, 2.0, 12.0].map(Length::mm);
        let (s, c) = 0.7f64.sin_cos();
        let turn = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]];
        let mesh = Primitive::Box { edges }.mesh(Length::mm(0.1)).transformed(turn, [0.3, 0.1, 0.2]);
        let rods = rods_of(&mesh, Side::Material, 3.0);
        assert_eq!(rods.len(), 1, "{rods:?}");
        let n = &rods[0].narrowest;
        assert!(
            (n.inscribed - 2.0).abs() < 1e-9 && (n.circumscribed - 8f64.sqrt()).abs() < 1e-9 && n.facet_loss() == 0.0
        );
        assert!((n.area - 4.0).abs() < 1e-9 && (rods[0].length - 12.0).abs() < 1e-6, "{n:?}");
    }
}
