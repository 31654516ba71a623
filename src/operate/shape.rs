//! The operations on a part and an element.

use super::element::{Element, wound_outwards};
use super::flush::laid_into;
use super::midway::surface_between;
use super::operated::Operated;
use super::settled::{Settled, Touch};
use super::twice::{closed, opened};
use super::whole::Whole;
use crate::error::{Error, Result};
use crate::field::Indicator;
use crate::geometry::{Primitive, TriangleMesh};
use crate::grid::Grid;
use crate::morphology::{
    Contact, NEAR_PART, Sandwich, Shaped, Sides, close_by_ball, offset as offset_mesh, open_by_ball,
    sweep as sweep_mesh, sweep_surface,
};
use crate::units::{Length, Volume, enclosed, short};

/// The offset of a part by a signed length: coat, shrink, machining stock.
///
/// # Errors
/// [`Error::Operand`] for a length that is not finite or out of proportion to the spacing; [`Error::NoGeometry`] for an
/// empty part, or where nothing remains; [`Error::NotSolid`] for one that is wound inside out; otherwise as
/// [`crate::geometry::voxelize()`].
pub fn offset(part: &TriangleMesh, by: Length, spacing: Length) -> Result<Operated> {
    grown("offset", part, by, spacing)
}

/// The offset of a part as the result of an operation. Two spacings and more outside of a part its facets inside are never the nearest.
fn grown(operation: &'static str, part: &TriangleMesh, by: Length, spacing: Length) -> Result<Operated> {
    let contact = Contact { ball: by, shift: by };
    if by.as_mm() >= NEAR_PART * spacing.as_mm() {
        wound_outwards(part)?;
        return checked(operation, from_distances(offset_mesh(part, by, spacing)?)).map(|made| made.touching(contact));
    }
    by_distances(operation, part, |part| offset_mesh(part, by, spacing)).map(|made| made.touching(contact))
}

/// What is made by the distances to the facets of a part, or to those of its union where its bodies meet.
fn by_distances(
    operation: &'static str,
    part: &TriangleMesh,
    make: impl Fn(&TriangleMesh) -> Result<Shaped>,
) -> Result<Operated> {
    wound_outwards(part)?;
    let (whole, made) = Whole::made(part, make)?;
    let made = from_distances(made);
    checked(operation, Operated { path: whole.path(made.path), ..made })
}

/// The opening of a part: what copies of the element that fit inside cover.
///
/// By a ball the surface is exact; by another element it is where the operands touch, as that of [`minkowski`] once more, or, where a wall is about as
/// thick as the element, midway in the bracket and in the part's own surface where it is about there, and the path says so.
///
/// # Errors
/// As [`offset`]; [`Error::NoGeometry`], too, for an element larger than the part.
pub fn open(part: &TriangleMesh, element: &Element, spacing: Length) -> Result<Operated> {
    element_fits("opening", part, element)?;
    let element = &element.in_place();
    match element {
        Element::BuiltIn(Primitive::Ball { radius }) => {
            let contact = Contact { ball: -*radius, shift: Length::default() };
            by_distances("opening", part, |part| open_by_ball(part, *radius, spacing))
                .map(|made| made.touching(contact))
        }
        _ => {
            let whole = Whole::of(part);
            let [a, b] = both_sides(&whole.mesh, element, spacing)?;
            let found = Sandwich::opening(&a, &b)?;
            let settled = opened(&whole, &element.faceted(spacing)?, [&a, &b], &found)?;
            let made = touching(found, settled)?;
            let made = checked("opening", Operated { path: whole.path(made.path), ..made })?;
            checked("opening", laid_into(&whole, made)?)
        }
    }
}

