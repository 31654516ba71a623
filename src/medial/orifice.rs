//! Orifices: loops of edges at which a passage is narrowest, and beyond which it widens more steeply than a rod does.

use super::feature::Side;
use super::rod::{End, Rod, Search};
use super::section::{Plane, Section, across, eight_across, section, summed_up};
use crate::geometry::vector::{Vec3, add, along, angle, cross, distance, dot, norm, scale, sub, unit};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// The least bend of an edge of an orifice, radians: where both sides lean less than a rod's 15 degrees, it is a waist of one.
const BENT: f64 = 0.2618;
/// So far before and behind it, in diameters, a passage is wider than at its orifice,
const BEYOND: f64 = 0.02;
/// by this share of its area: sides that lean by 15 degrees make it 1.02.
const WIDER: f64 = 1.01;
/// A passage is open where of eight directions across its axis at least so many meet nothing
const FREE: usize = 3;
/// within this share of its greatest width from the axis.
const ASIDE: f64 = 0.55;
/// A loop that leaves its plane by more than this share of its diameter is none.
const FLAT: f64 = 0.25;
/// A loop longer than this many times the width searched for is not looked at: one of least elongation has 3.2, a slot 3.8.
const LONGEST: f64 = 6.0;

/// An edge that bends towards the side, as a facet runs along it.
#[derive(Debug, Clone, Copy)]
struct Rim {
    ends: [u32; 2],
    facet: u32,
}

/// An edge of a list, and whether it is followed against its facet.
type Directed = (u32, bool);

