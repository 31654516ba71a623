//! The exhibit of a part: display mesh, a value at every corner, slices through the worst finding.

use super::exhibit::{Coarsened, Exhibit, Exhibited, Layer, Slice, SurfaceMap, Volume};
use super::schema::Report;
use crate::check::{Limits, MapKind, MapWanted, Sense, ShapeShown};
use crate::field::Field;
use crate::geometry::vector::{Vec3, along, distance, sub};
use crate::geometry::{Coarser, TriangleMesh};
use crate::grid::Grid;
use crate::layer::turned_by;
use crate::medial::map::opposing_distance;
use crate::medial::{Features, Side};
use crate::part::Part;
use rayon::prelude::*;

/// Facets of the display copy at most, before they are split; larger parts show a coarser copy and say so.
const MOST_FACETS: usize = 300_000;
/// Edge of a display facet in samples of a field read on it.
const RESOLVED: f64 = 2.0;
/// Pieces that splitting may make in all.
const MOST_PIECES: usize = 30_000;

/// A map together with the name of the check that wants it.
pub type Wanted = (String, MapWanted);

/// Mounts the exhibit, if there is to be one: facets are split where a map varies inside them, and every corner gets its value.
///
/// A facet of a coarser copy shows what is measured on the facet of the part that it was.
///
/// # Cost
/// One search of the opposing surface for each corner of a facet near one; nothing for facets that have none in reach. A tenth of a
/// second for each million facets where there is a coarser copy.
pub fn mount(
    exhibited: Exhibited,
    part: &Part,
    report: &Report,
    (wanted, shapes): (&[Wanted], Vec<ShapeShown>),
) -> Exhibit {
    if exhibited == Exhibited::Nothing {
        return Exhibit::default();
    }
    let coarser = Coarser::of(part.mesh(), MOST_FACETS);
    let pieces = match &coarser {
        Some(copy) => split(part, (&copy.mesh, &copy.facets), wanted),
        None => split(part, (part.mesh(), &(0..part.mesh().triangles.len()).collect::<Vec<_>>()), wanted),
    };
    let corners: Vec<Vec3> = pieces.iter().flat_map(|p| p.corners).collect();
    let ranks = part.distance().tree().ranks(part.mesh().triangles.len());
    let mut in_turn: Vec<u32> = (0..pieces.len() as u32).collect();
    in_turn.par_sort_by_key(|&p| ranks[pieces[p as usize].facet]);
    let maps = wanted.iter().map(|(check, map)| surface_map(part, check, map, (&pieces, &in_turn))).collect();
    Exhibit {
        corners,
        maps,
        slices: slices(part, report),
        coarsened: coarser.map(|copy| coarsened(part, &copy)),
        layers: shapes.into_iter().map(layer).collect(),
        volume: part.solid().ok().and_then(|s| volume(s.density.field())),
        stances: None,
    }
}

fn coarsened(part: &Part, copy: &Coarser) -> Coarsened {
    let facets_left_out = part.mesh().triangles.len() - copy.facets.len();
    Coarsened { facets_left_out, within_mm: copy.moved_mm }
}

fn layer(shape: ShapeShown) -> Layer {
    let mesh = shape.mesh;
    let corners = (0..mesh.triangles.len()).flat_map(|f| mesh.corners(f)).collect();
    Layer { name: shape.name.into(), title: shape.title, corners }
}

/// A piece of a facet.
struct Piece {
    /// Where it is drawn.
    corners: [Vec3; 3],
    /// Where its values are read, on the part's own facet; elsewhere in a coarser copy only.
    read: [Vec3; 3],
    facet: usize,
}

/// What a map shows on a whole facet.
enum Shown {
    Constant(f64),
    Varies,
}

fn shown(part: &Part, map: &MapWanted, facet: usize) -> Shown {
    match (map.kind, &map.field) {
        (MapKind::Slope, _) => return Shown::Constant(slope(part, facet)),
        (MapKind::Sampled, Some(_)) => return Shown::Varies,
        (MapKind::Sampled, None) => return Shown::Constant(f64::NAN),
        (MapKind::Wall | MapKind::Gap | MapKind::Ray, _) => {}
    }
    if !part.bounds_solid(facet) {
        return Shown::Constant(f64::NAN);
    }
    if map.kind == MapKind::Ray {
        return Shown::Varies;
    }
    match map.facets.get(facet) {
        Some(known) if known.low < map.open_end => {
            known.constant(part.mesh().facet_area(facet)).map_or(Shown::Varies, Shown::Constant)
        }
        _ => Shown::Constant(map.open_end),
    }
}

