//! Which facets bound the solid, and on which side of each the material is.

use super::Part;
use crate::error::{Error, Result};
use crate::geometry::health::{NO_LABEL, Role, Sides, Spoken, Through, cracks, meetings_through, without_slivers};
use crate::geometry::union::united;
use crate::geometry::vector::{Vec3, along};
use crate::geometry::{Health, MeshDistance, TriangleMesh};
use crate::notice::{Notice, number_of};
use crate::units::{report_digits, short};
use rayon::prelude::*;
use std::sync::OnceLock;

/// A winding number that is clearly inside, just beside a facet.
const ENCLOSED: f64 = 0.75;
/// Share of a surface's area that must have enclosed material beside it; a sheet has none.
const LEAST_ENCLOSED: f64 = 0.05;
/// The same where most edges are open, and both winding numbers must be those of a solid: loose triangles have them beside less than a
/// fifth of their area, however many there are, and solids with cracks beside nearly all of it.
const LEAST_WHOLE: f64 = 0.5;
/// The winding numbers of a solid, whole numbers, are off by no more beside facets that cracks part.
const WHOLE: f64 = 0.1;
/// How that is told.
const WHOLE_NUMBERS: &str = "are the winding numbers the whole numbers of a solid";
/// Loose triangles from so many on are looked at beside some first: that beside all takes as long as all pairs of them.
const MANY_LOOSE: usize = 2000;
/// So many of them: beside less than a fifth of them are the numbers whole, of a solid with cracks beside nearly all.
const SAMPLED: usize = 8;
/// A surface that is inside out or mixed shows its inside where the winding number says so.
const INSIDE: f64 = 0.5;

/// What is known of the space before each facet of a closed surface.
#[derive(Default)]
pub(super) struct Before {
    /// Whether it is inside, where that is the same from right before the facet to `away`.
    inside: Vec<Option<bool>>,
    away: f64,
}

impl Before {
    /// What those who speak for others say, if no surface lies between them and where they were asked.
    fn of(spoken: &Spoken, mesh: &TriangleMesh, tree: &MeshDistance, away: f64) -> Self {
        let says = |f: usize| {
            let speaks = spoken.speaker[f] as usize == f && is_clear(mesh, tree, f, [0.0, away]);
            speaks.then_some(spoken.sides[f].1 >= INSIDE)
        };
        let said: Vec<Option<bool>> = (0..spoken.sides.len()).into_par_iter().map(says).collect();
        let inside = spoken.speaker.iter().map(|&s| said.get(s as usize).copied().flatten()).collect();
        Before { inside, away }
    }
}

/// Whether no surface is met between two distances before the middle of a facet, nor right beside them.
fn is_clear(mesh: &TriangleMesh, tree: &MeshDistance, facet: usize, [a, b]: [f64; 2]) -> bool {
    let (near, far) = (a.min(b), a.max(b));
    let (middle, normal): (Vec3, Vec3) = (mesh.centroid(facet), mesh.normal(facet));
    let from = along(middle, normal, 0.5 * near);
    // A facet that starts at its own plane would meet itself there.
    let least = if near > 0.0 { 0.0 } else { 1e-3 * far };
    tree.first_hit(from, normal, least, 1.5 * far).is_none()
}

impl Part {
    /// Decides which facets bound the solid, and which way round.
    pub(super) fn choose_bounding_facets(&mut self) -> Result<()> {
        // Closed, and no thicker than what the file resolves: a sheet with two sides.
        if self.health.is_solid() && self.health.volume_mm3().abs() <= 0.5 * self.step * self.mesh.area() {
            return Err(Error::NotSolid {
                problem: "it is closed and holds no volume".into(),
                at_mm: Some(self.to_file(self.mesh.centroid(0))),
                remedy: "give the sheet a thickness and export the part again".into(),
            });
        }
        // No facet has a neighbour: loose triangles mostly, and their crossings need not be searched.
        if self.health.open_edges.count == 3 * self.mesh.triangles.len() as u64 {
            self.enclosing_by_some()?;
            self.enclosing(&self.beside().of_each())?;
        }
        // Facets at cracks reach over each other by the width of the cracks, which are told as open edges.
        let at_cracks = self.at_cracks();
        let is_parted = |f: usize| at_cracks.get(f).is_some_and(|&cracked| cracked);
        let of_one_body = |f: u32, g: u32| {
            let [of, on] = [f, g].map(|f| f as usize);
            let (bodies, shells) = (&self.health.facet_body, &self.health.facet_shell);
            let closed = |f: usize| self.health.shells.get(shells[f] as usize).is_some_and(|s| s.closed);
            // Surfaces that are closed by themselves may cross through edges alone, as blocks do that are set off along a diagonal.
            let through = match shells[of] != shells[on] && closed(of) && closed(on) {
                true => Through::Edges,
                false => Through::Inside,
            };
            (bodies[of] == bodies[on] && !(is_parted(of) && is_parted(on))).then_some(through)
        };
        let labelled = self.labelled();
        self.meetings = meetings_through(&labelled, of_one_body, 2.0 * self.step);
        // A shell within the material of another meets nothing, and bounds nothing either.
        let meets = !self.is_plain() || self.health.count_of(Role::Swallowed) > 0;
        let labelled = if self.health.is_solid() && meets && self.unite() { self.labelled() } else { labelled };
        if self.is_plain() {
            for (bounds, &body) in self.bounding.iter_mut().zip(&self.health.facet_body) {
                *bounds = body != NO_LABEL;
            }
            self.kept.distance = OnceLock::from(labelled);
            return Ok(());
        }
        self.judge_each_facet(&labelled)
    }