/// The closing of a part: what the element, moved about outside, cannot reach. Its surface is as exact as that of [`open`], whatever its
/// walls.
///
/// # Errors
/// As [`offset`].
pub fn close(part: &TriangleMesh, element: &Element, spacing: Length) -> Result<Operated> {
    let element = &element.in_place();
    match element {
        Element::BuiltIn(Primitive::Ball { radius }) => {
            wound_outwards(part)?;
            let contact = Contact { ball: *radius, shift: Length::default() };
            checked("closing", from_distances(close_by_ball(part, *radius, spacing)?))
                .map(|made| made.touching(contact))
        }
        _ => {
            let [a, b] = both_sides(part, element, spacing)?;
            let found = Sandwich::closing(&a, &b)?;
            let closed = closed(part, &element.faceted(spacing)?, [&a, &b], &found)?;
            let (settled, filled) = closed.map(|c| (c.settled, c.filled)).unzip();
            checked("closing", Operated { filled: filled.flatten(), ..touching(found, settled)? })
        }
    }
}

/// The Minkowski sum of a part and an element.
///
/// Its vertices lie where the operands touch, to a thousandth of the spacing on the lattice, with curved faces of a built-in element
/// inscribed by a hundredth of it; vertices on creases are less exact. What is thinner than two spacings may be left out. Operands
/// whose facets bound more or less than solids get a surface midway in the bracket, and the path says so.
///
/// # Errors
/// As [`offset`].
pub fn minkowski(part: &TriangleMesh, element: &Element, spacing: Length) -> Result<Operated> {
    if let Element::BuiltIn(Primitive::Ball { radius }) = element {
        return grown("Minkowski sum", part, *radius, spacing);
    }
    let [a, b] = both_sides(part, element, spacing)?;
    let found = Sandwich::sum(&a, &b)?;
    let touch = Touch::of_sum(part, &element.faceted(spacing)?);
    let settled = between(touch, &found)?;
    checked("Minkowski sum", touching(found, settled)?)
}

/// The Minkowski difference (erosion) of a part by an element: where the element's origin may stand so that all of it
/// lies in the part. Its surface is as exact as that of [`minkowski`]; a part that meets itself and has no union gets one midway in the
/// bracket.
///
/// # Errors
/// As [`open`]; [`Error::NoGeometry`], too, where no sample is certainly in it: it may have no volume.
pub fn difference(part: &TriangleMesh, element: &Element, spacing: Length) -> Result<Operated> {
    element_fits("Minkowski difference", part, element)?;
    if let Element::BuiltIn(Primitive::Ball { radius }) = element {
        return grown("Minkowski difference", part, -*radius, spacing);
    }
    let whole = Whole::of(part);
    let [a, b] = both_sides(&whole.mesh, element, spacing)?;
    let found = Sandwich::difference(&a, &b)?;
    let touch = Touch::of_difference(&whole, &element.faceted(spacing)?);
    let settled = between(touch, &found)?;
    let made = touching(found, settled)?;
    checked("Minkowski difference", Operated { path: whole.path(made.path), ..made })
}

/// The obstacle of a part for a moving element: the translations at which the two overlap. Its surface is as exact as that of
/// [`minkowski`].
///
/// # Errors
/// As [`offset`].
pub fn obstacle(part: &TriangleMesh, element: &Element, spacing: Length) -> Result<Operated> {
    if let Element::BuiltIn(Primitive::Ball { radius }) = element {
        return grown("obstacle", part, *radius, spacing);
    }
    let [a, b] = both_sides(part, element, spacing)?;
    let found = Sandwich::obstacle(&a, &b)?;
    let touch = Touch::of_obstacle(part, &element.faceted(spacing)?);
    let settled = between(touch, &found)?;
    checked("obstacle", touching(found, settled)?)
}