/// Splits facets on which a map varies until no edge is longer than the reach. Facets are drawn as `drawn` has them, and `facets` are
/// their numbers in the part.
fn split(part: &Part, (drawn, facets): (&TriangleMesh, &[usize]), wanted: &[Wanted]) -> Vec<Piece> {
    let varies = |&f: &usize| wanted.iter().any(|(_, m)| matches!(shown(part, m, f), Shown::Varies));
    let near: Vec<bool> = facets.iter().map(varies).collect();
    let resolution = |m: &MapWanted| match &m.field {
        Some(field) => RESOLVED * field.grid().h(),
        None if side_of(m.kind).is_some() => m.open_end,
        None => 0.0,
    };
    let reach = wanted.iter().map(|(_, m)| resolution(m)).fold(0.0, f64::max);
    let area: f64 = (0..facets.len()).zip(&near).filter(|(_, n)| **n).map(|(f, _)| drawn.facet_area(f)).sum();
    let edge = reach.max((4.0 * area / MOST_PIECES as f64).sqrt());
    let mut pieces = Vec::with_capacity(facets.len());
    for (at, (&facet, &varies)) in facets.iter().zip(&near).enumerate() {
        let mut stack = vec![Piece { corners: drawn.corners(at), read: part.mesh().corners(facet), facet }];
        while let Some(piece) = stack.pop() {
            let full = pieces.len() + stack.len() > facets.len() + MOST_PIECES;
            match halved(&piece, edge) {
                Some(halves) if varies && !full => stack.extend(halves),
                _ => pieces.push(piece),
            }
        }
    }
    pieces
}

/// Both halves of a piece, cut across its longest edge, where that is longer than `edge`.
fn halved(piece: &Piece, edge: f64) -> Option<[Piece; 2]> {
    let [a, b, c] = piece.corners;
    let (ab, bc, ca) = (distance(a, b), distance(b, c), distance(c, a));
    let longest = ab.max(bc).max(ca);
    if longest <= edge {
        return None;
    }
    let first = if longest == ab {
        0
    } else if longest == bc {
        1
    } else {
        2
    };
    let cut = |mut corners: [Vec3; 3]| {
        corners.rotate_left(first);
        let [p, q, r] = corners;
        let m = along(p, sub(q, p), 0.5);
        [[m, q, r], [p, m, r]]
    };
    let ([c0, c1], [r0, r1]) = (cut(piece.corners), cut(piece.read));
    let half = |corners, read| Piece { corners, read, facet: piece.facet };
    Some([half(c0, r0), half(c1, r1)])
}

fn side_of(kind: MapKind) -> Option<Side> {
    match kind {
        MapKind::Wall => Some(Side::Material),
        MapKind::Gap => Some(Side::Void),
        MapKind::Slope | MapKind::Sampled | MapKind::Ray => None,
    }
}

fn surface_map(part: &Part, check: &str, map: &MapWanted, (pieces, in_turn): (&[Piece], &[u32])) -> SurfaceMap {
    let features = side_of(map.kind).map(|side| part.features(side));
    let found: Vec<[f32; 3]> = in_turn
        .par_iter()
        .with_max_len(1024)
        .map_init(|| None, |near, &p| values_on(part, map, (features, near), &pieces[p as usize]))
        .collect();
    let mut values = vec![[f32::NAN; 3]; pieces.len()];
    in_turn.iter().zip(found).for_each(|(&p, found)| {
        let tie = tie(part, map.kind, pieces[p as usize].facet);
        values[p as usize] = found.map(|v| as_judged(&map.limits, tie, f64::from(v)) as f32);
    });
    SurfaceMap {
        check: check.into(),
        title: map.title.into(),
        unit: map.unit.into(),
        sense: map.limits.sense,
        fail: map.limits.fail,
        warn: map.limits.warn,
        open_end: map.open_end,
        fills: side_of(map.kind),
        values: values.into_iter().flatten().collect(),
    }
}

/// What the verdict on a facet takes for equal, in the unit of the map.
fn tie(part: &Part, kind: MapKind, facet: usize) -> f64 {
    match kind {
        MapKind::Wall | MapKind::Gap => part.tie(),
        MapKind::Slope => turned_by(part.mesh().corners(facet), part.step()).to_degrees(),
        MapKind::Sampled | MapKind::Ray => 0.0,
    }
}

