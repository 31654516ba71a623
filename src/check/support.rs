//! AM204: what supports cost.

use super::contract::{Check, Context, Measured, Meta, Outcome, ShapeShown, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, State};
use super::hanging::{needing_support, supported};
use super::place::locate;
use crate::access::{Question, standing, stood, support_angle, up_option, upright};
use crate::error::Result;
use crate::geometry::vector::{Vec3, bounds};
use crate::geometry::{TriangleMesh, contour, occupancy};
use crate::grid::Grid;
use crate::layer::{SupportVolume, downward_facets, support_volume, supports};
use crate::part::Part;
use crate::process::Process;
use crate::units::{Angle, Length, report_digits, short};

/// AM204 `support`.
pub struct Support;

/// The supports that are shown are cast with this many samples along the longest side.
const SHOWN: f64 = 96.0;

static META: Meta = Meta {
    code: "AM204",
    name: "support",
    title: "Volume of supports and where they touch",
    what: "Measures the volume between the surface that needs support and the part or the plate below it, the area of the part that supports \
           touch from below, and the area on which they stand, on the plate and on the part. The value is the volume over that of the part.",
    why: "Supports cost material and time, leave marks where they touch, and have to come off; those that stand on the part mark it twice.",
    how: "What hangs over at less than the overhang angle, and is no bridge, ledge or crown that holds itself, is followed straight down. The plane is \
          cut into square columns and every facet is clipped to them exactly. Walking down a column, the area below hanging surface is known \
          between two bounds, which are equal wherever one kind of surface is met; volumes follow from moments. The contact on the \
          part is the exact area of the facets. Where it is open if a bridge or a ledge holds itself, the bounds go from what needs support for certain to that \
          with all that may. The turn that is advised is the one with the least volume of supports, of those by 90 degrees and the one \
          that `overhang` advises, which is that with the least area hanging over.",
    limits: "Columns are straight, as wide as what they hold up, and solid: slicers thin supports out, widen them or let them branch. The share at which \
             it warns is a convention.",
    source: "Divergence theorem, column by column; the limit is a convention of this program.",
};

/// A share that differs from a limit by less than the last digit that is reported is equal to it.
const TIE: f64 = 1e-6;

