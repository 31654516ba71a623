//! Which way to print: many directions scored on the mesh, the best measured in full, and those that nothing beats.

use super::direction::{Facets, LEVEL, Score, Whole, candidates};
use super::question::{Footing, Liquid, Question};
use super::rest::rests;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::vector::{Vec3, angle, unit};
use crate::geometry::{TriangleMesh, occupancy};
use crate::grid::Grid;
use crate::layer::{Below, Bounding, Floors, Measuring, Search, Unheld, hidden_from_outside, section_area, supports};
use crate::topology::{Adjacency, Falls, Passage, components, retained};
use crate::units::{Angle, Length, report_digits};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// One way to stand the part up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Orientation {
    /// The direction of the file that points up.
    pub up: Vec3,
    /// Rows of the rotation from the frame of the file to that of the build.
    pub rotation: [Vec3; 3],
    /// How the direction was found: `given`, `axis`, `face`, `rest` or `sphere`.
    pub from: String,
    /// Sides of the box in this pose, mm.
    pub box_mm: Vec3,
    /// Whether it fits the machine, turned about the vertical if that helps.
    pub fits: bool,
    /// Whether it topples by itself, where the process minds.
    #[serde(default)]
    pub topples: bool,
    /// Support volume, mm³, with its bounds.
    pub support_mm3: f64,
    pub support_low_mm3: f64,
    pub support_high_mm3: f64,
    /// Area of the part that supports touch from below, mm²: what hangs over of its facets that do not hold themselves for certain.
    pub contact_mm2: f64,
    /// Area on which supports stand on the part, mm², with its bounds.
    pub on_part_mm2: f64,
    #[serde(default)]
    pub on_part_low_mm2: f64,
    #[serde(default)]
    pub on_part_high_mm2: f64,
    /// Support volume that no straight line along the 26 directions of the lattice reaches from outside, mm³: an estimate.
    pub secluded_mm3: f64,
    /// Volume of liquid that stays in the part while it hangs from the plate in this pose, sealed voids aside, mm³: an estimate; 0 where
    /// the process knows none.
    pub retained_mm3: f64,
    /// Volume of the cups that close on the film in this pose, mm³: an estimate; 0 where the process knows none.
    #[serde(default)]
    pub suction_mm3: f64,
    /// Volume of the steps that layers leave on slopes, mm³.
    pub cusp_mm3: f64,
    /// Area of the first layer, mm².
    pub bed_mm2: f64,
    /// What the choice goes by; less is better.
    pub cost: f64,
    /// Whether no other of the list is at least as good in everything and better in something.
    pub pareto: bool,
    /// The facets that need support in this pose; not written.
    #[serde(skip)]
    pub wanting_support: Vec<u32>,
}

/// All orientations measured in full, the best first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Orientations {
    /// How many directions were scored.
    pub scored: usize,
    pub list: Vec<Orientation>,
}

/// Share of the surface that a first layer needs to hold a part half as well as any; the cost falls with the first layer, so that the
/// best pose is beaten by none in everything.
const HELD: f64 = 0.01;