    /// Whether each facet has a corner at a crack; none are told of a closed surface.
    fn at_cracks(&self) -> Vec<bool> {
        if self.health.open_edges.count == 0 {
            return Vec::new();
        }
        let mut ends = vec![false; self.mesh.vertices.len()];
        cracks(&self.mesh).iter().flat_map(|crack| crack.ends).flatten().for_each(|v| ends[v as usize] = true);
        self.mesh.triangles.iter().map(|t| t.iter().any(|&v| ends[v as usize])).collect()
    }

    /// Decides by the winding number beside each facet.
    fn judge_each_facet(&mut self, labelled: &MeshDistance) -> Result<()> {
        let bodies = &self.health.facet_body;
        let beside = self.beside();
        let off = beside.off;
        let whole = self.health.is_solid() && bodies.iter().all(|&b| b != NO_LABEL);
        let sides = if whole {
            let spoken = beside.of_closed(labelled, 2.0 * self.step);
            self.before = Before::of(&spoken, &self.mesh, labelled, off);
            spoken.sides
        } else {
            beside.of_each()
        };
        let inside = |w: f64| w >= INSIDE;
        if !self.health.is_solid() {
            self.enclosing(&sides)?;
        }
        let sound = self.health.is_solid();
        let mut turned = 0u64;
        for (f, (back, front)) in sides.into_iter().enumerate() {
            self.bounding[f] = inside(back) != inside(front);
            if !sound && inside(front) && !inside(back) {
                self.mesh.triangles[f].swap(1, 2);
                turned += 1;
            }
        }
        if turned > 0 {
            let text = number_of(
                turned,
                [
                    "facet was turned so that the enclosed side is inside",
                    "facets were turned so that the enclosed side is inside",
                ],
            );
            self.notices.push(Notice::new("turned-facets", text).counted(turned));
        }
        // Many tasks at once ask for it first, to know what is covered.
        self.kept.distance = OnceLock::from(MeshDistance::to_some(&self.mesh, |f| self.bounds_solid(f)));
        Ok(())
    }

    /// The facets that belong to a body.
    fn labelled(&self) -> MeshDistance {
        let bodies = &self.health.facet_body;
        MeshDistance::to_some(&self.mesh, |f| bodies.get(f).is_some_and(|&b| b != NO_LABEL))
    }

    /// Takes the surface of the union for that of bodies that overlap or touch, or of one that passes through itself; whether there is one.
    fn unite(&mut self) -> bool {
        self.notices.extend(self.touching());
        let Some(union) = united(&self.mesh, 2.0 * self.step) else {
            let text = "what meets itself could not be united to one closed surface: facets that pass through others count as a whole, as their middles lie";
            self.notices.push(Notice::new("not-united", text));
            return false;
        };
        let union = without_slivers(&union, self.step).unwrap_or_else(|| union.in_order());
        self.before_union = Some(std::mem::replace(&mut self.mesh, union));
        self.health = Health::of(&self.mesh);
        self.bounding = vec![true; self.mesh.triangles.len()];
        (self.kept.pairs, self.united) = (OnceLock::new(), true);
        true
    }

    /// Says which bodies touch or cross.
    fn touching(&self) -> Option<Notice> {
        let touching = || self.body_pairs().iter().filter(|p| p.distance <= self.step);
        let (first, count) = (touching().next()?, touching().count() as u64);
        let text = number_of(
            count,
            [
                "pair of bodies touches or crosses and is one piece in print",
                "pairs of bodies touch or cross and are one piece in print",
            ],
        );
        Some(Notice::new("touching-bodies", text).counted(count).at(first.points[0].map(report_digits)))
    }