impl Check for Support {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        if process.powder_supports {
            return Ok(Outcome::NotApplicable("loose powder holds the part up in this process".into()));
        }
        if !process.prints_supports {
            return Ok(Outcome::NotApplicable("this process prints no supports".into()));
        }
        let (Some(limits), Some(angle)) = (limits_of(process, "support"), support_angle(process)) else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let mesh = part.mesh();
        let unheld = needing_support(part, process, context.refine);
        let (found, touched) = supported(part, process, &unheld, context.spacing_mm);
        let wanted = unheld.facets;
        let volume = if part.is_plain() { mesh.signed_volume() } else { part.solid()?.density.volume().as_mm3() };
        let [low, high] = found.volume_mm3.map(|v| v / volume.max(f64::MIN_POSITIVE));
        let bracket = Bracket::new(0.5 * (low + high), low, high);
        let at = heaviest(mesh, &wanted);
        let mut measured = Measured {
            worst: Some(Worst { bracket, unit: "1", at }),
            cover: if found.is_empty() {
                format!("No surface below {}° needs support.", short(angle))
            } else {
                format!(
                    "Supports of {}, for all surface below {}° that does not hold itself.",
                    amount(&found),
                    short(angle)
                )
            },
            rule: Some("support"),
            ..Measured::default()
        };
        if let (Some(at), Some(extent)) = (at, bounds(wanted.iter().flat_map(|&f| mesh.corners(f as usize)))) {
            measured.shapes.extend(shown(part, &wanted, &found));
            let basis = if part.is_plain() { Basis::Certified } else { Basis::Estimated };
            let mut f = Finding::judged(META.code, "volume", bracket, basis, limits, "1", TIE);
            if f.state != State::Pass {
                f.volume_mm3 = Some(report_digits(0.5 * (found.volume_mm3[0] + found.volume_mm3[1])));
                f.area_mm2 = Some(report_digits(touched[1]));
                locate(&mut f, part, context, at, ([extent.0[0], extent.0[1], 0.0], extent.1));
                let [touched, plate, on_part] = [touched, found.on_plate_mm2, found.on_part_mm2].map(stood_on);
                f.message = format!(
                    "supports of {} touch {touched} of the part and stand with {plate} on the plate and {on_part} on the part",
                    amount(&found)
                );
                f.fix = turned(part, process, angle, context.spacing_mm, &found);
                measured.findings.push(f);
            }
        }
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// The volume with its unit and, where they differ, its bounds.
fn amount(found: &SupportVolume) -> String {
    let [low, high] = found.volume_mm3.map(|v| v / 1000.0);
    let digits = |v: f64| short((v * 1000.0).round() / 1000.0);
    if high - low < 0.005 * high {
        format!("{} cm³", digits(0.5 * (low + high)))
    } else {
        format!("{} to {} cm³", digits(low), digits(high))
    }
}

/// An area that supports stand on, with its bounds where they differ.
fn stood_on(bounds: [f64; 2]) -> String {
    let [low, high] = bounds.map(|area| short(area.round()));
    if low == high { format!("{low} mm²") } else { format!("{low} to {high} mm²") }
}

/// Middle of the facet over the highest column: area times height is greatest.
fn heaviest(mesh: &TriangleMesh, facets: &[u32]) -> Option<Vec3> {
    let weight = |&f: &u32| -mesh.area_vector(f as usize)[2] * mesh.centroid(f as usize)[2];
    facets.iter().max_by(|a, b| weight(a).total_cmp(&weight(b))).map(|&f| mesh.centroid(f as usize))
}

/// The supports as a shape, coarser than the check's own columns; none where the part cannot be cast so.
fn shown(part: &Part, wanted: &[u32], found: &SupportVolume) -> Option<ShapeShown> {
    let extent = part.extent();
    let h = extent.into_iter().fold(0.0, f64::max) / SHOWN;
    let grid = Grid::covering([0.0; 3], extent, Length::mm(h), 1, [0.0; 3]).ok()?;
    let centres = occupancy(part.mesh(), &grid).ok()?;
    let made = supports(&centres, part.mesh(), wanted, 0.0).ok()?;
    let mesh = contour::surface(&made.columns, |_| 0.5).ok()?;
    (!made.is_empty()).then(|| ShapeShown { name: "supports", title: format!("Supports, {}", amount(found)), mesh })
}

/// The turn that takes the least support, measured again in that pose: of those by 90° in which the part stands, where all that hangs over
/// is held up, and the one in which the least area hangs over, which is told where no other takes less.
fn turned(part: &Part, process: &Process, angle: f64, column_mm: f64, now: &SupportVolume) -> String {
    let turns: [[Vec3; 3]; 5] = [
        [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
        [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
    ];
    let longest = part.extent().into_iter().fold(0.0, f64::max);
    let columns = column_mm.max(longest / SHOWN);
    let bounding = |f: usize| part.bounds_solid(f);
    let asked = Question::of(process, part.step());
    let least_area = part.least_hanging(&asked).map(|turn| {
        let (mesh, wanted) = stood(part.mesh(), &upright(turn.up), part, &asked);
        let found = support_volume(&mesh, bounding, &wanted, 0.0, columns);
        (found.volume_mm3[1], up_option(part.direction_to_file(turn.up)))
    });
    let by_quarters = turns
        .into_iter()
        .filter_map(|rotation| {
            let mesh = standing(part.mesh(), &rotation);
            if !asked.stands(&mesh, bounding) {
                return None;
            }
            let facets = downward_facets(&mesh, 0.0, Angle::degrees(angle), part.step());
            let wanted: Vec<u32> = facets.into_iter().filter(|&f| bounding(f as usize)).collect();
            let found = support_volume(&mesh, bounding, &wanted, 0.0, columns);
            Some((found.volume_mm3[1], up_option(part.direction_to_file(rotation[2]))))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    // Below a cubic millimetre all are alike.
    let volume = |t: &(f64, String)| t.0.max(0.5);
    let best = least_area.into_iter().chain(by_quarters).min_by(|a, b| volume(a).total_cmp(&volume(b)));
    match best {
        Some((volume, up)) if volume <= 0.5 => format!("with --up {up} it takes less than 1 mm³"),
        Some((volume, up)) if volume < 0.8 * now.volume_mm3[0] => {
            let cost = short(volume.round() / 1000.0);
            format!("with --up {up} it takes at most {cost} cm³, the least of the turns tried")
        }
        _ => format!(
            "neither a turn by 90° in which it stands nor the one with the least area hanging over takes less than {} cm³; `amcheck orient` tries all directions",
            short((0.8 * now.volume_mm3[0]).round() / 1000.0)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{cuboid, extruded};
    use crate::part::Up;

    #[test]
    fn what_lies_on_the_plate_stands_on_no_support() {
        // A plate of 40 × 10 mm that leans by 1 in 100 and stands on an edge: over a quarter it is no more than half a layer above the plate.
        let leaning = extruded(&[[0.0, 0.0], [40.0, 0.4], [40.0, 3.0], [0.0, 3.0]], &[[0, 1, 2], [0, 2, 3]], 10.0);
        let part = Part::new(leaning, Up::PlusZ, 1e-6, 1.0).unwrap();
        let mut process = Process::named("fdm").unwrap();
        process.override_limit("support=0.01").unwrap();
        let context = Context { refine: 0, spacing_mm: 0.5 };
        let Outcome::Measured(found) = Support.run(&part, &process, &context).unwrap() else { panic!() };
        let [f] = &found.findings[..] else { panic!("{}", found.cover) };
        // 10 mm times the mean of 0.1 and 0.4 mm over 30 mm.
        assert!((f.volume_mm3.unwrap() - 75.0).abs() < 1e-3, "{:?}", f.volume_mm3);
        let said = "touch 300 mm² of the part and stand with 300 mm² on the plate and 0 mm² on the part";
        assert!(f.message.contains(said), "{}", f.message);
    }

    #[test]
    fn what_rests_on_another_body_is_held_by_no_support_whatever_its_facets() {
        // An arm of 40 mm, 30 mm above the plate; its outer half lies a half layer above a body.
        let (a, b) = ([[0.0, 0.0], [5.0, 0.0], [5.0, 30.0]], [[45.0, 30.0], [45.0, 35.0], [0.0, 35.0]]);
        let whole = extruded(&[a, b].concat(), &[[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]], 10.0);
        let outline = [&a[..], &[[25.0, 30.0]], &b[..]].concat();
        let halved = extruded(&outline, &[[0, 1, 2], [0, 2, 6], [2, 3, 6], [3, 5, 6], [3, 4, 5]], 10.0);
        let body = cuboid([25.0, 0.0, 0.0], [45.0, 10.0, 29.9]);
        let process = Process::named("fdm").unwrap();
        let truth = 200.0 * 30.0 / (1750.0 + 2000.0 + 200.0 * 29.9);
        for mesh in [whole, halved] {
            let part = Part::new(mesh.joined(&body), Up::PlusZ, 1e-6, 1.0).unwrap();
            let context = Context { refine: 0, spacing_mm: 0.5 };
            let Outcome::Measured(found) = Support.run(&part, &process, &context).unwrap() else { panic!() };
            let f = found.findings.first().unwrap();
            assert!(f.low <= truth + 1e-9 && truth <= f.high + 1e-9, "{} … {} for {truth}", f.low, f.high);
            assert!((f.area_mm2.unwrap() - 200.0).abs() < 0.1, "{:?}", f.area_mm2);
            assert!(f.message.contains(" on the plate and 0 "), "{}", f.message);
        }
    }
}
