//! AM202: places where a layer starts in mid-air.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, Witness};
use super::hanging::islands_of;
use super::place::{group_equal, locate, reported};
use crate::error::Result;
use crate::geometry::vector::{along, sub};
use crate::layer::Island as Start;
use crate::part::Part;
use crate::process::Process;
use crate::units::{report_digits, short};

/// AM202 `island`.
pub struct Island;

/// Share of the way from a corner of a facet to its middle at which what lies below the corner is looked for.
const BESIDE: f64 = 0.01;

static META: Meta = Meta {
    code: "AM202",
    name: "island",
    title: "Layer regions with nothing beneath",
    what: "Finds every place where material begins above the plate with none of its own beneath it, and gives the area of its \
           first layer and how far it rises before it joins the rest.",
    why: "The first layer of an island is printed on nothing: it is dragged away by the nozzle, or floats off in the vat.",
    how: "Material begins at local minima of the height of the surface that have material above them. All minima of a mesh lie at \
          vertices, so a sweep from the lowest vertex up, joining components as they meet, finds every one. One that joins \
          material that began lower within a layer is printed with it. What has other material no more than a layer below any of its \
          underside is carried by that, and its free rest is judged as a ceiling. The support that is advised \
          reaches down to what lies below the first layer, the part or the plate.",
    limits: "What starts within half a layer of the plate stands on it. Where bodies cross, an underside is looked at from 15 places of each of its facets. Islands held by a support are still \
             listed: they are where supports must stand.",
    source: "Merge tree of the height function: H. Carr, J. Snoeyink, U. Axen, Computing contour trees in all dimensions, 2003.",
};

