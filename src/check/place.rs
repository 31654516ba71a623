//! Where a finding is, in the frame of the file, and a name for it that survives small edits.

use super::contract::Context;
use super::finding::{Finding, Spot};
use crate::geometry::vector::{Vec3, bounds, corners_of};
use crate::part::Part;
use crate::units::report_digits;
use rustc_hash::FxHashMap;

/// A point of the build's frame as the report gives it: in the frame of the file, at the report's resolution.
pub fn reported(part: &Part, p: Vec3) -> Vec3 {
    part.to_file(p).map(report_digits)
}

/// The box of an extent in the frame of the build as the report gives it: in the frame of the input file.
pub fn reported_box(part: &Part, extent: (Vec3, Vec3)) -> [Vec3; 2] {
    let corners = corners_of(extent).map(|p| reported(part, p));
    bounds(corners).map_or([corners[0]; 2], |(lo, hi)| [lo, hi])
}

/// Puts a finding at a point with an extent, both in the frame of the build, and names it. Its box holds both, and of the extent what is within the part's box.
///
/// The fingerprint is check, kind, the cell of the file's frame that the middle of the box lies in, and the size class of the box (a power of two of
/// millimetres): the same however the part is stood up and meshed, and whatever is added elsewhere; another where the part is moved in its file. Of an even wall the mesh alone
/// says which point is the worst; its box has one middle.
pub fn locate(finding: &mut Finding, part: &Part, context: &Context, at: Vec3, extent: (Vec3, Vec3)) {
    finding.at_mm = reported(part, at);
    // Balls at a rim reach beyond the part, and nothing of it is there.
    let extent = (part.within_box(extent.0), part.within_box(extent.1));
    let corners = corners_of(extent).map(|p| reported(part, p)).into_iter().chain([finding.at_mm]);
    let (lo, hi) = bounds(corners).unwrap_or((finding.at_mm, finding.at_mm));
    finding.box_mm = [lo, hi];
    finding.fingerprint = format!("{}/{}/{}", finding.code, finding.kind, cell_and_class([lo, hi], context.spacing_mm));
    finding.places =
        vec![Spot { at_mm: finding.at_mm, box_mm: None, value: finding.value, low: finding.low, high: finding.high }];
}

/// Where the cells of fingerprints begin, as a share of their side: what is drawn in whole steps of a millimetre, a half or a tenth has no middle on the
/// border of two.
const CELLS_BEGIN: f64 = 0.37;

/// The cell that the middle of a box lies in, and the size class: `10,20,9/4`.
///
/// A cell is a quarter of the class wide, from a quarter of a millimetre to one, and so the same whatever the rest of the part is like. Only where samples are
/// farther apart than a millimetre, on parts of 256 mm and more, cells are as wide as that, for middles are told no better.
fn cell_and_class([lo, hi]: [Vec3; 2], spacing_mm: f64) -> String {
    let longest = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
    let class = if longest > 0.0 { longest.log2().round() as i32 } else { -99 };
    let coarse = if spacing_mm > 1.0 { spacing_mm.log2().ceil().exp2() } else { 0.0 };
    let cell = f64::from(class - 2).exp2().clamp(0.25, 1.0).max(coarse);
    let [x, y, z] = [0, 1, 2].map(|a| (0.5 * (lo[a] + hi[a]) / cell + CELLS_BEGIN).floor() as i64);
    format!("{x},{y},{z}/{class}")
}

/// Ends the names of findings that stand for several places with their number, and gives those of one check that share a name an ordinal,
/// worst first: an acceptance by name means one of them, and no place that joins it later.
pub fn name_apart(findings: &mut [Finding]) {
    let mut worst: Vec<&mut Finding> = findings.iter_mut().collect();
    worst.sort_by(|a, b| Finding::worst_first(a, b));
    let mut seen: FxHashMap<String, usize> = FxHashMap::default();
    for f in worst.into_iter().filter(|f| !f.fingerprint.is_empty()) {
        if f.count > 1 {
            f.fingerprint.push_str(&format!("/x{}", f.count));
        }
        let times = seen.entry(f.fingerprint.clone()).or_insert(0);
        *times += 1;
        if *times > 1 {
            f.fingerprint.push_str(&format!("/{times}"));
        }
    }
}