/// What an element covers along a polyline of translations: by exact distances, or where the path has too many pieces for
/// that by its samples.
///
/// # Errors
/// [`Error::Operand`] for a path of fewer than two points or without length; otherwise as [`offset`].
pub fn sweep(element: &Element, path_mm: &[[f64; 3]], spacing: Length) -> Result<Operated> {
    let mesh = element.faceted(spacing)?;
    let Sides { full, points, touched } = sweep_mesh(&mesh, path_mm, spacing, [0.25; 3])?;
    let bracket = [full.volume(), touched.volume()];
    let made = match sweep_surface(&mesh, path_mm, spacing)? {
        Some(surface) => {
            // Inside, distances to the solids of the pieces are none to what they make together.
            let (grid, values) = (*surface.field.grid(), surface.field.values());
            let inside = Indicator::from_predicate(grid, |at| values[at] <= 0.0);
            let made = from_distances(surface);
            let [low, high] = made.bracket;
            let bracket = [low.max(bracket[0]), high.min(bracket[1])];
            Operated { bracket, distances: None, inside: Some(inside), ..made }
        }
        None => {
            let same = Sandwich { lower: points.clone(), upper: points, volume: bracket, paths: Vec::new() };
            Operated { path: "solids of the path's pieces, sample by sample".into(), ..from_sandwich(same)? }
        }
    };
    checked("sweep", made)
}

/// What a tool sweeps within a window wherever it may go without meeting a part: see [`Sandwich::reachable`].
///
/// # Errors
/// As there.
pub fn reachable(part: &Sides, tool: &Sides, window: &Grid) -> Result<Operated> {
    checked("reach", from_sandwich(Sandwich::reachable(part, tool, window)?)?)
}

/// Where samples lie beside the world's origin, in spacings, so that faces on round coordinates are not on samples.
const PHASE: [f64; 3] = [0.25; 3];

fn both_sides(part: &TriangleMesh, element: &Element, spacing: Length) -> Result<[Sides; 2]> {
    wound_outwards(part)?;
    let of_element = match element {
        Element::Mesh(mesh) => {
            wound_outwards(mesh)?;
            Sides::with_sample(mesh, spacing, PHASE)?
        }
        Element::BuiltIn(shape @ Primitive::Box { .. }) => Sides::with_sample(&shape.mesh(spacing), spacing, PHASE)?,
        Element::BuiltIn(shape) => {
            let sides = Sides::of_primitive(shape, spacing, PHASE)?;
            // The origin is the middle of every built-in shape.
            if sides.points.is_empty() { Sides::of_primitive(shape, spacing, [0.0; 3])? } else { sides }
        }
    };
    Ok([Sides::with_sample(part, spacing, PHASE)?, of_element])
}

fn element_fits(operation: &'static str, part: &TriangleMesh, element: &Element) -> Result<()> {
    let extent = |mesh: &TriangleMesh| mesh.bounds().map(|(lo, hi)| [0, 1, 2].map(|a| hi[a] - lo[a]));
    let of_element = match element {
        Element::Mesh(mesh) => extent(mesh),
        Element::BuiltIn(shape) => {
            shape.validate()?;
            Some(shape.half_extent().map(|x| 2.0 * x))
        }
    };
    let (Some(part), Some(element)) = (extent(part), of_element) else { return Ok(()) };
    match (0..3).find(|&a| element[a] > part[a] * (1.0 + 1e-9)) {
        None => Ok(()),
        Some(axis) => Err(Error::NoGeometry {
            problem: format!(
                "nothing remains after the {operation}: the element is longer in {} than the part, {} mm to {} mm: it fits nowhere",
                ["x", "y", "z"][axis],
                short(element[axis]),
                short(part[axis])
            ),
            remedy: "choose a smaller element, or check the units".into(),
        }),
    }
}

fn from_distances(shape: Shaped) -> Operated {
    let volume = Volume::mm3(shape.mesh.signed_volume());
    let path = "exact distances".into();
    Operated {
        mesh: shape.mesh,
        volume,
        bracket: shape.volume,
        path,
        distances: Some(shape.field),
        inside: None,
        sides: None,
        filled: None,
        contact: None,
    }
}

/// The surface between the sides of a sandwich, if the operands have a touch.
fn between(touch: Option<Touch>, found: &Sandwich) -> Result<Option<Settled>> {
    touch.map_or(Ok(None), |touch| touch.surface(found.sides()))
}