impl Search<'_> {
    /// Puts orifices among the rods: one within a rod is its narrowest section, any other of void a rod without length. A groove round
    /// material is the narrowest section of the rod that ends at it; off a rod it makes a wall.
    ///
    /// An orifice is a closed loop of edges, each bent towards the side searched on by 15 degrees or more, that goes round a stretch of it
    /// which is wider straight before the loop and straight behind it.
    ///
    /// # Cost
    /// The edges of the mesh, and for each loop a few rays and two plane sections.
    pub(super) fn add_orifices(&self, rods: &mut Vec<Rod>, counts: impl Fn(usize) -> bool + Sync) {
        let rims = self.rims(counts);
        for found in loops(&rims, |v| self.mesh.vertices[v as usize]) {
            let Some(narrowest) = self.orifice(&rims, &found) else { continue };
            let is_void = self.wanted.side == Side::Void;
            let within = rods.iter().position(|r| r.holds(narrowest.centre));
            match within.or_else(|| if is_void { None } else { next_to(rods, &narrowest) }) {
                Some(at) if narrowest.area < rods[at].narrowest.area => rods[at].narrowest = narrowest,
                None if is_void => rods.push(Rod::orifice(narrowest)),
                _ => {}
            }
        }
    }

    /// The edges that bend towards the side searched on by [`BENT`] or more, in order of their facets.
    fn rims(&self, counts: impl Fn(usize) -> bool + Sync) -> Vec<Rim> {
        let towards = |f: usize, e: usize| {
            let t = self.mesh.triangles[f];
            let onto = self.next.across(f as u32, e).filter(|&g| g as usize > f)?;
            let (own, other) = (self.mesh.normal(f), self.mesh.normal(onto as usize));
            let rises = dot(own, sub(self.mesh.centroid(onto as usize), self.mesh.vertices[t[e] as usize]));
            let bends = self.wanted.side.sign() * rises > 0.0 && angle(own, other) >= BENT;
            (bends && norm(own) > 0.5 && norm(other) > 0.5)
                .then_some(Rim { ends: [t[e], t[(e + 1) % 3]], facet: f as u32 })
        };
        let all = (0..self.mesh.triangles.len()).into_par_iter().filter(|&f| counts(f));
        all.flat_map_iter(|f| (0..3).filter_map(move |e| towards(f, e))).collect()
    }

    /// The section that a loop of edges bounds, if it is an orifice.
    fn orifice(&self, rims: &[Rim], found: &[Directed]) -> Option<Section> {
        let ends: Vec<(Vec3, u32)> = found
            .iter()
            .map(|&(edge, against)| {
                let rim = &rims[edge as usize];
                (self.mesh.vertices[rim.ends[usize::from(against)] as usize], rim.facet)
            })
            .collect();
        let points: Vec<Vec3> = ends.iter().map(|e| e.0).collect();
        let sides = || (0..points.len()).map(|k| (points[k], points[(k + 1) % points.len()]));
        if sides().map(|(p, q)| distance(p, q)).sum::<f64>() > LONGEST * self.wanted.within {
            return None;
        }
        let from = points[0];
        let doubled = sides().map(|(p, q)| cross(sub(p, from), sub(q, from))).fold([0.0; 3], add);
        if norm(doubled) == 0.0 {
            return None;
        }
        let point = scale(points.iter().fold([0.0; 3], |sum, p| add(sum, *p)), 1.0 / points.len() as f64);
        let plane = Plane { point, normal: unit(doubled) };
        // The facet before a corner, as along the curve of a section.
        let before: Vec<u32> = (0..ends.len()).map(|k| ends[(k + ends.len() - 1) % ends.len()].1).collect();
        let s = summed_up(self.mesh, plane, &points, &before)?;
        let off = points.iter().map(|p| dot(sub(*p, point), plane.normal).abs()).fold(0.0, f64::max);
        if s.diameter() > self.wanted.within || self.wanted.is_too_long(&s) || off > FLAT * s.diameter() {
            return None;
        }
        let away = off + BEYOND * s.diameter();
        let [ahead, behind] = [away, -away].map(|t| along(s.centre, s.axis, t));
        let is_one = self.is_free(&s, behind, 2.0 * away) && self.widens_at(ahead, &s) && self.widens_at(behind, &s);
        is_one.then_some(s)
    }

    /// Whether nothing lies along the axis of a section, from a point on it, and about halfway to its sides.
    fn is_free(&self, s: &Section, from: Vec3, far: f64) -> bool {
        let aside = across(s.axis).map(|d| scale(d, 0.25 * s.inscribed));
        let starts = [[0.01, 0.013], [1.0, 0.1], [-1.0, -0.1], [-0.1, 1.0], [0.1, -1.0]]
            .map(|[a, b]| [0, 1, 2].map(|x| from[x] + a * aside[0][x] + b * aside[1][x]));
        starts.into_iter().all(|p| self.distance.first_hit(p, s.axis, 0.0, far).is_none())
    }

    /// Whether the side searched on is wider across an axis through a point than a section there.
    fn widens_at(&self, at: Vec3, than: &Section) -> bool {
        let hits: Vec<(f64, u32)> = eight_across(than.axis)
            .into_iter()
            .filter_map(|d| {
                let (far, facet) =
                    self.distance.first_hit(at, d, 0.0, 0.75 * self.wanted.elongation * self.wanted.within)?;
                let is_within = self.wanted.side.sign() * dot(self.distance.normal(facet), d) > 0.0;
                Some((if is_within { far } else { 0.0 }, facet))
            })
            .collect();
        let near = hits.iter().filter(|h| h.0 <= ASIDE * than.circumscribed).count();
        if hits.iter().any(|h| h.0 == 0.0) {
            return false;
        }
        let around = || {
            let start = hits.first()?.1;
            section(self.mesh, self.next, Plane { point: at, normal: than.axis }, start, 2.0 * than.circumscribed)
        };
        8 - near >= FREE || around().is_some_and(|s| s.area >= WIDER * than.area)
    }

    /// Whether a passage between two open ends is wider beyond either.
    pub(super) fn widens_beyond(&self, sections: &[Section], ends: [End; 2]) -> bool {
        let (Some(first), Some(last)) = (sections.first(), sections.last()) else { return false };
        // Along their own line, which a single section has not.
        let line = sub(last.centre, first.centre);
        let outward = |s: &Section, sign: f64| {
            let sign = if dot(s.axis, line) < 0.0 { -sign } else { sign };
            along(s.centre, s.axis, sign * BEYOND * s.diameter())
        };
        self.wanted.side == Side::Void
            && ends == [End::Open; 2]
            && self.widens_at(outward(first, -1.0), first)
            && self.widens_at(outward(last, 1.0), last)
    }
}