    /// Where the winding number is evaluated beside facets.
    fn beside(&self) -> Sides<'_> {
        let off = (20.0 * self.step).max(1e-5 * self.extent().into_iter().fold(0.0, f64::max));
        Sides { mesh: &self.mesh, winding: self.winding(), off }
    }

    /// Refuses many loose triangles that only few of some facets spread over them have the winding numbers of a solid beside them.
    fn enclosing_by_some(&self) -> Result<()> {
        if self.mesh.triangles.len() < MANY_LOOSE {
            return Ok(());
        }
        let some = self.beside().of_some(SAMPLED);
        let whole = some.iter().filter(|sides| is_whole(**sides)).count();
        match 4 * whole > some.len() {
            true => Ok(()),
            false => {
                Err(self.encloses_nothing(format!("beside {whole} of {} facets only {WHOLE_NUMBERS}", some.len())))
            }
        }
    }

    /// Refuses a surface with too little enclosed material beside it, by the winding numbers on both sides of each facet.
    fn enclosing(&self, sides: &[(f64, f64)]) -> Result<()> {
        let is_loose = 2 * self.health.open_edges.count > 3 * self.mesh.triangles.len() as u64;
        let (least, told) = match is_loose {
            true => (LEAST_WHOLE, WHOLE_NUMBERS),
            false => (LEAST_ENCLOSED, "does the winding number clearly exceed 1/2"),
        };
        let holds = |f: &usize| match is_loose {
            true => is_whole(sides[*f]),
            false => sides[*f].0.max(sides[*f].1) >= ENCLOSED,
        };
        let enclosed: f64 = (0..sides.len()).filter(holds).map(|f| self.mesh.facet_area(f)).sum();
        let share = enclosed / self.mesh.area();
        if share >= least {
            return Ok(());
        }
        let beside = match share > 0.0 {
            true => format!("beside {} % of its area only", short(report_digits(100.0 * share))),
            false => "nowhere beside its facets".into(),
        };
        Err(self.encloses_nothing(format!("{beside} {told}")))
    }

    fn encloses_nothing(&self, told: String) -> Error {
        Error::NotSolid {
            problem: format!("{told}, so it encloses nothing"),
            at_mm: Some(self.to_file(self.health.open_edges.at_mm.unwrap_or_else(|| self.mesh.centroid(0)))),
            remedy: "export a closed solid, or try again with --repair, which closes cracks".into(),
        }
    }

    /// Says where a winding number does not tell inside from outside.
    pub fn doubt(&self) -> Option<Notice> {
        let doubt = self.solid().ok()?.doubt?;
        (doubt.share > 0.0).then(|| {
            let text = format!(
                "inside and outside come from the winding number; it is in doubt in {} % of what may be the part",
                short(doubt.percent())
            );
            Notice::new("uncertain-inside", text).at(self.to_file(doubt.at_mm).map(report_digits))
        })
    }

    /// Whether there is material so far before the middle of a facet, by the winding number.
    ///
    /// Where that is known at another distance before the facet, and no surface lies between, the answer is the same.
    pub fn is_inside_before(&self, facet: u32, away: f64) -> bool {
        let known = self.before.inside.get(facet as usize).copied().flatten();
        let f = facet as usize;
        match known.filter(|_| is_clear(&self.mesh, self.distance(), f, [away, self.before.away])) {
            Some(inside) => inside,
            None => self.winding().at(along(self.mesh.centroid(f), self.mesh.normal(f), away)) >= INSIDE,
        }
    }
}

