//! Which way to print: many directions scored on the mesh, the best measured in full, and those that nothing beats.

use super::direction::{Facets, LEVEL, Score, Whole, candidates};
use crate::error::{Error, Result};
use crate::geometry::vector::{Vec3, angle, unit};
use crate::geometry::{Hull, TriangleMesh, occupancy};
use crate::grid::Grid;
use crate::layer::{
    Measuring, Search, SelfHolding, ceilings, downward_facets, hidden_from_outside, section_area, section_points,
    support_volume, supports,
};
use crate::process::Process;
use crate::topology::{Falls, Passage, retained};
use crate::units::{Angle, Length, report_digits};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What is asked of the orientations of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Downward surface below this angle from the horizontal needs support; `None` where nothing does.
    pub support_angle: Option<Angle>,
    /// What prints without support all the same.
    pub self_holding: SelfHolding,
    pub layer_mm: f64,
    pub build_volume_mm: [f64; 3],
    /// Resolution of the coordinates, mm.
    pub step_mm: f64,
    /// Directions spread over the sphere, beside the axes and the part's faces.
    pub directions: usize,
    /// How many of them are measured in full.
    pub best: usize,
    /// A direction that is among these whatever its score.
    pub given: Option<Vec3>,
    /// Directions nearer to each other are one.
    pub apart: Angle,
    /// Samples along the longest side for the full measure.
    pub samples: usize,
    /// What is asked of a pose beside that.
    pub footing: Footing,
}

/// Whether a part has to stand by itself while it is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Footing {
    /// Its centre of mass has to lie over its first layer: poses that topple come after those that do not.
    Needed,
    /// Powder or supports hold it.
    Any,
}

impl Question {
    /// What a process asks: 400 directions, the best 20 in full at 128 samples.
    pub fn of(process: &Process, step_mm: f64) -> Self {
        let angle = process.limit("overhang").and_then(|l| l.warn.or(l.fail)).filter(|_| !process.powder_supports);
        Question {
            support_angle: angle.map(Angle::degrees),
            self_holding: self_holding(process),
            layer_mm: process.layer_height_mm,
            build_volume_mm: process.build_volume_mm,
            step_mm,
            directions: 400,
            best: 20,
            given: None,
            apart: Angle::degrees(8.0),
            samples: 128,
            footing: if process.limit("tall-feature.topple").is_some() { Footing::Needed } else { Footing::Any },
        }
    }

    /// Whether a part that stands on z = 0 may stand so.
    pub(super) fn is_footed(&self, posed: &TriangleMesh, bounding: impl Fn(usize) -> bool) -> bool {
        self.footing == Footing::Any
            || posed
                .centre_of_mass(bounding)
                .is_some_and(|[x, y, _]| Hull::of(section_points(posed, 0.5 * self.layer_mm)).depth([x, y]) >= 0.0)
    }

    /// Whether a box, turned about the vertical by 90° if that helps, fits the machine.
    pub(super) fn fits(&self, [w, d, height]: Vec3) -> bool {
        let [x, y, z] = self.build_volume_mm;
        height <= z && ((w <= x && d <= y) || (d <= x && w <= y))
    }
}

/// What prints without support in a process: the stricter limit of each rule.
pub fn self_holding(process: &Process) -> SelfHolding {
    let limit = |key: &str| process.limit(key).and_then(|l| l.warn.or(l.fail));
    SelfHolding {
        bridge_mm: limit("bridge"),
        ledge_mm: limit("bridge.ledge"),
        crown_mm: limit("bridge.horizontal-hole"),
    }
}