/// A value as it was judged: the limit that it misses by no more than is equal, so that no picture shows a colour that the verdict denies.
fn as_judged(limits: &Limits, tie: f64, value: f64) -> f64 {
    let misses = |limit: &f64| {
        let by = match limits.sense {
            Sense::Min => limit - value,
            Sense::Max => value - limit,
        };
        by > 0.0 && by <= tie
    };
    [limits.fail, limits.warn].into_iter().flatten().find(misses).unwrap_or(value)
}

/// `opposite` is a feature opposite a piece nearby.
fn values_on(
    part: &Part,
    map: &MapWanted,
    (features, opposite): (Option<&Features>, &mut Option<u32>),
    piece: &Piece,
) -> [f32; 3] {
    if let (MapKind::Sampled, Some(field)) = (map.kind, &map.field) {
        return piece.read.map(|p| interpolated(field, p));
    }
    let [a, b, c] = piece.read;
    let middle = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0);
    // Just inside the piece, so that a neighbour's edge does not decide.
    let inside = piece.read.map(|p| along(p, sub(middle, p), 0.01));
    let normal = part.mesh().normal(piece.facet);
    match (shown(part, map, piece.facet), features, side_of(map.kind)) {
        (Shown::Varies, Some(features), Some(side)) => {
            let axis = normal.map(|x| x * side.sign());
            let whole = part.mesh().corners(piece.facet);
            inside.map(|p| opposing_distance(features, (p, axis), map.open_end, whole, opposite) as f32)
        }
        (Shown::Varies, None, _) => {
            let ray = |p| part.distance().first_hit(p, normal.map(|x| -x), part.step().max(1e-6), map.open_end);
            inside.map(|p| ray(p).map_or(map.open_end, |(far, _)| far) as f32)
        }
        (Shown::Constant(value), _, _) => [value as f32; 3],
        _ => [f32::NAN; 3],
    }
}

/// Trilinear mean of the samples about a point that hold a number; NaN where none does.
fn interpolated(field: &Field<f32>, p: Vec3) -> f32 {
    let at = field.grid().continuous_index(p);
    let base = at.map(f64::floor);
    let (mut sum, mut weight) = (0.0, 0.0);
    for corner in 0..8usize {
        let step = [0, 1, 2].map(|a| (corner >> a) & 1);
        let value = f64::from(field.at([0, 1, 2].map(|a| base[a] as isize + step[a] as isize)));
        let share: f64 = (0..3).map(|a| (1.0 - (at[a] - base[a] - step[a] as f64).abs()).max(1e-6)).product();
        if value.is_finite() {
            sum += share * value;
            weight += share;
        }
    }
    (sum / weight) as f32
}

/// A facet within 0.6° of the vertical hangs over nothing that a picture could show.
const LEANS: f64 = 0.01;

/// Angle of a downward facet from the horizontal, degrees; NaN where it is upright, looks up or lies on the plate.
fn slope(part: &Part, facet: usize) -> f64 {
    let normal = part.mesh().normal(facet);
    let on_plate = part.mesh().corners(facet).iter().all(|p| p[2] <= part.step().max(1e-4));
    if normal[2] < -LEANS && !on_plate { (-normal[2]).clamp(-1.0, 1.0).acos().to_degrees() } else { f64::NAN }
}

/// The density at about 128 samples along the longest side: means over blocks of samples.
fn volume(field: &Field<f32>) -> Option<Volume> {
    let grid = field.grid();
    let dims = grid.dims();
    let block = dims.iter().max()?.div_ceil(128).max(1);
    let coarse = dims.map(|n| n.div_ceil(block));
    let shift = 0.5 * (block as f64 - 1.0) * grid.h();
    let origin = grid.origin().map(|x| x + shift);
    let to = Grid::new(origin, grid.spacing() * block as f64, coarse).ok()?;
    let mean = |at: usize| {
        let [i, j, k] = to.index(at).map(|x| (x * block) as isize);
        let n = block as isize;
        let mut sum = 0.0;
        for z in k..k + n {
            for y in j..j + n {
                sum += (i..i + n).map(|x| f64::from(field.at([x, y, z]))).sum::<f64>();
            }
        }
        (255.0 * sum / (n * n * n) as f64).round() as u8
    };
    let density = (0..to.samples()).into_par_iter().map(mean).collect();
    Some(Volume { grid: to, density })
}