/// The best ways to stand a part up for printing.
///
/// Every direction, `directions` of a Fibonacci lattice, the six axes, the normals of the part's largest flat faces and its rests on a plate
/// (faces of its convex hull that its centre of mass lies over, flat or not: a ring has no flat face and lies still), gets a score from
/// the mesh alone, in which supports reach down to the plate. The best, at least `apart` from each other, are posed and measured, some of the rests first: support
/// volume by columns ([`Below::supported`]) without what lies on the plate or rests on other material, what of it cannot be seen from outside, liquid kept and
/// cups on the film, first layer, steps.
/// The cost of a pose is
///
/// support/V + 3·secluded/V + (contact + feet on the part)/A + ½·(retained + suction)/V + steps/V + 0.2·height/across + 1/(1 + first layer/0.01·A)
///
/// with the part's volume V and area A, and across it twice as far as it reaches from the middle of its surface: a convention. Poses that do not fit the machine come last, and before them those that topple, where
/// the process minds. Only the directions listed are compared. `facets` says what the facets bound.
///
/// # Errors
/// [`Error::NoGeometry`] without facets or volume.
///
/// # Cost
/// O(directions·facets) and, for each of the best, one support volume and one cast at `samples`.
pub fn orientations(mesh: &TriangleMesh, facets: &impl Bounding, question: &Question) -> Result<Orientations> {
    let flats = Facets::of(mesh, &|f| facets.bounds_solid(f), question.directions);
    let whole = Whole::of(mesh, &flats);
    if !(whole.volume > 0.0 && whole.area > 0.0 && whole.across.is_finite()) {
        return Err(Error::NoGeometry {
            problem: "the part has no volume to be oriented".into(),
            remedy: "export a closed solid".into(),
        });
    }
    let centre = mesh.centre_of_mass(|f| facets.bounds_solid(f));
    let slack = (2.0 * question.step_mm).max(1e-9 * whole.across);
    let rests = centre.map_or(Vec::new(), |centre| rests(&flats.hull, centre, slack));
    let candidates = candidates(&flats, &rests, question.directions);
    let mut scores: Vec<Score> =
        candidates.into_par_iter().with_max_len(1).map(|(up, from)| flats.score(up, from, question, &whole)).collect();
    let scored = scores.len();
    scores.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut chosen: Vec<Score> =
        question.given.map(|up| flats.score(unit(up), "given", question, &whole)).into_iter().collect();
    // Hardly anything stands on a curved side: where it has to stand, half of what is measured stands on an axis or a face.
    let on_faces = if question.footing == Footing::Needed { question.best.div_ceil(2) } else { 0 };
    let is_on_face = |s: &&Score| s.from != "sphere";
    // A direction of the sphere a little beside a rest may score better, and topples.
    let at_rest = scores.iter().filter(|s| s.from == "rest").map(|s| (s, question.best.div_ceil(4)));
    let flat = scores.iter().filter(is_on_face).map(|s| (s, on_faces));
    for (s, most) in at_rest.chain(flat).chain(scores.iter().map(|s| (s, question.best))) {
        if chosen.len() < most && chosen.iter().all(|c| angle(c.up, s.up) > question.apart.as_radians()) {
            chosen.push(*s);
        }
    }
    // Every pose in work holds the mesh turned. Fewer threads have no more in work, and need not wait for each other.
    let most = poses_at_once(mesh.triangles.len());
    let at_once = if rayon::current_num_threads() <= most { chosen.len().max(1) } else { most };
    let mut list = Vec::with_capacity(chosen.len());
    for some in chosen.chunks(at_once) {
        let measured: Result<Vec<Orientation>> =
            some.par_iter().with_max_len(1).map(|s| measure(mesh, facets, s, question, &whole)).collect();
        list.extend(measured?);
    }
    mark_unbeaten(&mut list);
    list.sort_by(|a, b| b.fits.cmp(&a.fits).then(a.topples.cmp(&b.topples)).then(a.cost.total_cmp(&b.cost)));
    Ok(Orientations { scored, list })
}

/// How many poses of so many facets are measured at a time, however many threads there are: half a million facets, but two poses at least.
fn poses_at_once(facets: usize) -> usize {
    (500_000 / facets.max(1)).clamp(2, 20)
}

