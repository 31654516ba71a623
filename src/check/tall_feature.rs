//! AM205: what stands tall on little.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, State, Witness};
use super::place::{group_equal, locate, reported};
use crate::error::Result;
use crate::geometry::Hull;
use crate::geometry::vector::Vec3;
use crate::layer::{TallFeature as Feature, section_points, tall_features};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// AM205 `tall-feature`.
pub struct TallFeature;

/// A section longer than this many times its width carries a wall, not a pillar.
const WALL: f64 = 4.0;
/// How much deeper than asked the centre of mass lies over a foot that is advised, millimetres.
const SPARE: f64 = 1.0;
/// Feet that are tried, and sides of the polygon that one is.
const FEET: usize = 8;
const SIDES: usize = 32;

static META: Meta = Meta {
    code: "AM205",
    name: "tall-feature",
    title: "Pillars that are slender, and parts that topple",
    what: "Finds pillars: pieces of the part that rise high above the section that carries them; the value is height over the section's \
           least width. Where the process says so, it also measures how far inside the footprint the centre of mass lies.",
    why: "A slender pillar sways under the nozzle, the recoater or the peel, and breaks or prints crooked. A part whose centre of mass \
          is not above its footprint stands on its supports alone.",
    how: "Layers are followed from the top down. A connected piece above a layer is judged by its height over the least width of the convex \
          hull of its section there, so that legs under a common top, or the four walls of a box, count together; each piece is reported at \
          its most slender layer, when it joins another. Samples find the place, height and width are then measured on the mesh, at half the first \
          layer or above. Sections longer \
          than four times their width carry walls, which `thin-wall` judges. The centre of mass is exact for a closed mesh, the \
          footprint is the convex hull of the section at half the first layer.",
    limits: "A pillar thinner than the spacing of the grid may be missed. Bracing that touches no layer below, such as supports, is not \
             counted. The value is that of the sampled layers, so it is an estimate.",
    source: "The limits' sources stand in the profile. Least width of a hull by its edges: H. Freeman, R. Shapira, Determining the \
             minimum-area encasing rectangle for an arbitrary closed curve, 1975.",
};

impl Check for TallFeature {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, "tall-feature") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let least = limits.warn.or(limits.fail).unwrap_or(0.0);
        // A sixth below the limit, so that the worst value is told where it is near.
        let bottom = part.mesh().bounds().map_or(0.0, |(lo, _)| lo[2]);
        let lowest = bottom + 0.5 * process.layer_height_mm;
        let found = tall_features(&part.solid()?.centres, part.mesh(), least / 1.2, WALL, lowest);
        let worst = found.iter().max_by(|a, b| a.slenderness().total_cmp(&b.slenderness()));
        let mut measured = Measured {
            worst: worst.map(|f| Worst { bracket: bracket(f, context), unit: "1", at: Some(f.foot) }),
            cover: "Every connected piece above every layer of samples was judged.".into(),
            rule: Some("tall-feature"),
            ..Measured::default()
        };
        let pillar = |t: &Feature| {
            let mut f = Finding::judged(META.code, "pillar", bracket(t, context), Basis::Estimated, limits, "1", 1e-6);
            locate(&mut f, part, context, t.foot, t.extent);
            let layer = |z: f64| (z / process.layer_height_mm).floor().max(0.0) as u64;
            f.layers = Some([layer(t.extent.0[2]), layer(t.extent.1[2])]);
            let top = [t.foot[0], t.foot[1], t.extent.1[2]];
            f.witness =
                Some(Witness { kind: "pillar".into(), points_mm: vec![reported(part, t.foot), reported(part, top)] });
            f.message = format!(
                "pillar of {} mm stands on a section {} mm wide: {} times its width",
                short(round(t.height_mm)),
                short(round(t.width_mm.0)),
                short((10.0 * t.slenderness()).round() / 10.0)
            );
            // As much as clears the limit for certain.
            f.fix = format!(
                "widen its foot to {} mm, shorten it to {} mm, or brace it",
                short((100.0 * (t.height_mm + context.spacing_mm) / least).ceil() / 100.0),
                short((100.0 * (t.width_mm.0 * least - context.spacing_mm)).floor() / 100.0)
            );
            f
        };
        let mut findings: Vec<Finding> = found.iter().map(pillar).filter(|f| f.state != State::Pass).collect();
        findings.sort_by(Finding::worst_first);
        measured.findings = group_equal(findings, 0.5);
        for f in measured.findings.iter_mut().filter(|f| f.count > 1) {
            f.message = format!("{} places: {}", f.count, f.message);
        }
        measured.findings.extend(topple(part, process, context));
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

fn round(mm: f64) -> f64 {
    (100.0 * mm).round() / 100.0
}

/// The measured section exists, so the value is reached; the pillar may go on below it for up to a sample.
fn bracket(f: &Feature, context: &Context) -> Bracket {
    Bracket::new(f.slenderness(), f.slenderness(), (f.height_mm + context.spacing_mm) / f.width_mm.0)
}

