//! Fillets laid into concave edges before they are advised: a ball that rests on both faces and meets nothing else.

use super::fillet_section::{Section, added, turns};
use super::resting::{Ball, Descent, GROOVE};
use super::shared_corner::{Corners, run};
use crate::geometry::distance::Nearest;
use crate::geometry::vector::{Vec3, along, angle, cross, distance, dot, norm, scale, sub, unit};
use crate::medial::reflex::ReflexEdge;
use crate::part::Part;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Places along an edge at which the ball is laid in, at most.
const PLACES: usize = 9;
/// Radii between two such places.
const APART: f64 = 4.0;
/// A face that ends, or bends away by more than this share of the radius, before the ball touches it carries no fillet.
const CONTACT: f64 = 0.1;
/// What a ball meets within 60 degrees of the edge's own direction is a wall at its end, from which it keeps away.
const AHEAD: f64 = 0.5;
/// A facet is touched on its inside if the way to the ball's centre is its normal, but for this angle, radians (15°).
const SQUARE: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// A ball within this share of its radius of a face touches it.
const RESTING: f64 = 1.02;
/// Rays towards the surface under a ball reach so many times the height of its centre.
const GAPING: f64 = 1.1;
/// Radii below the one asked for that are tried where that one has no room.
const STEPS: u32 = 10;

/// Fillets in a part.
#[derive(Clone, Copy)]
pub struct Fillets<'a>(pub &'a Part);

/// How far fillets of a radius fit into a set of edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Laid {
    /// Length over which it fits, millimetres.
    pub fitting: f64,
    /// Whether it fits at every place that was tried.
    pub everywhere: bool,
    /// What it adds there, mm³.
    pub volume: f64,
    /// A radius that fits where the asked one does not, to a tenth of that; 0 if none was found.
    pub elsewhere: f64,
}