/// The rotation that brings a direction to +z by the shortest way.
pub fn upright(up: Vec3) -> [Vec3; 3] {
    // By its greatest coordinate first, whose square is finite then and not 0.
    let most = up.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    let [x, y, z] = unit(up.map(|c| c / most));
    if z < -1.0 + 1e-12 {
        return [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    }
    let k = 1.0 / (1.0 + z);
    [[1.0 - k * x * x, -k * x * y, -x], [-k * x * y, 1.0 - k * y * y, -y], [x, y, z]]
}

/// Poses the part and measures it.
fn measure(
    mesh: &TriangleMesh,
    facets: &impl Bounding,
    score: &Score,
    q: &Question,
    whole: &Whole,
) -> Result<Orientation> {
    let bounding = |f: usize| facets.bounds_solid(f);
    let rotation = upright(score.up);
    let posed = standing(mesh, &rotation);
    let size = posed.bounds().unwrap_or_default().1;
    let h = size.into_iter().fold(0.0, f64::max) / q.samples.max(1) as f64;
    let (unheld, (found, [_, contact])) = match q.support_angle {
        None => Default::default(),
        Some(angle) => {
            let floors = Floors::of(&posed, facets);
            let below = below(&posed, &floors, facets, q);
            let unheld = wanting(&below, angle, q);
            let found = below.supported(&unheld, h);
            (unheld, found)
        }
    };
    let wanted = unheld.facets;
    let grid = Grid::covering([0.0; 3], size, Length::mm(h), 1, [0.0; 3])?;
    let sample = h * h * h;
    // A surface that is not closed cannot be cast by its crossings; then these two are not known and count nothing.
    let (secluded, [kept, suction]) = match occupancy(&posed, &grid) {
        Ok(centres) => {
            let columns = supports(&centres, &posed, &wanted, 0.0)?.columns;
            let hidden = hidden_from_outside(&centres)?.intersection(&columns)?.count();
            let held = match q.liquid {
                Liquid::None => [0, 0],
                Liquid::Vat => held(&centres.complement())?,
            };
            (hidden as f64 * sample, held.map(|samples| samples as f64 * sample))
        }
        Err(_) => (0.0, [0.0; 2]),
    };
    let bed = section_area(&posed, bounding, 0.5 * q.layer_mm).max(0.0);
    let steps: f64 = (0..posed.triangles.len())
        .filter(|&f| bounding(f))
        .map(|f| (0.5 * posed.area_vector(f)[2].abs(), posed.facet_area(f)))
        .filter(|(up, area)| *up < LEVEL * area)
        .map(|(up, _)| up)
        .sum();
    let support = 0.5 * (found.volume_mm3[0] + found.volume_mm3[1]);
    let on_part = 0.5 * (found.on_part_mm2[0] + found.on_part_mm2[1]);
    let cusp = 0.5 * q.layer_mm * steps;
    let cost = (support + 3.0 * secluded + 0.5 * (kept + suction) + cusp) / whole.volume
        + (contact + on_part) / whole.area
        + 0.2 * size[2] / whole.across
        + 1.0 / (1.0 + bed / (HELD * whole.area));
    let digits = report_digits;
    Ok(Orientation {
        up: score.up,
        rotation,
        from: score.from.into(),
        box_mm: size.map(digits),
        fits: q.fits(&posed),
        topples: !q.is_footed(&posed, bounding),
        support_mm3: digits(support),
        support_low_mm3: digits(found.volume_mm3[0]),
        support_high_mm3: digits(found.volume_mm3[1]),
        contact_mm2: digits(contact),
        on_part_mm2: digits(on_part),
        on_part_low_mm2: digits(found.on_part_mm2[0]),
        on_part_high_mm2: digits(found.on_part_mm2[1]),
        secluded_mm3: digits(secluded),
        retained_mm3: digits(kept),
        suction_mm3: digits(suction),
        cusp_mm3: digits(cusp),
        bed_mm2: digits(bed),
        cost: digits(cost),
        pareto: false,
        wanting_support: wanted,
    })
}

/// Samples of a void that keep liquid while the part hangs upside down, and those cut off on a film as the layers come, sealed voids aside.
fn held(void: &Indicator) -> Result<[u64; 2]> {
    let pieces = components(void, Adjacency::Face);
    let opens = pieces.at_border();
    let open = pieces.select(|piece| opens.get(piece as usize) == Some(&true));
    let of = |falls| Ok(retained(&open, falls, Passage::Faces)?.count());
    Ok([of(Falls::Up)?, of(Falls::Down)?])
}

/// A part turned and moved so that its box begins at the origin.
pub fn standing(mesh: &TriangleMesh, rotation: &[Vec3; 3]) -> TriangleMesh {
    let turned = mesh.transformed(*rotation, [0.0; 3]);
    let (lo, _) = turned.bounds().unwrap_or_default();
    turned.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], lo.map(|c| -c))
}

/// Pairs of a line and a side that may tell of what a quick look leaves open whether it holds itself.
const TELLING: u64 = 8_000_000;

/// A part stood up by a rotation as [`standing`] does, and the facets that need support then: what hangs over, rests on nothing and does
/// not hold itself.
///
/// # Cost
/// The floors of the part, [`Below::ceilings`] quickly, and a search for each ceiling of which that does not tell.
pub fn stood(
    mesh: &TriangleMesh,
    rotation: &[Vec3; 3],
    facets: &impl Bounding,
    q: &Question,
) -> (TriangleMesh, Vec<u32>) {
    let posed = standing(mesh, rotation);
    let wanted = q.support_angle.map(|angle| {
        let floors = Floors::of(&posed, facets);
        wanting(&below(&posed, &floors, facets, q), angle, q).facets
    });
    (posed, wanted.unwrap_or_default())
}