/// How far the centre of mass lies inside the footprint, if that is too little.
fn topple(part: &Part, process: &Process, context: &Context) -> Option<Finding> {
    let limits = limits_of(process, "tall-feature.topple")?;
    let centre = centre_of_mass(part)?;
    let footprint = Hull::of(section_points(part.mesh(), 0.5 * process.layer_height_mm));
    let depth = footprint.depth([centre[0], centre[1]]);
    if !depth.is_finite() {
        return None;
    }
    // The section moves by what half a layer and a coordinate step move it; what is within them is on the edge.
    let mut f = Finding::judged(META.code, "topple", Bracket::exact(depth), Basis::Exact, limits, "mm", part.tie());
    if f.state == State::Pass {
        return None;
    }
    locate(&mut f, part, context, centre, ([0.0; 3], part.extent()));
    f.witness = Some(Witness { kind: "centre-of-mass".into(), points_mm: vec![reported(part, centre)] });
    let least = limits.warn.or(limits.fail).unwrap_or(0.0);
    f.message = if depth < 0.0 {
        format!("the centre of mass lies {} mm outside the footprint: the part topples", short(round(-depth)))
    } else {
        format!("the centre of mass lies only {} mm inside the footprint", short(round(depth)))
    };
    let volume = part.mesh().signed_volume();
    f.fix = match broader_foot(&footprint, centre, volume, process.layer_height_mm, least + SPARE) {
        Some((wider, inside)) => format!(
            "widen its foot by {} mm on that side: with a foot of one layer, measured again, the centre of mass lies {} mm inside",
            short((100.0 * wider).ceil() / 100.0),
            short((100.0 * inside).floor() / 100.0)
        ),
        None => "give it a broader foot, or lay it down".into(),
    };
    Some(f)
}

/// How far a foot has to reach beyond the footprint, and how deep inside it the centre of mass lies then: a foot of one layer under
/// all within some distance of the centre of mass, whose own mass is counted.
fn broader_foot(footprint: &Hull, centre: Vec3, volume: f64, layer: f64, least: f64) -> Option<(f64, f64)> {
    let corners = || footprint.corners().iter().copied();
    let (area, middle) = centroid(footprint);
    let short_of = -footprint.depth([centre[0], centre[1]]);
    let mut reach = least;
    for _ in 0..FEET {
        // Corners of a polygon about the circle, so that the circle lies within it.
        let out = reach / (std::f64::consts::PI / SIDES as f64).cos();
        let round = (0..SIDES).map(|n| {
            let (s, c) = (std::f64::consts::TAU * n as f64 / SIDES as f64).sin_cos();
            [centre[0] + out * c, centre[1] + out * s]
        });
        let broader = Hull::of(corners().chain(round));
        let (whole, of_whole) = centroid(&broader);
        let moved = [0, 1].map(|a| {
            let moment = volume * centre[a] + layer * (whole * of_whole[a] - area * middle[a]);
            moment / (volume + layer * (whole - area))
        });
        let inside = broader.depth(moved);
        if inside >= least {
            return Some((short_of + out, inside));
        }
        reach += 1.1 * (least - inside);
    }
    None
}

/// Area and centre of a hull.
fn centroid(hull: &Hull) -> (f64, [f64; 2]) {
    let corners = hull.corners();
    let Some(&[x0, y0]) = corners.first() else { return (0.0, [0.0; 2]) };
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for w in corners.windows(2) {
        let twice = (w[0][0] - x0) * (w[1][1] - y0) - (w[1][0] - x0) * (w[0][1] - y0);
        area += 0.5 * twice;
        (0..2).for_each(|a| moment[a] += twice / 6.0 * (corners[0][a] + w[0][a] + w[1][a]));
    }
    (area, if area > 0.0 { moment.map(|m| m / area) } else { [x0, y0] })
}

/// ∫ x dV / V of a sound part; `None` where the mesh does not say what is inside.
fn centre_of_mass(part: &Part) -> Option<Vec3> {
    if !part.is_plain() {
        return None;
    }
    let mesh = part.mesh();
    let (mut volume, mut moment) = (0.0, [0.0; 3]);
    for f in (0..mesh.triangles.len()).filter(|&f| part.bounds_solid(f)) {
        let [a, b, c] = mesh.corners(f);
        let v = crate::geometry::vector::dot(a, crate::geometry::vector::cross(b, c)) / 6.0;
        volume += v;
        (0..3).for_each(|x| moment[x] += 0.25 * v * (a[x] + b[x] + c[x]));
    }
    (volume > 0.0).then(|| moment.map(|m| m / volume))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foot_carries_the_centre_of_mass_and_its_own_mass_is_counted() {
        let square = Hull::of([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]);
        let (area, middle) = centroid(&square);
        assert!(area == 100.0 && middle.iter().all(|c| (c - 5.0).abs() < 1e-12), "{area} {middle:?}");
        // Three millimetres outside on +x: five have to be added to be two inside, and a little more for the foot's own mass.
        let (wider, inside) = broader_foot(&square, [13.0, 5.0, 20.0], 1000.0, 0.2, 2.0).expect("a foot");
        assert!(inside >= 2.0 && (5.0..5.2).contains(&wider), "{wider} {inside}");
        let heavy = broader_foot(&square, [13.0, 5.0, 20.0], 10.0, 1.0, 2.0).expect("a foot");
        assert!(heavy.1 >= 2.0, "{heavy:?}");
    }
}