impl Check for Island {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        if process.powder_supports {
            return Ok(Outcome::NotApplicable("loose powder holds the part up in this process".into()));
        }
        let Some(limits) = limits_of(process, "island") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let found = islands_of(part, process);
        let mut measured = Measured {
            cover: format!(
                "Every local minimum of the surface was judged, at layers of {} mm.",
                short(process.layer_height_mm)
            ),
            rule: Some("island"),
            ..Measured::default()
        };
        measured.worst =
            Some(found.iter().max_by(|a, b| a.first_layer_area_mm2.total_cmp(&b.first_layer_area_mm2)).map_or(
                Worst { bracket: Bracket::exact(0.0), unit: "mm2", at: None },
                |i| Worst { bracket: Bracket::exact(i.first_layer_area_mm2), unit: "mm2", at: Some(i.lowest) },
            ));
        let findings = found.iter().map(|i| {
            let bracket = Bracket::exact(i.first_layer_area_mm2);
            let mut f = Finding::judged(META.code, "start", bracket, Basis::Exact, limits, "mm2", 0.0);
            f.area_mm2 = Some(report_digits(i.first_layer_area_mm2));
            locate(&mut f, part, context, i.lowest, i.extent);
            let layer = (i.lowest[2] / process.layer_height_mm).floor().max(0.0) as u64;
            f.layers = Some([layer, layer]);
            f.witness = Some(Witness { kind: "lowest-point".into(), points_mm: vec![reported(part, i.lowest)] });
            let rise = if i.rise_mm.is_finite() {
                format!("joins the rest {} mm higher", short(i.rise_mm))
            } else {
                "never joins the rest".into()
            };
            f.message = format!("starts in mid-air at z = {} mm, {rise}", short(i.lowest[2]));
            f.fix = support(part, i, process.layer_height_mm);
            f
        });
        measured.findings = group_equal(findings.collect(), 1e-3);
        for f in measured.findings.iter_mut().filter(|f| f.count > 1) {
            f.message = format!("{} places: {}", f.count, f.message);
        }
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// A support down to what lies below an island's first layer, the part or the plate, in words: as high as it has to be where that comes
/// nearest and where it is farthest.
///
/// Looked for straight down from beside each corner of the first layer's underside, and measured from there: where the floor curves as the
/// island does, it is higher beside the lowest point than below it.
fn support(part: &Part, island: &Start, layer_mm: f64) -> String {
    let z = island.lowest[2];
    let heights = island.underside.iter().flat_map(|&f| {
        let (middle, normal) = (part.mesh().centroid(f as usize), part.mesh().normal(f as usize));
        let corners = part.mesh().corners(f as usize).into_iter().filter(move |c| c[2] <= z + layer_mm);
        corners.map(move |c| {
            let from = along(along(c, sub(middle, c), BESIDE), normal, 2.0 * part.step());
            let met = part.distance().first_hit(from, [0.0, 0.0, -1.0], 0.0, f64::INFINITY);
            met.map_or(from[2], |(s, _)| s.min(from[2]))
        })
    });
    let (least, most) = heights.fold((f64::INFINITY, 0.0f64), |(least, most), h| (least.min(h), most.max(h)));
    let (least, most) = if least > most { (z, z) } else { (least.max(0.0), most) };
    let high = match most - least <= layer_mm {
        true => short(report_digits(least)),
        false => format!("{} to {}", short(report_digits(least)), short(report_digits(most))),
    };
    format!("put a support of {high} mm under it, or let it grow out of what is below")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::Up;
    use crate::check::hanging::{hanging_share, islands_turned};
    use crate::geometry::{cuboid, extruded, revolved};

    #[test]
    fn what_floats_is_not_carried_by_a_lip_of_its_own() {
        // A block with a slot 0.05 mm high above a lip of 0.1 mm, beside a plate and over one.
        let outline =
            [[0.0, 2.0], [10.0, 2.0], [10.0, 6.0], [0.0, 6.0], [0.0, 2.15], [5.0, 2.15], [5.0, 2.1], [0.0, 2.1]];
        let caps = [[0, 1, 6], [0, 6, 7], [1, 5, 6], [1, 2, 5], [2, 4, 5], [2, 3, 4]];
        let fdm = Process::named("fdm").unwrap();
        let block = extruded(&outline, &caps, 8.0);
        for (plate, is_held) in [([20.0, 0.0, 0.0], false), ([0.0, 0.0, 0.9], true)] {
            let plate = cuboid(plate, [plate[0] + 10.0, 8.0, plate[2] + 1.0]);
            let ground = cuboid([40.0, 0.0, 0.0], [50.0, 8.0, 1.0]);
            let part = Part::new(block.clone().joined(&plate).joined(&ground), Up::PlusZ, 1e-6, 2.0).unwrap();
            let found = islands_of(&part, &fdm);
            let is_told = found.iter().any(|i| (i.lowest[2] - 2.0).abs() < 1e-9);
            assert_eq!(is_told, !is_held, "{found:?}");
            // Whichever way it was turned before it is stood up again.
            let over = part.mesh().transformed([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]], [0.0; 3]);
            let over = Part::new(over, Up::PlusZ, 1e-6, 2.0).unwrap();
            let again = islands_turned(&over, &fdm, [0.0, -1.0, 0.0]);
            assert_eq!(again.len(), found.len(), "{again:?}");
            let areas = |all: &[Start]| all.iter().map(|i| i.first_layer_area_mm2).sum::<f64>();
            assert!((areas(&again) - areas(&found)).abs() < 1e-6, "{again:?}");
        }
    }

    #[test]
    fn an_arm_that_hangs_down_is_an_island_however_it_is_joined_above() {
        // A block of 10 mm; from its edge at z = 20, broken or not, an arm hangs down to an edge at z = 10.
        let fdm = Process::named("fdm").unwrap();
        let sharp = [[0.0, 0.0], [10.0, 0.0], [10.0, 20.0], [20.0, 10.0], [22.0, 12.0], [8.0, 26.0], [0.0, 26.0]];
        let caps = [[0, 1, 2], [2, 3, 4], [2, 4, 5], [0, 2, 6], [2, 5, 6]];
        let all = |outline: &[[f64; 2]], caps: &[[usize; 3]]| {
            islands_of(&Part::new(extruded(outline, caps, 10.0), Up::PlusZ, 1e-6, 2.0).unwrap(), &fdm)
        };
        let found = all(&sharp, &caps);
        let is_it = |i: &Start| (i.lowest[2] - 10.0).abs() < 1e-9 && (i.first_layer_area_mm2 - 4.0).abs() < 1e-6;
        assert!(matches!(&found[..], [one] if is_it(one) && (one.rise_mm - 10.0).abs() < 1e-9), "{found:?}");
        for broken in [0.02, 0.05, 0.1] {
            let mut outline = sharp.to_vec();
            outline[1][0] += broken;
            outline.insert(2, [10.0 + broken, 20.0 - 2.0 * broken]);
            let caps = [[0, 1, 2], [0, 2, 3], [3, 4, 5], [3, 5, 6], [0, 3, 7], [3, 6, 7]];
            let found = all(&outline, &caps);
            assert!(matches!(&found[..], [one] if is_it(one)), "{broken}: {found:?}");
        }
    }