fn wanting<B: Bounding>(below: &Below<B>, angle: Angle, q: &Question) -> Unheld {
    let (ledge_mm, bridge_mm) =
        (q.self_holding.ledge_mm.unwrap_or(0.0), q.self_holding.bridge_mm.unwrap_or(f64::INFINITY));
    let (plate_z, layer_mm, step_mm) = (q.plate_z(), q.layer_mm, q.step_mm);
    let quickly = Measuring { plate_z, layer_mm, ledge_mm, bridge_mm, step_mm, search: Search::Judge };
    let first = below.ceilings(angle, quickly);
    q.self_holding.unheld(&below.told(first, &q.self_holding, quickly, TELLING))
}

/// What lies no more than a layer below a part's own facets, and the plate.
fn below<'a, B: Bounding>(posed: &'a TriangleMesh, floors: &'a Floors, facets: &'a B, q: &Question) -> Below<'a, B> {
    Below::of((posed, floors), facets, q.layer_mm, (q.plate_z(), q.step_mm))
}

/// The facets among those that [`stood`] found of which some hangs over, each with that share of it in plan: less what of it lies on the plate
/// or no more than a layer above other material.
///
/// # Cost
/// The floors of the part, and a look below each of these facets.
pub(super) fn shares(posed: &TriangleMesh, wanted: &[u32], facets: &impl Bounding, q: &Question) -> Vec<(u32, f64)> {
    let floors = Floors::of(posed, facets);
    let below = below(posed, &floors, facets, q);
    let shared = |&f: &u32| Some((f, below.hanging_share(f))).filter(|(_, share)| *share > 0.0);
    wanted.par_iter().filter_map(shared).collect()
}

/// Marks the orientations that no other beats in everything.
fn mark_unbeaten(list: &mut [Orientation]) {
    let aims = |o: &Orientation| {
        [
            o.support_mm3,
            o.contact_mm2 + o.on_part_mm2,
            o.secluded_mm3,
            o.retained_mm3,
            o.suction_mm3,
            o.box_mm[2],
            o.cusp_mm3,
            -o.bed_mm2,
            f64::from(u8::from(o.topples)),
        ]
    };
    let all: Vec<[f64; 9]> = list.iter().map(aims).collect();
    for (i, o) in list.iter_mut().enumerate() {
        let beats = |other: &[f64; 9]| {
            let pairs = || other.iter().zip(&all[i]);
            pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
        };
        o.pareto = !all.iter().any(beats);
    }
}

#[cfg(test)]
mod tests {
    use super::super::direction::sphere;
    use super::*;
    use crate::geometry::vector::dot;
    use crate::layer::SelfHolding;
    use crate::units::Angle;