/// Whether the winding numbers on both sides of a facet are those of a solid, with material on one.
fn is_whole((back, front): (f64, f64)) -> bool {
    back.max(front) >= ENCLOSED && [back, front].iter().all(|w| (w - w.round()).abs() <= WHOLE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Primitive;
    use crate::geometry::vector::add;
    use crate::part::Up;
    use crate::units::Length;

    #[test]
    fn what_is_known_before_a_facet_is_what_the_winding_number_says_there() {
        let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let ball = |x: f64, r: f64| {
            Primitive::Ball { radius: Length::mm(r) }.mesh(Length::mm(0.02)).transformed(one, [x, 0.1, 0.2])
        };
        // Two balls that cross, one inside both, one that nearly touches, and an inner shell.
        let balls = [ball(4.0, 3.0), ball(2.0, 0.5), ball(-4.0, 0.9999), ball(-0.5, 1.0).flipped()];
        let mesh = balls.iter().fold(ball(0.0, 3.0), |all, b| all.joined(b)).in_order();
        let lowest = mesh.bounds().map_or([0.0; 3], |b| b.0.map(|x| -x));
        let part_mesh = mesh.transformed(one, lowest);
        let health = Health::of(&part_mesh);
        let united = Part::new(mesh.clone(), Up::PlusZ, 1e-6, 1.0).expect("a part");
        assert!(united.is_plain() && united.is_united());
        let asked_for_no_gaps = Part::new(mesh.clone(), Up::PlusZ, 1e-6, 0.0).expect("a part");
        assert_eq!(asked_for_no_gaps.mesh(), united.mesh());
        // What could not be united is judged as it is.
        let mut part = Part::new(mesh, Up::PlusZ, 1e-6, 1.0).expect("a part");
        part.bounding = vec![true; part_mesh.triangles.len()];
        (part.mesh, part.health, part.united, part.kept.winding) = (part_mesh, health, false, OnceLock::new());
        let labelled = part.labelled();
        part.judge_each_facet(&labelled).expect("a solid");
        let mut known = 0;
        for f in 0..part.mesh().triangles.len() {
            let at = along(part.mesh().centroid(f), part.mesh().normal(f), 20.0 * part.step());
            assert_eq!(part.is_inside_before(f as u32, 20.0 * part.step()), part.winding().at(at) >= INSIDE, "{f}");
            known += usize::from(part.before.inside[f].is_some());
        }
        assert!(2 * known > part.mesh().triangles.len(), "{known} of {}", part.mesh().triangles.len());
    }

    #[test]
    fn loose_facets_are_a_solid_where_the_winding_number_says_so() {
        use crate::random::Lcg;
        let block = crate::geometry::cuboid([0.0; 3], [10.0; 3]);
        // Each facet by itself, a little off the plane of its neighbours and turned: no two share an edge.
        let mut random = Lcg(3);
        let mut apart = |f: usize| block.corners(f).map(|p| add(p, random.point(-1e-3, 1e-3)));
        let cracked = TriangleMesh::weld((0..12).map(&mut apart));
        let part = Part::new(cracked, Up::PlusZ, 1e-6, 1.0).expect("a part");
        assert_eq!((part.health_as_read().open_edges.count, part.health().bodies.len()), (36, 1));
        assert!((0..12).all(|f| part.bounds_solid(f)));
        assert_eq!(part.meetings().crossing.count, 0);
        // One side of the block, and loose triangles, few and many.
        let mut soup = |count: usize| -> Vec<[Vec3; 3]> {
            (0..count)
                .map(|_| {
                    let at = random.point(0.0, 4.0);
                    [0; 3].map(|_| add(at, random.point(-1.0, 1.0)))
                })
                .collect()
        };
        for loose in [vec![block.corners(0)], soup(10), soup(100), soup(1000), soup(4000)] {
            let none = Part::new(TriangleMesh::weld(loose), Up::PlusZ, 1e-6, 1.0).map(|_| ());
            let said = none.expect_err("no solid").to_string();
            assert!(said.contains("are the winding numbers the whole numbers of a solid"), "{said}");
        }
    }

    #[test]
    fn voids_that_cross_are_judged_as_one() {
        use crate::geometry::cuboid;
        // Every edge that passes into the other void meets the middle of a face, on the edge between its two facets.
        let voids = cuboid([2.0; 3], [6.0; 3]).joined(&cuboid([4.0; 3], [8.0; 3]));
        let part = Part::new(cuboid([0.0; 3], [10.0; 3]).joined(&voids.flipped()), Up::PlusZ, 1e-6, 1.0);
        let part = part.expect("a part");
        assert!(part.is_united() && part.meetings().crossing.count > 0, "{:?}", part.meetings());
        // 1000 less 64 + 64 − 8, and 600 of its own faces with 96 + 96 − 24 of the voids'.
        assert!((part.health().volume_mm3() - 880.0).abs() < 1e-6, "{}", part.health().volume_mm3());
        assert!((part.mesh().area() - 768.0).abs() < 1e-6, "{}", part.mesh().area());
        assert_eq!((part.health().bodies.len(), part.health().count_of(Role::Cavity)), (1, 1));
    }

    #[test]
    fn bodies_that_cross_are_judged_as_their_union() {
        use crate::geometry::cuboid;
        // A column that reaches into the slab upon it: the middles of both facets of the slab's underside lie in the column.
        let both =
            cuboid([25.0, 25.0, 0.0], [85.0, 85.0, 21.0]).joined(&cuboid([0.0, 0.0, 20.0], [110.0, 110.0, 24.0]));
        let part = Part::new(both, Up::PlusZ, 1e-6, 1.0).expect("a part");
        let under = |f: &usize| part.mesh().normal(*f)[2] < -0.5 && part.mesh().centroid(*f)[2] > 1.0;
        let hangs: f64 = (0..part.mesh().triangles.len()).filter(under).map(|f| part.mesh().facet_area(f)).sum();
        assert!((hangs - 8500.0).abs() < 1e-6 && part.is_plain(), "{hangs}");
        assert_eq!((part.health().bodies.len(), part.health_as_read().bodies.len()), (1, 2));
        assert!(part.notices().iter().any(|n| n.code == "touching-bodies"), "{:?}", part.notices());
    }
}