impl Fillets<'_> {
    /// Lays fillets of a radius into edges.
    ///
    /// A ball that fits leaves a void of its own width: no slot or hole narrower than that is filled.
    ///
    /// # Cost
    /// At most 36 looks at the surface for an edge, a few hundred where its faces are bent, and as many for each of four smaller radii where
    /// one does not fit.
    pub fn lay(&self, edges: &[ReflexEdge], radius: f64) -> Laid {
        let corners = Corners::new(self.0, radius, edges);
        let shares: Vec<(f64, Section)> = edges.par_iter().map(|e| self.share(e, &corners)).collect();
        let mut laid = Laid { fitting: 0.0, everywhere: true, volume: 0.0, elsewhere: radius };
        let mut cramped = Vec::new();
        for ((edge, (share, section)), turns) in edges.iter().zip(shares).zip(turns(self.0, edges)) {
            laid.fitting += share * edge.length;
            laid.volume += share * added(edge, &section, &turns);
            if share < 1.0 {
                cramped.push(*edge);
            }
        }
        if !cramped.is_empty() {
            laid = Laid { everywhere: false, elsewhere: self.largest(&cramped, radius), ..laid };
        }
        laid
    }

    /// The largest tenth of a radius, below all of it, that fits everywhere.
    fn largest(&self, edges: &[ReflexEdge], radius: f64) -> f64 {
        let of = |step: u32| radius * f64::from(step) / f64::from(STEPS);
        let (mut fits, mut fails) = (0, STEPS);
        while fails - fits > 1 {
            let step = (fits + fails) / 2;
            let corners = Corners::new(self.0, of(step), edges);
            if edges.par_iter().all(|e| self.share(e, &corners).0 == 1.0) { fits = step } else { fails = step }
        }
        of(fits)
    }

    /// The share of the places along an edge at which a ball rests in it, and the mean of the cross-sections that it fills there.
    fn share(&self, edge: &ReflexEdge, corners: &Corners) -> (f64, Section) {
        let radius = corners.radius;
        let places = ((edge.length / (APART * radius)).ceil() as usize).clamp(1, PLACES);
        let at = |n: usize| edge.length * ((n as f64 + 0.5) / places as f64 - 0.5);
        let even = Section::between_planes(edge, radius);
        let section = |off: f64| match self.rests(edge, off, radius) {
            true => Some(even),
            false => self.section_on_bent_faces(edge, off, corners),
        };
        let sections: Vec<Section> = (0..places).filter_map(|n| section(at(n))).collect();
        (sections.len() as f64 / places as f64, Section::mean(&sections))
    }

    /// The cross-section that a ball fills which comes to rest on both faces beside an edge, so far from its middle, where these bend
    /// away from the planes of its facets, or towards the ball before it touches them; none if it does not rest on two faces there, or something lies
    /// behind it. Edges of one corner have equal parts of it.
    fn section_on_bent_faces(&self, edge: &ReflexEdge, off: f64, corners: &Corners) -> Option<Section> {
        let (surface, run, radius) = (self.0.distance(), run(self.0, edge), corners.radius);
        let foot = along(edge.middle, run, off);
        let centre = Ball { part: self.0, radius, descent: Descent::Straight }.rest(foot, edge.outward(), 0.0)?;
        let down = sub(foot, centre);
        let (height, beside) = (norm(down), unit(cross(run, down)));
        let behind = surface.first_hit(foot, scale(down, -1.0 / height), 4.0 * self.0.step() + 1e-6 * radius, height);
        let across = |met: &Nearest| {
            let way = sub(met.point, centre);
            along(way, run, -dot(way, run))
        };
        let contact = |side: f64| {
            let met =
                surface.nearest_where(centre, RESTING * radius, |_, q| side * dot(sub(q, centre), beside) > 0.0)?;
            let is_across = dot(sub(met.point, centre), run).abs() < AHEAD * radius;
            (is_across && self.is_on_round(&met, centre)).then_some(met)
        };
        let contacts = [contact(1.0)?, contact(-1.0)?];
        let ways = contacts.each_ref().map(|met| unit(across(met)));
        // Between planes the ball touches them so far from the edge: on faces that bend away it sinks nearer to it. What it touches further out are the
        // sides of a groove that it would fill, but where all between bends towards it.
        let reach = radius * ((0.5 * edge.bend).tan() + CONTACT);
        let is_near = contacts.iter().all(|met| distance(met.point, foot) <= reach);
        let turn = angle(ways[0], ways[1]);
        if behind.is_some() || !(is_near || self.covers(foot, &contacts, (radius, turn))) {
            return None;
        }
        let deepest = if is_near { height } else { height.max(radius / (0.5 * turn).cos()) };
        let towards = |d: Vec3| surface.first_hit(centre, d, 0.0, GAPING * deepest).map_or(radius, |(far, _)| far);
        let whole = Section::under_a_ball(scale(down, -1.0), ways, radius, towards);
        Some(if is_near { whole } else { whole.shared_by(corners.holding(centre)) })
    }

    /// Whether a ball that touches two faces, turned by so much from each other, covers all between them: from an edge there neither lies behind the
    /// other, as the side of a slot does behind its mouth, and both are touched no further out than planes would be that meet there.
    fn covers(&self, foot: Vec3, contacts: &[Nearest; 2], (radius, turn): (f64, f64)) -> bool {
        let reach = radius * ((0.5 * turn).tan() + CONTACT);
        let lies_before = |met: &Nearest| {
            let height = dot(self.0.distance().normal(met.facet), sub(foot, met.point));
            height >= -self.0.tie() && distance(met.point, foot) <= reach
        };
        turn <= GROOVE && contacts.iter().all(lies_before)
    }

    /// Whether a ball rests on both faces of an edge, so far from its middle, and nothing lies in or behind it.
    fn rests(&self, edge: &ReflexEdge, off: f64, radius: f64) -> bool {
        let (surface, step) = (self.0.distance(), self.0.step());
        let run = run(self.0, edge);
        // The two contacts are at the radius itself.
        let clear = radius * (1.0 - 1e-6) - self.slack(edge, radius);
        let mut foot = along(edge.middle, run, off);
        let centre = |foot: Vec3| along(edge.fillet_centre(radius), run, dot(sub(foot, edge.middle), run));
        if let Some(met) = surface.nearest(centre(foot), clear) {
            let ahead = dot(sub(met.point, centre(foot)), run) / met.distance.max(f64::MIN_POSITIVE);
            if ahead.abs() < AHEAD {
                return false;
            }
            // In a corner the ball comes no nearer to the end than its radius, and rounds the corner from there.
            foot = along(foot, run, -(radius - met.distance) / ahead);
            if surface.nearest(centre(foot), clear).is_some() {
                return false;
            }
        }
        let height = radius / (0.5 * edge.bend).cos();
        let behind = surface.first_hit(foot, edge.outward(), 4.0 * step + 1e-6 * radius, height);
        let touches = |normal: Vec3| {
            let contact = along(centre(foot), normal, -radius);
            surface.nearest(contact, CONTACT * radius + 2.0 * step).is_some()
        };
        behind.is_none() && edge.normals.iter().all(|&n| touches(n))
    }

    /// How far the surface may reach into a ball that touches both facets of an edge: the narrower a facet, the more the resolution of the file tilts
    /// its plane, and the ball's contact lies further up.
    fn slack(&self, edge: &ReflexEdge, radius: f64) -> f64 {
        let narrow = |facet: u32| {
            let [a, b, c] = self.0.distance().corners(facet);
            let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
            2.0 * self.0.mesh().facet_area(facet as usize) / longest.max(f64::MIN_POSITIVE)
        };
        let width = narrow(edge.facets[0]).min(narrow(edge.facets[1])).max(f64::MIN_POSITIVE);
        let reach = radius * (0.5 * edge.bend).tan();
        (self.0.tie() * (1.0 + reach / width)).min(CONTACT * radius)
    }

    /// Whether a ball that touches the surface touches the inside of a facet, and no edge that stands in its way.
    pub fn lies_on_a_face(&self, centre: Vec3, radius: f64) -> bool {
        self.0.distance().nearest(centre, 1.5 * radius).is_some_and(|met| self.is_square(&met, centre))
    }

    /// Whether a ball about a point touches a face, or the edges of its facets, and no edge where it ends.
    fn is_on_round(&self, met: &Nearest, centre: Vec3) -> bool {
        let (surface, way) = (self.0.distance(), sub(centre, met.point));
        let mut bends_away = false;
        surface.within(met.point, (RESTING - 1.0) * norm(way), |near| {
            bends_away |= angle(surface.normal(near.facet), way) > 2.0 * SQUARE;
            if bends_away { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        self.is_square(met, centre) && !bends_away
    }

    /// Whether the way from a point of the surface to another one is square to the facet there.
    fn is_square(&self, met: &Nearest, to: Vec3) -> bool {
        let normal = self.0.distance().normal(met.facet);
        norm(normal) > 0.5 && angle(normal, sub(to, met.point)) < SQUARE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;
    use crate::medial::reflex::reflex_edges;
    use crate::part::Up;

    /// A block of 20 × 20 × 10 mm with a square pocket, so wide and so deep, open at the top, and something in it.
    fn pocket(wide: f64, deep: f64, inside: Option<crate::geometry::TriangleMesh>) -> Part {
        let (a, b, floor) = (10.0 - 0.5 * wide, 10.0 + 0.5 * wide, 10.0 - deep);
        let outline = |lo: f64, hi: f64, z: f64| [[lo, lo, z], [hi, lo, z], [hi, hi, z], [lo, hi, z]];
        let (rim, mouth, bottom) = (outline(0.0, 20.0, 10.0), outline(a, b, 10.0), outline(a, b, floor));
        let foot = outline(0.0, 20.0, 0.0);
        let mut facets = vec![[foot[0], foot[2], foot[1]], [foot[0], foot[3], foot[2]]];
        facets.extend([[bottom[0], bottom[1], bottom[2]], [bottom[0], bottom[2], bottom[3]]]);
        for n in 0..4 {
            let m = (n + 1) % 4;
            for [p, q, r, s] in [
                [foot[n], foot[m], rim[m], rim[n]],
                [rim[n], rim[m], mouth[m], mouth[n]],
                [mouth[n], mouth[m], bottom[m], bottom[n]],
            ] {
                facets.extend([[p, q, r], [p, r, s]]);
            }
        }
        let mesh = crate::geometry::TriangleMesh::weld(facets);
        let mesh = inside.map_or(mesh.clone(), |more| mesh.joined(&more));
        Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap()
    }

    /// A block of 26 × 26 × 10 mm with a pocket of 16 × 16 mm, 5 mm deep, its upright corners round, each in so many facets.
    fn round_pocket(corner: f64, facets: usize) -> crate::geometry::TriangleMesh {
        let turn = std::f64::consts::FRAC_PI_2;
        let arc = |quarter: usize, i: usize| {
            let a = turn * (quarter as f64 + i as f64 / facets as f64);
            let middle = turn * (quarter as f64 + 0.5);
            [(middle.cos(), a.cos()), (middle.sin(), a.sin())]
                .map(|(m, x)| 13.0 + (8.0 - corner) * m.signum() + corner * x)
        };
        let mouth: Vec<[f64; 2]> = (0..4).flat_map(|q| (0..=facets).map(move |i| arc(q, i))).collect();
        let n = mouth.len();
        let at = |i: usize, z: f64| [mouth[i % n][0], mouth[i % n][1], z];
        let corner_of =
            |i: usize, z: f64| [[26.0, 26.0, z], [0.0, 26.0, z], [0.0, 0.0, z], [26.0, 0.0, z]][(i / (facets + 1)) % 4];
        let mut out = Vec::new();
        for i in 0..n {
            out.extend([[at(i, 10.0), at(i, 5.0), at(i + 1, 5.0)], [at(i, 10.0), at(i + 1, 5.0), at(i + 1, 10.0)]]);
            out.push([at(i, 10.0), at(i + 1, 10.0), corner_of(i, 10.0)]);
            if i > 0 && i + 1 < n {
                out.push([at(0, 5.0), at(i + 1, 5.0), at(i, 5.0)]);
            }
        }
        for i in (0..4).map(|q| q * (facets + 1)) {
            let (a, b) = (corner_of(i, 10.0), corner_of(i + facets + 1, 10.0));
            let [c, d] = [a, b].map(|p| [p[0], p[1], 0.0]);
            out.push([at(i + facets + 1, 10.0), b, a]);
            out.extend([[a, b, d], [a, d, c], [c, d, [13.0, 13.0, 0.0]]]);
        }
        crate::geometry::TriangleMesh::weld(out).flipped()
    }

    fn laid(part: &Part, radius: f64) -> Laid {
        Fillets(part).lay(&reflex_edges(part.mesh(), 0.8, |_| true), radius)
    }

    #[test]
    fn a_fillet_fits_into_a_pocket_twice_as_wide_and_no_narrower_one() {
        let roomy = laid(&pocket(2.0, 5.0, None), 1.0);
        // Four edges at the bottom of 2 mm and four upright ones of 5 mm, corners included.
        assert!(roomy.everywhere && (roomy.fitting - 28.0).abs() < 1e-9, "{roomy:?}");
        let tight = laid(&pocket(1.5, 5.0, None), 1.0);
        assert!(!tight.everywhere && tight.fitting == 0.0 && tight.volume == 0.0, "{tight:?}");
        assert!((tight.elsewhere - 0.7).abs() < 1e-9, "{tight:?}");
    }

    #[test]
    fn a_fillet_fits_alike_in_a_pocket_that_was_turned_before_it_was_written() {
        // Round corners of 3 mm in chords of 0.3 mm, the floor a fan: rounded to 32 bits, its facets are tilted.
        for degrees in [0.0f64, 11.0, 33.0, 57.0, 78.0] {
            let (s, c) = degrees.to_radians().sin_cos();
            let turned =
                round_pocket(3.0, 16).transformed([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]], [0.3, 0.7, -0.2]);
            let written =
                turned.triangles.iter().map(|t| t.map(|v| turned.vertices[v as usize].map(|x| f64::from(x as f32))));
            let mesh = crate::geometry::TriangleMesh::weld(written);
            let part = Part::new(mesh, Up::PlusZ, 2e-6, 1.0).unwrap();
            let found = laid(&part, 0.4);
            assert!(found.everywhere && found.fitting > 40.0, "{degrees}: {found:?}");
        }
    }

    #[test]
    fn what_stands_in_an_edge_or_ends_before_the_ball_is_no_room() {
        let free = laid(&pocket(8.0, 5.0, None), 1.0);
        assert!(free.everywhere && free.elsewhere == 1.0);
        // A bar along one lower edge, too small to meet the ball: it would be buried.
        let bar = cuboid([6.03, 7.0, 5.03], [6.2, 13.0, 5.2]);
        let buried = laid(&pocket(8.0, 5.0, Some(bar)), 1.0);
        assert!(
            !buried.everywhere && buried.fitting < free.fitting && buried.fitting > 0.8 * free.fitting,
            "{buried:?}"
        );
        // Walls lower than the radius carry no fillet of it.
        let low = laid(&pocket(8.0, 0.5, None), 1.0);
        assert!(!low.everywhere && (low.elsewhere - 0.5).abs() < 0.11, "{low:?}");
    }

    #[test]
    fn a_fillet_fits_between_faces_that_bend_away_from_their_edge() {
        // Two upright cylinders of 8 mm whose axes are 6 mm apart, as one extruded profile: two grooves of 12 mm.
        let (r, half) = (4.0f64, 3.0f64);
        for facets in [24, 72, 180] {
            let most = std::f64::consts::PI - (half / r).acos();
            let at = |i: usize| most * (2.0 * i as f64 / facets as f64 - 1.0);
            let right: Vec<[f64; 2]> = (1..facets).map(|i| [half + r * at(i).cos(), r * at(i).sin()]).collect();
            let foot = [0.0, (r * r - half * half).sqrt()];
            let left = right.iter().rev().map(|p| [-p[0], p[1]]);
            let outline: Vec<[f64; 2]> =
                [[0.0, -foot[1]]].into_iter().chain(right.iter().copied()).chain([foot]).chain(left).collect();
            let n = outline.len();
            // Each lobe is a fan about the lower groove.
            let caps: Vec<[usize; 3]> = (1..n - 1).map(|i| [0, i, i + 1]).collect();
            let mesh = crate::geometry::extruded(&outline, &caps, 12.0);
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
            let found = laid(&part, 1.0);
            // The ball's centre is 5 mm from both axes: twice the triangle over half the groove less three sectors.
            let sector = |radius: f64, turn: f64| 0.5 * radius * radius * turn;
            let lean = (half / (r + 1.0)).asin();
            let turn = (foot[1] / half).atan();
            let up = ((r + 1.0).powi(2) - half * half).sqrt();
            let side = 0.5 * half * (up - foot[1]) - sector(r, (up / half).atan() - turn) - sector(1.0, lean);
            let truth = 2.0 * 2.0 * side * 12.0;
            assert!(found.everywhere && (found.fitting - 24.0).abs() < 1e-6, "{facets}: {found:?}");
            // Facets of 15° leave out a sagitta of 0.03 mm along a contact of 0.8 mm.
            let chords = 24.0 * 2.0 * 0.8 * r * (1.0 - (most / facets as f64).cos());
            assert!((found.volume - truth).abs() < 0.02 * truth + chords, "{facets}: {} not {truth}", found.volume);
        }
    }

    #[test]
    fn a_slot_with_a_round_mouth_is_not_filled() {
        // 1 mm wide, 1 mm deep from where its mouth of radius 2 mm begins: a ball of 1 mm rests on that.
        for round in [0.6, 2.0, 6.0] {
            let quarter = (0..=24).map(|n| std::f64::consts::FRAC_PI_2 * f64::from(n) / 24.0);
            let right: Vec<[f64; 2]> =
                quarter.map(|a| [0.5 + round * (1.0 - a.cos()), 1.0 + round * a.sin()]).collect();
            let left: Vec<[f64; 2]> = right.iter().rev().map(|p| [-p[0], p[1]]).collect();
            let (top, far) = (1.0 + round, 3.0 + round);
            let floor = [[-0.5, 0.0], [0.5, 0.0]];
            let block = [[far, top], [far, -2.0], [-far, -2.0], [-far, top]];
            let outline = [&floor[..], &right, &block, &left].concat();
            let n = outline.len();
            // Both halves are fans about a lower corner, the middle a strip below the floor.
            let (end, low) = (2 + right.len(), 2 + right.len() + 1);
            let mut caps: Vec<[usize; 3]> = (1..end).map(|i| [low, i, i + 1]).collect();
            let other = low + 1;
            caps.extend((low + 2..n - 1).map(|i| [other, i, i + 1]));
            caps.extend([[other, n - 1, 0], [other, 0, low], [low, 0, 1]]);
            let mesh = crate::geometry::extruded(&outline, &caps, 12.0);
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap();
            assert!(part.health().is_watertight());
            let found = laid(&part, 1.0);
            assert!(found.fitting == 0.0 && (0.4..0.6).contains(&found.elsewhere), "{round}: {found:?}");
        }
    }

    #[test]
    fn a_fillet_between_two_walls_covers_the_chamfer_in_their_corner() {
        // Walls of 10 mm at right angles, 12 mm deep, with a chamfer from one to the other: the ball touches the walls beyond it.
        let laid_over = |[a, b]: [f64; 2], radius: f64| {
            let outline = [[-4.0, -4.0], [10.0, -4.0], [10.0, 0.0], [a, 0.0], [0.0, b], [0.0, 10.0], [-4.0, 10.0]];
            let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6]];
            laid(&Part::new(crate::geometry::extruded(&outline, &caps, 12.0), Up::PlusZ, 1e-6, 1.0).unwrap(), radius)
        };
        let corner = |radius: f64| radius * radius * (1.0 - std::f64::consts::FRAC_PI_4);
        for [a, b] in [[0.1, 0.058], [0.058, 0.1], [0.2, 0.11]] {
            for radius in [0.3, 0.5] {
                let found = laid_over([a, b], radius);
                let truth = 12.0 * (corner(radius) - 0.5 * a * b);
                assert!(found.everywhere && (found.fitting - 12.0).abs() < 1e-9, "{a} {b} {radius}: {found:?}");
                assert!((found.volume / truth - 1.0).abs() < 0.03, "{a} {b} {radius}: {} for {truth}", found.volume);
            }
        }
        // A chamfer wider than that is a wall of its own.
        assert_eq!(laid_over([3.0, 1.74], 0.5).fitting, 12.0);
    }

    #[test]
    fn what_a_fillet_fills_over_two_sharp_edges_of_a_corner_counts_once() {
        // A valley of 80 degrees between sides of 10 mm, its bottom 0.1 mm wide: two edges bent by 50 degrees.
        let (s, c) = 40f64.to_radians().sin_cos();
        let (wide, high) = (0.05 + 10.0 * s, 10.0 * c);
        let outline = [[-wide, -3.0], [wide, -3.0], [wide, high], [0.05, 0.0], [-0.05, 0.0], [-wide, high]];
        let caps = [[0, 1, 3], [1, 2, 3], [0, 3, 4], [0, 4, 5]];
        let part = Part::new(crate::geometry::extruded(&outline, &caps, 12.0), Up::PlusZ, 1e-6, 1.0).unwrap();
        let found = laid(&part, 0.5);
        // The kite less the sector of 100 degrees, and less the tip below the bottom.
        let tan = 50f64.to_radians().tan();
        let truth = 12.0 * (0.25 * (tan - 50f64.to_radians()) - 0.05 * 0.05 * tan);
        assert!(found.everywhere && (found.fitting - 24.0).abs() < 1e-9, "{found:?}");
        assert!((found.volume / truth - 1.0).abs() < 0.03, "{} for {truth}", found.volume);
    }

    #[test]
    fn a_ball_on_a_face_is_told_from_one_on_an_edge() {
        let part = pocket(8.0, 5.0, None);
        let fillets = Fillets(&part);
        assert!(fillets.lies_on_a_face([10.0, 10.0, 6.0], 1.0));
        assert!(!fillets.lies_on_a_face([6.0 + 0.7, 10.0, 10.0 + 0.7], 1.0));
    }
}