    /// Rows orthonormal, handedness kept.
    fn is_rotation(r: &[Vec3; 3]) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
        (0..3).all(|i| (0..3).all(|j| close(dot(r[i], r[j]), f64::from(u8::from(i == j)))))
            && close(dot(r[0], crate::geometry::vector::cross(r[1], r[2])), 1.0)
    }

    fn question() -> Question {
        Question {
            support_angle: Some(Angle::degrees(45.0)),
            self_holding: SelfHolding::default(),
            layer_mm: 0.2,
            build_volume_mm: [220.0; 3],
            step_mm: 1e-6,
            directions: 200,
            best: 12,
            given: None,
            apart: Angle::degrees(8.0),
            samples: 48,
            footing: Footing::Any,
            liquid: Liquid::None,
        }
    }

    #[test]
    fn upright_brings_the_direction_up() {
        for d in sphere(50).into_iter().chain([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1e-9, -1.0]]) {
            let r = upright(d);
            assert!(is_rotation(&r), "{d:?}: {r:?}");
            let image = [0, 1, 2].map(|a| dot(r[a], unit(d)));
            assert!(angle(image, [0.0, 0.0, 1.0]) < 1e-6, "{d:?}: {image:?}");
        }
    }

    /// A T of one surface: a stem of 4 × 4 × 20 mm under a bar of 30 × 4 × 4 mm.
    fn letter_t() -> TriangleMesh {
        let outline = [
            [-2.0, 0.0],
            [2.0, 0.0],
            [2.0, 20.0],
            [15.0, 20.0],
            [15.0, 24.0],
            [-15.0, 24.0],
            [-15.0, 20.0],
            [-2.0, 20.0],
        ];
        let at = |i: usize, y: f64| [outline[i % 8][0], y, outline[i % 8][1]];
        let mut facets = Vec::new();
        for i in 0..8 {
            facets.push([at(i, -2.0), at(i + 1, -2.0), at(i + 1, 2.0)]);
            facets.push([at(i, -2.0), at(i + 1, 2.0), at(i, 2.0)]);
        }
        for [a, b, c] in [[0, 1, 2], [0, 2, 7], [5, 6, 7], [5, 7, 2], [5, 2, 3], [5, 3, 4]] {
            facets.push([at(a, -2.0), at(c, -2.0), at(b, -2.0)]);
            facets.push([at(a, 2.0), at(b, 2.0), at(c, 2.0)]);
        }
        let mesh = TriangleMesh::weld(facets);
        if mesh.signed_volume() < 0.0 { mesh.flipped() } else { mesh }
    }

    #[test]
    fn a_t_is_turned_upside_down_wherever_it_started() {
        let t = letter_t();
        for turn in [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.3, -0.5, 0.7]] {
            let r = upright(turn);
            let found = orientations(&t.transformed(r, [0.0; 3]), &|_| true, &question()).unwrap();
            let best = &found.list[0];
            assert!(found.scored >= 200 && found.list.len() <= 12);
            assert_eq!(best.support_mm3, 0.0, "{best:?}");
            assert!(best.pareto && best.fits);
            // Upside down, or lying on its side of 4 mm depth: both need no support; lying is lower.
            let up = [0, 1, 2].map(|a| (0..3).map(|k| r[k][a] * best.up[k]).sum::<f64>());
            assert!(up[2] < -0.999 || up[1].abs() > 0.999, "{up:?}");
            assert!(found.list.windows(2).all(|w| !w[1].fits || w[0].cost <= w[1].cost));
        }
    }

    #[test]
    fn what_topples_comes_after_what_stands() {
        // A plate on the tip of a wedge: nothing hangs over there, but it does not stand.
        let outline = [[0.0, 0.0], [20.0, 20.0], [20.0, 22.0], [-20.0, 22.0], [-20.0, 20.0]];
        let mesh = crate::geometry::extruded(&outline, &[[0, 1, 4], [4, 1, 2], [4, 2, 3]], 30.0);
        let fdm = Question { footing: Footing::Needed, ..question() };
        let found = orientations(&mesh, &|_| true, &fdm).unwrap().list;
        assert!(!found[0].topples && found.iter().any(|o| o.topples), "{found:?}");
        let first = found.iter().position(|o| o.topples).unwrap();
        assert!(found[first..].iter().all(|o| o.topples || !o.fits));
        assert!(orientations(&mesh, &|_| true, &question()).unwrap().list.iter().all(|o| !o.topples));
        let turn = super::super::least_hanging(&mesh, &|_| true, &fdm).unwrap();
        assert!(fdm.is_footed(&standing(&mesh, &upright(turn.up)), |_| true), "{turn:?}");
    }

    #[test]
    fn a_ring_without_a_flat_face_lies_flat_however_it_is_turned() {
        // A torus of radii 8 and 2 mm.
        let round = (0..32).map(|k| (std::f64::consts::TAU * f64::from(k) / 32.0).sin_cos());
        let ring = crate::geometry::revolved(&round.map(|(s, c)| [8.0 + 2.0 * c, 2.0 * s]).collect::<Vec<_>>(), 64);
        for turn in [[-0.2096, -0.7642, 0.61], [0.5, 0.3, -0.2]] {
            let r = upright(turn);
            let back = [0, 1, 2].map(|a| [r[0][a], r[1][a], r[2][a]]);
            let turned = ring.transformed(back, [0.0; 3]);
            let question = Question { footing: Footing::Needed, ..question() };
            let best = &orientations(&turned, &|_| true, &question).unwrap().list[0];
            let off = angle(best.up, turn).to_degrees();
            assert!(best.from == "rest" && !best.topples && off.min(180.0 - off) < 0.1, "{off}: {best:?}");
            assert!((best.box_mm[2] - 4.0).abs() < 0.01, "{best:?}");
        }
    }

    #[test]
    fn what_rests_within_a_layer_needs_no_support() {
        // A slot, 0.15 mm high and 20 mm deep: what is laid over it rests on its floor.
        let outline =
            [[0.0, 0.0], [30.0, 0.0], [30.0, 5.0], [10.0, 5.0], [10.0, 5.15], [30.0, 5.15], [30.0, 10.0], [0.0, 10.0]];
        let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 7], [4, 5, 6], [4, 6, 7]];
        let slotted = crate::geometry::extruded(&outline, &caps, 18.0);
        let wanting = |q: &Question| stood(&slotted, &upright([0.0, 0.0, 1.0]), &|_| true, q).1;
        assert_eq!(wanting(&question()), Vec::<u32>::new());
        let thin = Question { layer_mm: 0.1, ..question() };
        let area: f64 = wanting(&thin).iter().map(|&f| slotted.facet_area(f as usize)).sum();
        assert!((area - 360.0).abs() < 1e-9, "{area}");
    }

    #[test]
    fn what_lies_on_the_plate_stands_on_no_support() {
        // A plate of 40 × 10 mm that leans by 1 in 100 and stands on an edge, as AM204 judges it: over a quarter it is no more than half a layer above.
        let outline = [[0.0, 0.0], [40.0, 0.4], [40.0, 3.0], [0.0, 3.0]];
        let leaning = crate::geometry::extruded(&outline, &[[0, 1, 2], [0, 2, 3]], 10.0);
        let asked = Question { given: Some([0.0, 0.0, 1.0]), best: 1, ..question() };
        let found = orientations(&leaning, &|_| true, &asked).unwrap().list;
        let o = found.iter().find(|o| o.from == "given").unwrap();
        // 10 mm times the mean of 0.1 and 0.4 mm over 30 mm.
        assert!((o.support_low_mm3 - 75.0).abs() < 1e-3 && (o.support_high_mm3 - 75.0).abs() < 1e-3, "{o:?}");
        assert!((o.contact_mm2 - 300.0).abs() < 0.1 && o.on_part_mm2 < 1e-6, "{o:?}");
    }

    #[test]
    fn a_bell_keeps_liquid_upside_down_and_a_cup_sucks_on_the_film() {
        // A square cup with walls and a floor of 2 mm about 16 × 16 × 18 mm, its mouth up.
        let ring = |half: f64, z: f64| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
        let rings = [ring(10.0, 0.0), ring(10.0, 20.0), ring(8.0, 20.0), ring(8.0, 2.0)];
        let mut facets = Vec::new();
        for (pair, k) in rings.windows(2).flat_map(|pair| (0..4).map(move |k| (pair, k))) {
            let [a, b, c, d] = [pair[0][k], pair[0][(k + 1) % 4], pair[1][(k + 1) % 4], pair[1][k]];
            facets.extend([[a, b, c], [a, c, d]]);
        }
        let ([a, b, c, d], [e, f, g, h]) = (rings[0], rings[3]);
        facets.extend([[a, c, b], [a, d, c], [e, f, g], [e, g, h]]);
        let mesh = TriangleMesh::weld(facets);
        let volume = 16.0 * 16.0 * 18.0;
        for (liquid, held) in [(Liquid::Vat, volume), (Liquid::None, 0.0)] {
            let along = |z: f64| {
                let asked = Question { liquid, given: Some([0.0, 0.0, z]), best: 1, ..question() };
                let found = orientations(&mesh, &|_| true, &asked).unwrap().list;
                [found[0].retained_mm3, found[0].suction_mm3]
            };
            // A sample along each face of the void may be counted or not.
            let near = |v: f64| (v - held).abs() <= 0.15 * held;
            let (up, down) = (along(1.0), along(-1.0));
            assert!(up[0] == 0.0 && near(up[1]) && near(down[0]) && down[1] == 0.0, "{up:?}, {down:?}");
        }
    }

    #[test]
    fn a_direction_of_any_length_is_one() {
        let r = upright([0.3e200, -0.2e200, -0.9e200]);
        assert!(is_rotation(&r) && is_rotation(&upright([0.3e-200, -0.2e-200, -0.9e-200])), "{r:?}");
        assert_eq!(upright([0.0, 0.0, 1e-310]), upright([0.0, 0.0, 1.0]));
    }

    #[test]
    fn a_part_without_volume_is_refused() {
        assert!(orientations(&TriangleMesh::default(), &|_| true, &question()).is_err());
    }
}