/// Joins findings of equal kind, state and value into one with a count; the first of each keeps its place.
///
/// Equal means within `tolerance` of the first of the group.
pub fn group_equal(findings: Vec<Finding>, tolerance: f64) -> Vec<Finding> {
    let mut groups: Vec<Finding> = Vec::new();
    for f in findings {
        let same = |g: &&mut Finding| {
            g.kind == f.kind
                && g.state == f.state
                && (g.value - f.value).abs() <= tolerance
                && g.bodies.is_some() == f.bodies.is_some()
        };
        match groups.iter_mut().find(same) {
            Some(g) => join(g, f),
            None => groups.push(f),
        }
    }
    groups
}

fn join(group: &mut Finding, mut f: Finding) {
    for one in [&mut *group, &mut f] {
        let own = (one.count == 1).then_some(one.box_mm);
        one.places.iter_mut().for_each(|p| p.box_mm = p.box_mm.or(own));
    }
    group.count += f.count;
    group.places.extend(f.places);
    group.low = group.low.min(f.low);
    group.high = group.high.max(f.high);
    group.decided &= f.decided;
    let sum = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => Some(report_digits(a + b)),
        (a, b) => a.or(b),
    };
    group.area_mm2 = sum(group.area_mm2, f.area_mm2);
    group.volume_mm3 = sum(group.volume_mm3, f.volume_mm3);
    for a in 0..3 {
        group.box_mm[0][a] = group.box_mm[0][a].min(f.box_mm[0][a]);
        group.box_mm[1][a] = group.box_mm[1][a].max(f.box_mm[1][a]);
    }
    if let (Some(mine), Some(theirs)) = (&mut group.bodies, f.bodies) {
        mine.extend(theirs);
        mine.sort_unstable();
        mine.dedup();
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::{Basis, Bracket, Limits, Sense};
    use super::*;
    use crate::geometry::cuboid;
    use crate::part::Up;

    /// The name of a wall with a box, told at a point, in a part with something else as far away as `beside`.
    fn named(beside: f64, up: Up, at: Vec3) -> String {
        let wall = cuboid([10.0, 10.0, 3.0], [10.6, 30.0, 15.0]);
        let part = Part::new(wall.joined(&cuboid([beside, 0.0, 0.0], [60.0, 40.0, 3.0])), up, 1e-6, 1.0).unwrap();
        let context = Context { refine: 0, spacing_mm: 0.23 };
        let limits = Limits { fail: Some(1.0), warn: None, sense: Sense::Min };
        let mut f = Finding::judged("AM101", "wall", Bracket::exact(0.6), Basis::Exact, limits, "mm", 0.0);
        let corners = [[10.0, 10.3, 3.1], [10.6, 29.7, 14.7]].map(|p| part.to_build(p));
        locate(&mut f, &part, &context, part.to_build(at), bounds(corners).unwrap());
        f.fingerprint
    }

    #[test]
    fn a_name_knows_neither_the_rest_of_the_part_nor_how_it_stands_nor_which_point_of_an_even_wall_is_the_worst() {
        let first = named(0.0, Up::PlusZ, [10.3, 14.2, 7.5]);
        assert_eq!(named(0.0, Up::PlusX, [10.3, 14.2, 7.5]), first);
        assert_eq!(named(0.0, Up::PlusZ, [10.3, 19.2, 13.5]), first);
        assert_eq!(named(-45.0, Up::MinusZ, [10.3, 14.2, 7.5]), first);
    }

    #[test]
    fn two_findings_of_one_name_are_named_apart_the_worse_first() {
        let of = |value: f64| {
            let limits = Limits { fail: Some(1.0), warn: None, sense: Sense::Min };
            let mut f = Finding::judged("AM101", "wall", Bracket::exact(value), Basis::Exact, limits, "mm", 0.0);
            f.fingerprint = if value < 0.5 { "n".into() } else { "other".into() };
            f
        };
        let mut findings = [of(0.4), of(0.6), of(0.2), of(0.3)];
        name_apart(&mut findings);
        assert_eq!(findings.map(|f| f.fingerprint), ["n/3", "other", "n", "n/2"]);
    }
}