/// Three slices of the density through the worst finding, or through the middle.
fn slices(part: &Part, report: &Report) -> Vec<Slice> {
    let Ok(solid) = part.solid() else { return Vec::new() };
    let findings = report.findings();
    let focus = findings.first().map_or_else(|| part.extent().map(|x| 0.5 * x), |f| part.to_build(f.at_mm));
    let field = solid.density.field();
    let grid = field.grid();
    let dims = grid.dims();
    let at = grid.continuous_index(focus);
    (0..3)
        .map(|axis| {
            let layer = (at[axis].round().max(0.0) as usize).min(dims[axis] - 1);
            let [u, v] = [[1, 2], [0, 2], [0, 1]][axis];
            let position = grid.position([0, 1, 2].map(|a| if a == axis { layer } else { 0 }));
            let mut density = Vec::with_capacity(dims[u] * dims[v]);
            for j in 0..dims[v] {
                for i in 0..dims[u] {
                    let mut index = [0isize; 3];
                    index[axis] = layer as isize;
                    index[u] = i as isize;
                    index[v] = j as isize;
                    density.push(field.at(index));
                }
            }
            let near = |p: &Vec3| (p[axis] - position[axis]).abs() <= 2.0 * grid.h();
            let pins = findings
                .iter()
                .enumerate()
                .map(|(n, f)| (n + 1, part.to_build(f.at_mm)))
                .filter(|(_, p)| near(p))
                .map(|(n, p)| (n, [p[u], p[v]]))
                .collect();
            Slice {
                axis,
                at_mm: position[axis],
                origin_mm: [position[u], position[v]],
                spacing_mm: grid.h(),
                width: dims[u],
                height: dims[v],
                density,
                pins,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Length;

    #[test]
    fn what_the_verdict_takes_for_equal_to_a_limit_is_painted_so() {
        let limits = Limits { fail: Some(0.4), warn: Some(0.8), sense: Sense::Min };
        for (value, shown) in [(0.799_99, 0.8), (0.8, 0.8), (0.399_95, 0.4), (0.799_8, 0.799_8), (0.81, 0.81)] {
            assert_eq!(as_judged(&limits, 1e-4, value), shown);
        }
        let limits = Limits { fail: None, warn: Some(2.0), sense: Sense::Max };
        assert_eq!([2.000_05, 2.1, 1.9].map(|v| as_judged(&limits, 1e-4, v)), [2.0, 2.1, 1.9]);
        assert!(as_judged(&limits, 1e-4, f64::NAN).is_nan());
        // A wall of 0.79999 mm whose file tells lengths to 0.00003 mm passes at 0.8 mm, and is painted so.
        let plate = crate::geometry::cuboid([0.0; 3], [9.0, 0.799_99, 9.0]);
        let part = Part::new(plate, crate::part::Up::PlusZ, 1e-5, 1.0).unwrap();
        let limits = Limits { fail: Some(0.4), warn: Some(0.8), sense: Sense::Min };
        let shown = |value: f64| as_judged(&limits, tie(&part, MapKind::Wall, 0), value);
        assert_eq!([shown(0.799_99), shown(0.799_9)], [0.8, 0.799_9]);
    }

    #[test]
    fn a_field_is_read_between_its_samples_and_past_those_that_hold_no_number() {
        let grid = Grid::new([0.0; 3], Length::mm(1.0), [3, 3, 3]).unwrap();
        let x_of = |at: usize| grid.position(grid.index(at))[0] as f32;
        let mut values: Vec<f32> = (0..grid.samples()).map(x_of).collect();
        let whole = Field::from_values(grid, values.clone(), f32::NAN).unwrap();
        assert!((interpolated(&whole, [0.25, 1.0, 1.5]) - 0.25).abs() < 1e-5);
        for (at, v) in values.iter_mut().enumerate().filter(|(at, _)| grid.index(*at)[0] == 0) {
            assert_eq!(grid.index(at)[0], 0);
            *v = f32::NAN;
        }
        let part = Field::from_values(grid, values, f32::NAN).unwrap();
        assert!((interpolated(&part, [0.25, 1.0, 1.5]) - 1.0).abs() < 1e-5);
        assert!(interpolated(&part, [-5.0, 1.0, 1.0]).is_nan());
    }
}