impl Rod {
    /// A rod that is a single section.
    fn orifice(narrowest: Section) -> Self {
        let (centre, radius) = (narrowest.centre, 0.5 * narrowest.circumscribed);
        let ends = [-0.5, 0.5]
            .map(|t| (along(centre, narrowest.axis, t * BEYOND * narrowest.diameter()), narrowest.diameter()));
        Rod {
            line: ends.to_vec(),
            length: 0.0,
            run: 0.0,
            ends: [End::Open; 2],
            is_orifice: true,
            extent: (centre.map(|x| x - radius), centre.map(|x| x + radius)),
            base: None,
            narrowest,
        }
    }
}

/// The rod with an open end next to a section, no further from it than half its width.
fn next_to(rods: &[Rod], s: &Section) -> Option<usize> {
    let far = |r: &Rod| {
        let ends = [r.line.first(), r.line.last()].into_iter().zip(r.ends);
        let open = ends.filter(|e| e.1 == End::Open).filter_map(|e| Some(distance(e.0?.0, s.centre)));
        open.fold(f64::INFINITY, f64::min)
    };
    let near = rods.iter().map(far).enumerate().filter(|r| r.1 <= 0.5 * s.circumscribed);
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|r| r.0)
}

/// The closed loops that edges make where each leads to the one that turns least at its end, once for each direction in which they close.
///
/// Edges with their next ones are the graph of a function, whose cycles are found in one pass.
fn loops(rims: &[Rim], vertex: impl Fn(u32) -> Vec3) -> Vec<Vec<Directed>> {
    let mut leaving: FxHashMap<u32, Vec<Directed>> = FxHashMap::default();
    for (at, rim) in rims.iter().enumerate() {
        leaving.entry(rim.ends[0]).or_default().push((at as u32, false));
        leaving.entry(rim.ends[1]).or_default().push((at as u32, true));
    }
    let ends = |(edge, against): Directed| {
        let [a, b] = rims[edge as usize].ends;
        if against { [b, a] } else { [a, b] }
    };
    let heading = |d: Directed| unit(sub(vertex(ends(d)[1]), vertex(ends(d)[0])));
    let next = |d: Directed| {
        let on = leaving.get(&ends(d)[1])?.iter().filter(|n| n.0 != d.0);
        on.copied().min_by(|a, b| dot(heading(*b), heading(d)).total_cmp(&dot(heading(*a), heading(d))))
    };
    // The walk that an edge was first met on, from 1.
    let mut met: FxHashMap<Directed, usize> = FxHashMap::default();
    let mut found = Vec::new();
    for start in (0..rims.len() as u32).flat_map(|edge| [(edge, false), (edge, true)]) {
        let walk = met.len() + 1;
        let (mut path, mut at) = (Vec::new(), Some(start));
        while let Some(d) = at.filter(|d| !met.contains_key(d)) {
            met.insert(d, walk);
            path.push(d);
            at = next(d);
        }
        let closes = at.filter(|d| met.get(d) == Some(&walk));
        if let Some(from) = closes.and_then(|d| path.iter().position(|p| *p == d)) {
            found.push(path.split_off(from));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::feature::Side;
    use super::super::rod::{Rod, Search, Wanted};
    use crate::geometry::{Adjacency, MeshDistance, TriangleMesh, revolved};

    fn rods_of(mesh: &TriangleMesh, side: Side, within: f64) -> Vec<Rod> {
        let (distance, next) = (MeshDistance::new(mesh), Adjacency::of(mesh, |_| true));
        let wanted = Wanted { side, within, elongation: 1.5 };
        Search { mesh, distance: &distance, next: &next, wanted }.run(|_| true).rods
    }

    /// Aslant, so that nothing lies along an axis.
    fn aslant(mesh: TriangleMesh) -> TriangleMesh {
        let (s, c) = 0.7f64.sin_cos();
        mesh.transformed([[c, -s, 0.0], [0.6 * s, 0.6 * c, -0.8], [0.8 * s, 0.8 * c, 0.6]], [0.3, 0.1, 0.2])
    }

    fn round(radius: f64, sides: usize) -> f64 {
        let turn = std::f64::consts::TAU / sides as f64;
        2.0 * radius * (turn.sin() / turn).sqrt()
    }

    #[test]
    fn where_countersinks_meet_is_a_hole_whatever_lies_between() {
        for sides in [6, 24, 96] {
            // Half angles of 20°, 45° and 75°; a land of nothing, of a thousandth, of a twentieth; and flush with a face.
            for (lean, land) in [(20.0, 0.0), (45.0, 0.0), (75.0, 0.0), (45.0, 0.001), (45.0, 0.05), (20.0, 0.05)] {
                let out = 0.5 + f64::to_radians(lean).tan();
                let wide = out + 2.0;
                let mut both = vec![[out, 0.0], [wide, 0.0], [wide, 2.0 + land], [out, 2.0 + land], [0.5, 1.0 + land]];
                both.extend((land > 0.0).then_some([0.5, 1.0]));
                let flush = [[0.5, 1.0], [wide, 1.0], [wide, 2.0], [out, 2.0]];
                for outline in [&both[..], &flush[..]] {
                    let rods = rods_of(&aslant(revolved(outline, sides)), Side::Void, 1.5);
                    let found: Vec<f64> = rods.iter().filter(|r| r.is_orifice).map(Rod::diameter).collect();
                    let told = format!("{sides} {lean} {land} {}: {found:?}", outline.len());
                    assert_eq!(found.len(), 1, "{told}");
                    assert!((found[0] - round(0.5, sides)).abs() < 1e-6, "{told}");
                }
            }
        }
    }

    #[test]
    fn bores_dimples_funnels_and_edges_of_material_are_none() {
        let orifices = |outline: &[[f64; 2]]| {
            let rods = rods_of(&aslant(revolved(outline, 48)), Side::Void, 1.5);
            rods.iter().filter(|r| r.is_orifice && r.length < 0.1).count()
        };
        // A bore with chamfers, one that steps down, and a funnel whose edge leads to a narrower bore.
        let chamfered = [[0.8, 0.0], [3.0, 0.0], [3.0, 4.0], [0.8, 4.0], [0.5, 3.7], [0.5, 0.3]];
        assert_eq!(orifices(&chamfered), 0);
        assert_eq!(orifices(&[[0.5, 0.0], [3.0, 0.0], [3.0, 4.0], [0.7, 4.0], [0.7, 2.0], [0.5, 2.0]]), 0);
        assert_eq!(orifices(&[[0.3, 0.0], [3.0, 0.0], [3.0, 4.0], [2.0, 4.0], [0.6, 2.5], [0.3, 2.2]]), 0);
        // A blind dimple, straight or drawn in, and the rims of a pin and of a cone.
        for end in [0.5, 0.2] {
            let dimple = revolved(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.5, 2.0], [end, 1.7], [0.0, 1.7]], 48);
            assert!(rods_of(&aslant(dimple), Side::Void, 1.5).iter().all(|r| !r.is_orifice), "{end}");
        }
        let pin = revolved(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.5, 1.0], [0.5, 3.0], [0.2, 3.3], [0.0, 3.3]], 48);
        assert!(rods_of(&aslant(pin), Side::Void, 1.5).is_empty());
    }

    #[test]
    fn a_sharp_ridge_in_a_bore_and_a_groove_round_a_pin_are_where_they_are_narrowest() {
        let bore = [[0.6, 0.0], [3.0, 0.0], [3.0, 6.0], [0.6, 6.0], [0.6, 2.33], [0.5, 2.23], [0.6, 2.13]];
        let rods = rods_of(&aslant(revolved(&bore, 48)), Side::Void, 1.5);
        let least = rods.iter().map(Rod::diameter).fold(f64::INFINITY, f64::min);
        assert!((least - round(0.5, 48)).abs() < 1e-6, "{rods:?}");
        // Of the two halves of the pin one ends at the groove, the other on its far side.
        let pin = [[0.0, 0.0], [0.6, 0.0], [0.6, 2.13], [0.5, 2.23], [0.6, 2.33], [0.6, 6.0], [0.0, 6.0]];
        let rods = rods_of(&aslant(revolved(&pin, 48)), Side::Material, 1.5);
        let mut found: Vec<f64> = rods.iter().map(Rod::diameter).collect();
        found.sort_by(f64::total_cmp);
        assert!(found.len() == 2, "{rods:?}");
        let true_ones = [round(0.5, 48), round(0.6, 48)];
        assert!(found.iter().zip(true_ones).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}