/// One way to stand the part up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Orientation {
    /// The direction of the file that points up.
    pub up: Vec3,
    /// Rows of the rotation from the frame of the file to that of the build.
    pub rotation: [Vec3; 3],
    /// How the direction was found: `given`, `axis`, `face` or `sphere`.
    pub from: String,
    /// Sides of the box in this pose, mm.
    pub box_mm: Vec3,
    /// Whether the box, turned about the vertical by 90° if that helps, fits the machine.
    pub fits: bool,
    /// Whether it topples by itself, where the process minds.
    #[serde(default)]
    pub topples: bool,
    /// Support volume, mm³, with its bounds.
    pub support_mm3: f64,
    pub support_low_mm3: f64,
    pub support_high_mm3: f64,
    /// Area of the part that supports touch from below, mm².
    pub contact_mm2: f64,
    /// Area on which supports stand on the part, mm².
    pub on_part_mm2: f64,
    /// Support volume that no straight line along the 26 directions of the lattice reaches from outside, mm³: an estimate.
    pub secluded_mm3: f64,
    /// Volume of liquid that stays in cups in this pose, mm³: an estimate.
    pub retained_mm3: f64,
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
/// Every direction, `directions` of a Fibonacci lattice, the six axes and the normals of the part's largest flat faces, gets a
/// score from the mesh alone, in which supports reach down to the plate. The best, at least `apart` from each other, are posed and measured: support
/// volume by columns ([`support_volume`]), what of it cannot be seen from outside, liquid kept in cups, first layer, steps.
/// The cost of a pose is
///
/// support/V + 3·secluded/V + (contact + feet on the part)/A + ½·retained/V + steps/V + 0.2·height/diagonal + 1/(1 + first layer/0.01·A)
///
/// with the part's volume V and area A: a convention. Poses that do not fit the machine come last, and before them those that topple, where the
/// process minds. Only the directions listed are
/// compared. `bounding` says which facets bound the solid.
///
/// # Errors
/// [`Error::NoGeometry`] without facets or volume.
///
/// # Cost
/// O(directions·facets) and, for each of the best, one support volume and one cast at `samples`.
pub fn orientations(
    mesh: &TriangleMesh,
    bounding: impl Fn(usize) -> bool + Sync,
    question: &Question,
) -> Result<Orientations> {
    let facets = Facets::of(mesh, &bounding, question.directions);
    let volume = mesh.signed_volume().abs();
    let area: f64 = facets.size.iter().sum();
    let diagonal = mesh.bounds().map_or(0.0, |(lo, hi)| crate::geometry::vector::distance(lo, hi));
    if !(volume > 0.0 && area > 0.0 && diagonal.is_finite()) {
        return Err(Error::NoGeometry {
            problem: "the part has no volume to be oriented".into(),
            remedy: "export a closed solid".into(),
        });
    }
    let whole = Whole { volume, area, diagonal };
    let candidates = candidates(&facets, question.directions);
    let mut scores: Vec<Score> =
        candidates.into_par_iter().with_max_len(1).map(|(up, from)| facets.score(up, from, question, &whole)).collect();
    let scored = scores.len();
    scores.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut chosen: Vec<Score> =
        question.given.map(|up| facets.score(unit(up), "given", question, &whole)).into_iter().collect();
    // Hardly anything stands on a curved side: where it has to stand, half of what is measured stands on an axis or a face.
    let on_faces = if question.footing == Footing::Needed { question.best.div_ceil(2) } else { 0 };
    let is_on_face = |s: &Score| s.from != "sphere";
    let (flat, all) = (scores.iter().filter(|s| is_on_face(s)), scores.iter());
    for (s, most) in flat.map(|s| (s, on_faces)).chain(all.map(|s| (s, question.best))) {
        if chosen.len() < most && chosen.iter().all(|c| angle(c.up, s.up) > question.apart.as_radians()) {
            chosen.push(*s);
        }
    }
    let list: Result<Vec<Orientation>> =
        chosen.par_iter().with_max_len(1).map(|s| measure(mesh, &bounding, s, question, &whole)).collect();
    let mut list = list?;
    mark_unbeaten(&mut list);
    list.sort_by(|a, b| b.fits.cmp(&a.fits).then(a.topples.cmp(&b.topples)).then(a.cost.total_cmp(&b.cost)));
    Ok(Orientations { scored, list })
}