/// With the surface where the operands touch, or midway between the two sets if there is none.
fn touching(found: Sandwich, settled: Option<Settled>) -> Result<Operated> {
    let Some(Settled { mesh, inside, touching, crossings }) = settled else {
        let made = from_sandwich(found)?;
        return Ok(Operated { path: format!("{}, surface midway in the bracket", made.path), ..made });
    };
    let path = format!("{}, {touching} of {crossings} crossings where the operands touch", paths_of(&found));
    Ok(with_surface(found, mesh, inside, path))
}

/// With the surface of the exact result, and the samples in it.
pub(super) fn with_surface(found: Sandwich, mesh: TriangleMesh, inside: Indicator, path: String) -> Operated {
    let volume = Volume::mm3(mesh.signed_volume());
    let sides = Some([found.lower, found.upper]);
    Operated {
        mesh,
        volume,
        bracket: found.volume,
        path,
        distances: None,
        inside: Some(inside),
        sides,
        filled: None,
        contact: None,
    }
}

fn paths_of(found: &Sandwich) -> String {
    found.paths.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// The surface midway between the two sets: the mean of their signed distances vanishes there.
pub(super) fn from_sandwich(found: Sandwich) -> Result<Operated> {
    let path = paths_of(&found);
    let mesh = surface_between(&found.lower, &found.upper)?;
    let volume = Volume::mm3(mesh.signed_volume());
    let sides = Some([found.lower, found.upper]);
    Ok(Operated {
        mesh,
        volume,
        bracket: found.volume,
        path,
        distances: None,
        inside: None,
        sides,
        filled: None,
        contact: None,
    })
}

/// Lets a result pass only if it agrees with its own bracket.
pub(super) fn checked(operation: &'static str, result: Operated) -> Result<Operated> {
    let [low, high] = result.bracket.map(|v| v.as_mm3());
    if low.is_nan() || high.is_nan() || low > high {
        return Err(Error::Internal { problem: format!("{operation}: the bracket {low} … {high} mm³ is empty") });
    }
    let [_, _, most] = enclosed(high, [low, high]);
    if result.mesh.triangles.is_empty() {
        if low > 0.0 {
            return Err(Error::Internal { problem: format!("{operation}: a surface of at least {low} mm³ was lost") });
        }
        let (problem, remedy) = if high > 0.0 {
            let problem = format!("nothing of the {operation} shows at this spacing; at most {most} mm³ could remain");
            (problem, "choose a smaller spacing or a smaller element")
        } else {
            (format!("nothing remains after the {operation}"), "choose a smaller element or distance")
        };
        return Err(Error::NoGeometry { problem, remedy: remedy.into() });
    }
    // Chords are inscribed: the surface may be smaller than the body by what the spacing cannot show.
    let volume = result.volume.as_mm3();
    let slack = 1e-3 * high.max(1e-9);
    let midway = result.distances.is_none() && result.inside.is_none();
    let nothing_certain = result.sides.as_ref().is_some_and(|[lower, _]| lower.is_empty());
    if low == 0.0 && (volume > high + slack || midway && nothing_certain) {
        return Err(Error::NoGeometry {
            problem: format!("nothing of the {operation} is certain at this spacing; at most {most} mm³ could remain"),
            remedy: "choose a smaller spacing or a smaller element".into(),
        });
    }
    if !(volume.is_finite() && low - slack <= volume && volume <= high + slack) {
        return Err(Error::Internal {
            problem: format!("{operation}: the surface holds {volume} mm³, certified are {low} … {high} mm³"),
        });
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::Vec3;
    use crate::geometry::{cuboid, extruded};

    fn mesh(text: &str) -> TriangleMesh {
        Primitive::parse(text).unwrap().mesh(Length::mm(0.01))
    }

    fn built_in(text: &str) -> Element {
        Element::BuiltIn(Primitive::parse(text).unwrap())
    }

    const H: Length = Length::mm(0.25);

    #[test]
    fn operands_that_are_wound_inside_out_are_refused_with_the_remedy() {
        let (part, thin) = (cuboid([0.0; 3], [5.0; 3]), cuboid([0.0; 3], [1.0, 1.0, 1.5]));
        let (inverted, ball, block) = (part.flipped(), built_in("ball:1mm"), built_in("box:1mm"));
        let turned = Element::Mesh(thin.flipped());
        let path = [[0.0; 3], [3.0, 0.0, 0.0]];
        let by = |mm: f64| Length::mm(mm);
        let refused = [
            offset(&inverted, by(0.1), H),
            offset(&inverted, by(1.0), H),
            offset(&inverted, by(-1.0), H),
            minkowski(&inverted, &block, H),
            minkowski(&inverted, &ball, H),
            difference(&inverted, &block, H),
            difference(&inverted, &ball, H),
            obstacle(&inverted, &block, H),
            open(&inverted, &ball, H),
            open(&inverted, &block, H),
            close(&inverted, &ball, H),
            close(&inverted, &block, H),
            minkowski(&part, &turned, H),
            difference(&part, &turned, H),
            obstacle(&part, &turned, H),
            open(&part, &turned, H),
            close(&part, &turned, H),
            sweep(&turned, &path, H),
        ];
        for (at, refused) in refused.into_iter().enumerate() {
            let Err(error @ Error::NotSolid { .. }) = refused else { panic!("{at}: {refused:?}") };
            assert!(error.remedy().contains("flipped()"), "{at}: {error}");
        }
        assert!(offset(&inverted.flipped(), by(0.1), H).unwrap().volume.as_mm3() > 139.0);
    }

    #[test]
    fn the_field_of_a_sweep_is_a_distance_inside_too() {
        // Two legs of a box of 2 mm, which make one of 6 × 2 × 2 mm.
        let path = [[0.0; 3], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
        let made = sweep(&built_in("box:2x2x2mm"), &path, H).unwrap();
        let field = made.field().unwrap();
        let whole = Primitive::parse("box:6x2x2mm").unwrap();
        let grid = *field.grid();
        let off = (0..grid.samples()).map(|at| {
            let [x, y, z] = grid.position(grid.index(at));
            (f64::from(field.values()[at]) - whole.signed_distance([x - 2.0, y, z])).abs()
        });
        let worst = off.fold(0.0, f64::max);
        assert!(worst < H.as_mm(), "{worst}");
    }

    #[test]
    fn an_opening_by_a_mesh_does_not_depend_on_where_the_mesh_lies() {
        let outline = [[0.0, 0.0], [12.0, 0.0], [12.0, 4.0], [3.0, 4.0], [3.0, 9.0], [0.0, 9.0]];
        let part = extruded(&outline, &[[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]], 5.0);
        let [o, x, y, z] = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 3.0]];
        let tetrahedron = TriangleMesh::weld([[o, y, x], [o, x, z], [x, y, z], [o, z, y]]);
        let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let opened =
            |by: Vec3| open(&part, &Element::Mesh(tetrahedron.transformed(still, by)), Length::mm(0.3)).unwrap();
        let first = opened([0.0; 3]);
        assert!(first.path.contains("where the operands touch"), "{}", first.path);
        for by in [[0.5; 3], [-7.25, 0.125, 3.0], [0.07, 0.19, -0.11]] {
            let other = opened(by);
            assert!((other.volume.as_mm3() - first.volume.as_mm3()).abs() < 1e-6, "{by:?}: {:?}", other.volume);
            assert_eq!(other.path, first.path, "{by:?}");
        }
    }

    #[test]
    fn boxes_have_known_sums_differences_openings_and_closings() {
        let (part, element) = (mesh("box:6x5x4mm"), built_in("box:2x1x1mm"));
        let results = [
            (minkowski(&part, &element, H).unwrap(), 8.0 * 6.0 * 5.0),
            (obstacle(&part, &element, H).unwrap(), 8.0 * 6.0 * 5.0),
            (difference(&part, &element, H).unwrap(), 4.0 * 4.0 * 3.0),
            (open(&part, &element, H).unwrap(), 6.0 * 5.0 * 4.0),
            (close(&part, &element, H).unwrap(), 6.0 * 5.0 * 4.0),
            (sweep(&element, &[[0.0; 3], [3.0, 0.0, 0.0]], H).unwrap(), 5.0),
        ];
        for (at, (found, volume)) in results.iter().enumerate() {
            let [low, high] = found.bracket.map(|v| v.as_mm3());
            assert!(low <= *volume && *volume <= high, "{at}: {volume} not in {low} … {high}");
            // The estimate is better than a spacing over the surface, here at most 236 mm².
            let area = found.mesh.area();
            assert!((found.volume.as_mm3() - volume).abs() < 0.6 * 0.25 * area, "{at}: {:?} {volume}", found.volume);
            assert!(!found.path.is_empty());
        }
    }

    #[test]
    fn the_path_says_where_the_surface_lies() {
        let (part, element) = (mesh("box:6x5x4mm"), built_in("box:2x1x1mm"));
        assert!(difference(&part, &element, H).unwrap().path.ends_with(" crossings where the operands touch"));
        let both = part.clone().joined(&mesh("box:8x2x2mm"));
        assert!(difference(&both, &element, H).unwrap().path.ends_with(" touch, what meets itself united first"));
    }

    #[test]
    fn bodies_that_meet_are_eroded_as_their_union() {
        // A bar of 10 × 4 × 4 mm of two that overlap, and of two that touch.
        for at in [4.0, 5.0] {
            let part = cuboid([0.0; 3], [5.0, 4.0, 4.0]).joined(&cuboid([at, 0.0, 0.0], [10.0, 4.0, 4.0]));
            let by = built_in("box:1x1x1mm");
            let (less, ball) = (difference(&part, &by, H).unwrap(), built_in("ball:0.5mm"));
            let same = [
                open(&part, &by, H).unwrap(),
                open(&part, &ball, H).unwrap(),
                offset(&part, Length::mm(0.0), H).unwrap(),
            ];
            // Faces lie where the operands touch, to a thousandth of a spacing; edges are off by a third of it.
            assert!(
                (less.volume.as_mm3() - 81.0).abs() < 126.0 * 1e-3 * 0.25 + 84.0 * 0.08 * 0.08,
                "{at}: {:?}",
                less.volume
            );
            for (n, made) in same.iter().enumerate() {
                let [low, high] = made.bracket.map(|v| v.as_mm3());
                let whole = if n == 1 { 160.0 - 72.0 * 0.25 * (1.0 - 0.25 * std::f64::consts::PI) } else { 160.0 };
                assert!(low <= whole && whole <= high, "{at} {n}: {whole} not in {low} … {high}");
            }
            let [plain, grown] = [&same[2], &offset(&cuboid([0.0; 3], [10.0, 4.0, 4.0]), Length::mm(0.0), H).unwrap()];
            assert!(
                (plain.mesh.area() - 192.0).abs() < 1e-3 * 192.0 && (grown.mesh.area() - 192.0).abs() < 1e-3 * 192.0
            );
            assert!(plain.path.ends_with("united first") && !grown.path.contains("united"));
            assert!(offset(&part, Length::mm(-0.5), H).unwrap().bracket[1].as_mm3() >= 81.0);
        }
    }

    #[test]
    fn an_element_may_be_thinner_than_any_spacing() {
        let part = mesh("box:6x5x4mm");
        let plate = |x: f64, y: f64, z: f64| Element::Mesh(cuboid([0.0; 3], [x, y, z]));
        // Faces along the lattice are exact to a thousandth of a spacing, edges to a third of it.
        let close = |found: Result<Operated>, volume: f64| {
            let found = found.unwrap();
            let [low, high] = found.bracket.map(|v| v.as_mm3());
            assert!(0.0 < low && low <= volume && volume <= high, "{volume} not in {low} … {high}");
            let off = found.volume.as_mm3() - volume;
            assert!(off.abs() < 190.0 * 1e-3 * 0.25 + 68.0 * (0.3f64 * 0.25).powi(2), "{off} off {volume}");
        };
        close(minkowski(&part, &plate(1.0, 1.0, 1e-3), H), 7.0 * 6.0 * 4.001);
        close(minkowski(&part, &plate(1e-3, 1e-3, 2.0), H), 6.001 * 5.001 * 6.0);
        close(minkowski(&cuboid([0.0; 3], [1.0, 1.0, 1e-3]), &plate(6.0, 5.0, 4.0), H), 7.0 * 6.0 * 4.001);
        close(difference(&part, &plate(1.0, 1.0, 1e-3), H), 5.0 * 4.0 * 3.999);
        close(open(&part, &plate(1.0, 1.0, 1e-3), H), 120.0);
        close(super::close(&part, &plate(1.0, 1.0, 1e-3), H), 120.0);
        let disc = minkowski(&part, &built_in("cylinder:r1h0.001mm"), H);
        close(disc, 4.001 * (30.0 + 22.0 + std::f64::consts::PI));
    }

    #[test]
    fn a_difference_without_volume_is_no_shape() {
        let part = mesh("box:6x5x4mm");
        for element in ["box:6x5x4mm", "box:6x1x1mm", "box:5.97x1x1mm"] {
            let found = difference(&part, &built_in(element), H);
            assert!(
                matches!(found, Err(Error::NoGeometry { problem, .. }) if problem.contains("is certain")),
                "{element}"
            );
        }
        // At a spacing that shows 0.03 mm there is one.
        let found = difference(&mesh("box:1x0.5x0.5mm"), &built_in("box:0.97x0.1x0.1mm"), Length::mm(0.005)).unwrap();
        assert!((found.volume.as_mm3() - 0.03 * 0.4 * 0.4).abs() < 1e-5, "{}", found.volume);
    }

    #[test]
    fn balls_take_the_exact_way() {
        let found = minkowski(&mesh("ball:3mm"), &built_in("ball:1mm"), H).unwrap();
        assert_eq!(found.path, "exact distances");
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 64.0;
        assert!((found.volume.as_mm3() / volume - 1.0).abs() < 0.01, "{:?}", found.volume);
    }

    #[test]
    fn what_cannot_be_answered_is_an_error_of_its_own() {
        let part = mesh("box:6x5x4mm");
        let empty = TriangleMesh::default();
        assert!(matches!(minkowski(&empty, &built_in("box:1x1x1mm"), H), Err(Error::NoGeometry { .. })));
        assert!(matches!(minkowski(&part, &Element::Mesh(empty.clone()), H), Err(Error::NoGeometry { .. })));
        assert!(matches!(difference(&part, &built_in("box:1x1x5mm"), H), Err(Error::NoGeometry { .. })));
        assert!(matches!(open(&part, &built_in("ball:9mm"), H), Err(Error::NoGeometry { .. })));
        assert!(matches!(offset(&part, Length::mm(-3.0), H), Err(Error::NoGeometry { .. })));
        assert!(matches!(offset(&part, Length::mm(f64::NAN), H), Err(Error::Operand { .. })));
        assert!(matches!(sweep(&built_in("ball:1mm"), &[[0.0; 3]], H), Err(Error::Operand { .. })));
        assert!(matches!(offset(&empty, Length::mm(1.0), H), Err(Error::NoGeometry { .. })));
        // Of slats as thick as a sample nothing is certain.
        let slats = [0.0, 1.1, 2.2, 3.3].map(|z| cuboid([0.0, 0.0, z], [9.0, 8.0, z + 0.6]));
        let slats = slats.into_iter().reduce(|all, slat| all.joined(&slat)).unwrap();
        let found = open(&slats, &built_in("box:1.5x1x0.5mm"), Length::mm(0.6));
        assert!(matches!(found, Err(Error::NoGeometry { problem, .. }) if problem.contains("is certain")));
    }
}