    #[test]
    fn a_plate_that_leans_over_another_is_carried_where_they_are_near() {
        // 20 × 14 mm, leaning by a degree, from 0.1 mm above another plate on.
        let fdm = Process::named("fdm").unwrap();
        let (s, c) = 1f64.to_radians().sin_cos();
        for (gap, is_carried) in [(0.1, true), (0.25, false)] {
            let leaning = cuboid([0.0; 3], [20.0, 14.0, 2.0])
                .transformed([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]], [5.0, 3.0, 2.0 + gap]);
            let mesh = cuboid([0.0; 3], [30.0, 20.0, 2.0]).joined(&leaning);
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 2.0).unwrap();
            assert_eq!(islands_of(&part, &fdm).is_empty(), is_carried, "{gap}");
            if is_carried {
                // What is no more than a layer above the plate below does not hang.
                let hangs = |f: usize| {
                    let hanging = part.mesh().normal(f)[2] < -0.9 && part.mesh().centroid(f)[2] > 1.0;
                    if hanging { hanging_share(&part, &fdm, f as u32) * part.mesh().facet_area(f) } else { 0.0 }
                };
                let area: f64 = (0..part.mesh().triangles.len()).map(hangs).sum();
                assert!((area - (20.0 - 0.1 / s) * 14.0).abs() < 0.02, "{area}");
            }
        }
    }

    #[test]
    fn a_support_reaches_down_to_what_is_below() {
        let words = |base: [f64; 3], low: f64| {
            let mesh = cuboid([0.0; 3], base).joined(&cuboid([5.0, 5.0, low], [15.0, 15.0, low + 5.0]));
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 2.0).unwrap();
            let found = islands_of(&part, &Process::named("fdm").unwrap());
            support(&part, &found[0], 0.2)
        };
        assert!(words([20.0, 20.0, 2.0], 7.0).starts_with("put a support of 5 mm under it"));
        assert!(words([20.0, 20.0, 2.0], 2.5).starts_with("put a support of 0.5 mm under it"));
        // Half of it lies above the base, and half above the plate.
        assert!(words([10.0, 20.0, 2.0], 7.0).starts_with("put a support of 5 to 7 mm under it"));
        assert!(words([4.0, 20.0, 2.0], 7.0).starts_with("put a support of 7 mm under it"));
    }

    #[test]
    fn a_support_over_a_floor_that_curves_with_the_island_is_as_high_as_their_gap() {
        // A ball of 5 mm in a socket about the same middle: straight down the gap is widest away from the lowest point.
        for gap in [0.3, 1.0] {
            let arc = |radius: f64, quarters: i32| {
                (0..=16 * quarters)
                    .map(move |n| (std::f64::consts::FRAC_PI_2 * f64::from(n) / 16.0).sin_cos())
                    .map(move |(s, c)| [radius * s, 10.0 - radius * c])
            };
            let ball: Vec<[f64; 2]> = arc(5.0, 2).collect();
            let socket: Vec<[f64; 2]> = [[0.0, 0.0], [9.0, 0.0], [9.0, 10.0]].into_iter().collect();
            let hollow: Vec<[f64; 2]> = arc(5.0 + gap, 1).collect();
            let socket: Vec<[f64; 2]> = socket.into_iter().chain(hollow.into_iter().rev()).collect();
            let mesh = revolved(&ball, 64).joined(&revolved(&socket, 64));
            let part = Part::new(mesh, Up::PlusZ, 1e-6, 2.0).unwrap();
            let [island] = &islands_of(&part, &Process::named("fdm").unwrap())[..] else { panic!() };
            let said = support(&part, island, 0.2);
            let high: f64 = said.split(' ').nth(4).and_then(|w| w.parse().ok()).unwrap();
            assert!(high >= gap - 1e-3 && high < gap + 0.01, "{gap}: {said}");
        }
    }
}