/// The rotation that brings a direction to +z by the shortest way.
pub fn upright(up: Vec3) -> [Vec3; 3] {
    let [x, y, z] = unit(up);
    if z < -1.0 + 1e-12 {
        return [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    }
    let k = 1.0 / (1.0 + z);
    [[1.0 - k * x * x, -k * x * y, -x], [-k * x * y, 1.0 - k * y * y, -y], [x, y, z]]
}

/// Poses the part and measures it.
fn measure(
    mesh: &TriangleMesh,
    bounding: &(impl Fn(usize) -> bool + Sync),
    score: &Score,
    q: &Question,
    whole: &Whole,
) -> Result<Orientation> {
    let rotation = upright(score.up);
    let posed = standing(mesh, &rotation);
    let size = posed.bounds().unwrap_or_default().1;
    let h = size.into_iter().fold(0.0, f64::max) / q.samples.max(1) as f64;
    let wanted = wanting_support(&posed, bounding, q);
    let found = support_volume(&posed, bounding, &wanted, 0.0, h);
    let contact: f64 = wanted.iter().map(|&f| posed.facet_area(f as usize)).sum();
    let grid = Grid::covering([0.0; 3], size, Length::mm(h), 1, [0.0; 3])?;
    let sample = h * h * h;
    // A surface that is not closed cannot be cast by its crossings; then these two are not known and count nothing.
    let (secluded, kept) = match occupancy(&posed, &grid) {
        Ok(centres) => {
            let columns = supports(&centres, &posed, &wanted, 0.0)?.columns;
            let hidden = hidden_from_outside(&centres)?.intersection(&columns)?.count();
            (
                hidden as f64 * sample,
                retained(&centres.complement(), Falls::Down, Passage::Faces)?.count() as f64 * sample,
            )
        }
        Err(_) => (0.0, 0.0),
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
    let cost = (support + 3.0 * secluded + 0.5 * kept + cusp) / whole.volume
        + (contact + on_part) / whole.area
        + 0.2 * size[2] / whole.diagonal
        + 1.0 / (1.0 + bed / (HELD * whole.area));
    let digits = report_digits;
    Ok(Orientation {
        up: score.up,
        rotation,
        from: score.from.into(),
        box_mm: size.map(digits),
        fits: q.fits(size),
        topples: !q.is_footed(&posed, bounding),
        support_mm3: digits(support),
        support_low_mm3: digits(found.volume_mm3[0]),
        support_high_mm3: digits(found.volume_mm3[1]),
        contact_mm2: digits(contact),
        on_part_mm2: digits(on_part),
        secluded_mm3: digits(secluded),
        retained_mm3: digits(kept),
        cusp_mm3: digits(cusp),
        bed_mm2: digits(bed),
        cost: digits(cost),
        pareto: false,
        wanting_support: wanted,
    })
}

/// A part turned and moved so that its box begins at the origin.
pub fn standing(mesh: &TriangleMesh, rotation: &[Vec3; 3]) -> TriangleMesh {
    let turned = mesh.transformed(*rotation, [0.0; 3]);
    let (lo, _) = turned.bounds().unwrap_or_default();
    turned.transformed([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], lo.map(|c| -c))
}

/// The facets of a part that stands on z = 0 that need support: what hangs over and does not hold itself.
pub fn wanting_support(posed: &TriangleMesh, bounding: impl Fn(usize) -> bool, q: &Question) -> Vec<u32> {
    let Some(angle) = q.support_angle else { return Vec::new() };
    let plate = 0.5 * q.layer_mm;
    let mut hanging = downward_facets(posed, plate, angle, q.step_mm);
    hanging.retain(|&f| bounding(f as usize));
    let ledge_mm = q.self_holding.ledge_mm.unwrap_or(0.0);
    let bridge_mm = q.self_holding.bridge_mm.unwrap_or(f64::INFINITY);
    let (layer_mm, step_mm) = (q.layer_mm, q.step_mm);
    let how = Measuring { plate_z: plate, layer_mm, ledge_mm, bridge_mm, step_mm, search: Search::Judge };
    let mut wanted: Vec<u32> = ceilings(posed, &hanging, how, &())
        .into_iter()
        .filter(|c| !q.self_holding.holds(c))
        .flat_map(|c| c.facets)
        .collect();
    wanted.sort_unstable();
    wanted
}

/// Marks the orientations that no other beats in everything.
fn mark_unbeaten(list: &mut [Orientation]) {
    let aims = |o: &Orientation| {
        [
            o.support_mm3,
            o.contact_mm2 + o.on_part_mm2,
            o.secluded_mm3,
            o.retained_mm3,
            o.box_mm[2],
            o.cusp_mm3,
            -o.bed_mm2,
            f64::from(u8::from(o.topples)),
        ]
    };
    let all: Vec<[f64; 8]> = list.iter().map(aims).collect();
    for (i, o) in list.iter_mut().enumerate() {
        let beats = |other: &[f64; 8]| {
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

    /// A T that has been laid askew: its best pose, with the bar down, is one of its own faces.
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
            let found = orientations(&t.transformed(r, [0.0; 3]), |_| true, &question()).unwrap();
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
        let found = orientations(&mesh, |_| true, &fdm).unwrap().list;
        assert!(!found[0].topples && found.iter().any(|o| o.topples), "{found:?}");
        let first = found.iter().position(|o| o.topples).unwrap();
        assert!(found[first..].iter().all(|o| o.topples || !o.fits));
        assert!(orientations(&mesh, |_| true, &question()).unwrap().list.iter().all(|o| !o.topples));
        let turn = super::super::least_hanging(&mesh, |_| true, &fdm).unwrap();
        assert!(fdm.is_footed(&standing(&mesh, &upright(turn.up)), |_| true), "{turn:?}");
    }

    #[test]
    fn a_part_without_volume_is_refused() {
        assert!(orientations(&TriangleMesh::default(), |_| true, &question()).is_err());
    }
}
