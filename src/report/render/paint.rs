//! Samples into pixels: shading, the colours of a map, hatching beyond its limits, ink on creases and limits.

use super::camera::{Camera, facet};
use super::canvas::Canvas;
use super::colour::{INK, Rgb, Scale, UNMEASURED, Zone};
use super::raster::{NOTHING, Raster};
use crate::geometry::vector::{Vec3, cross, dot, sub, unit};

/// Samples along each side of a pixel.
pub const SAMPLES: usize = 2;

/// Two neighbouring facets whose normals differ by more than 25° meet in a crease.
const CREASE_COSINE: f32 = 0.906;

/// What is painted on the part.
pub struct Paint<'a> {
    pub scale: Scale,
    /// One value per corner; an empty list leaves the part unpainted.
    pub values: &'a [f32],
}

/// A facet made ready: how light it is, its normal, and its values as a plane over the samples.
#[derive(Clone, Copy, Default)]
struct Ready {
    normal: [f32; 3],
    shade: f32,
    /// Value at the sample's origin, and its change per sample along x and y.
    value: [f32; 3],
    /// Change of depth per sample along x and y.
    slope: [f32; 2],
}

/// A coloured sample.
#[derive(Clone, Copy)]
struct Dot {
    colour: Rgb,
    zone: Zone,
}

/// Paints what a raster sees onto the canvas, whose pixel `[0, 0]` begins at sample `[0, 0]`.
///
/// A pixel is the mean of its samples. Between the zones of a map runs a line of ink, one pixel wide; the fail zone
/// is hatched densely, the warn zone sparsely the other way, so that neither depends on colour.
///
/// # Cost
/// O(facets + samples).
pub fn paint(canvas: &mut Canvas, raster: &Raster, corners: &[Vec3], camera: &Camera, paint: &Paint) {
    let ready = make_ready(corners, camera, paint, raster);
    let (w, h) = (raster.width, raster.height);
    let mut rows = [vec![None; w], vec![None; w], vec![None; w]];
    let mut ink = [vec![false; w], vec![false; w]];
    colour_row(&mut rows[0], 0, raster, &ready, paint);
    for y in 0..h / SAMPLES {
        let top = y * SAMPLES;
        let columns = (top.saturating_sub(1)..=top + SAMPLES).map(|j| raster.covered(j)).filter(|c| !c.is_empty());
        let columns = columns.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0);
        for (k, inked) in ink.iter_mut().enumerate() {
            let j = top + k;
            let [first, second, third] = &mut rows;
            let (here, below) = if k == 0 { (first, second) } else { (second, third) };
            if j + 1 < h {
                colour_row(below, j + 1, raster, &ready, paint);
            }
            for i in columns.clone() {
                inked[i] = (i + 1 < w && edge(raster, &ready, here, here, j * w + i, (i, i + 1), 0))
                    || (j + 1 < h && edge(raster, &ready, here, below, j * w + i, (i, i), 1));
            }
        }
        let [first, second, third] = &mut rows;
        for x in columns.start / SAMPLES..columns.end.div_ceil(SAMPLES).min(w / SAMPLES) {
            let pixel = mean(
                canvas.at(x, y),
                [&first[2 * x..2 * x + 2], &second[2 * x..2 * x + 2]],
                [&ink[0][2 * x..2 * x + 2], &ink[1][2 * x..2 * x + 2]],
            );
            if let Some(pixel) = pixel {
                canvas.set(x, y, pixel);
            }
        }
        ink.iter_mut().for_each(|row| row[columns.clone()].fill(false));
        std::mem::swap(first, third);
    }
}

/// The mean of four samples over the ground; `None` where all are ground.
fn mean(ground: Rgb, dots: [&[Option<Dot>]; 2], ink: [&[bool]; 2]) -> Option<Rgb> {
    let mut sum = [0u32; 3];
    let mut covered = false;
    for (dots, ink) in dots.iter().zip(ink) {
        for (dot, &inked) in dots.iter().zip(ink) {
            covered |= dot.is_some() || inked;
            let c = match dot {
                _ if inked => INK,
                Some(d) => d.colour,
                None => ground,
            };
            sum = [0, 1, 2].map(|k| sum[k] + u32::from(c[k]));
        }
    }
    covered.then(|| sum.map(|s| ((s + 2) / 4) as u8))
}

/// The facets that are seen, with their light and their values as planes; the others are left blank.
fn make_ready(corners: &[Vec3], camera: &Camera, paint: &Paint, raster: &Raster) -> Vec<Ready> {
    // The lamp stands up and to the left of the eye.
    let lamp = unit([0, 1, 2].map(|a| camera.toward[a] - 0.55 * camera.right[a] + 0.75 * camera.up[a]));
    let mut seen = vec![false; corners.len() / 3];
    raster.facet.iter().for_each(|&f| {
        if let Some(seen) = seen.get_mut(f as usize) {
            *seen = true;
        }
    });
    let ready = |f: usize, [a, b, c]: [Vec3; 3]| {
        let mut normal = unit(cross(sub(b, a), sub(c, a)));
        if dot(normal, camera.toward) < 0.0 {
            normal = normal.map(|x| -x);
        }
        let shade = 0.74 + 0.27 * dot(normal, lamp).max(0.0) + 0.03 * normal[2];
        let p = [a, b, c].map(|p| camera.project(p));
        let values = paint.values.get(3 * f..3 * f + 3).map_or([f32::NAN; 3], |v| [v[0], v[1], v[2]]);
        let value = plane(p, filled(values));
        let depth = plane(p, [p[0][2], p[1][2], p[2][2]]);
        Ready {
            normal: normal.map(|x| x as f32),
            shade: shade.clamp(0.0, 1.06) as f32,
            value: value.map(|x| x as f32),
            slope: [depth[1] as f32, depth[2] as f32],
        }
    };
    let of = |(f, seen): (usize, bool)| facet(corners, f).filter(|_| seen).map(|c| ready(f, c)).unwrap_or_default();
    seen.into_iter().enumerate().map(of).collect()
}

/// Three values for a plane: a corner where nothing is measured takes the mean of those where something is.
fn filled(values: [f32; 3]) -> [f64; 3] {
    let known = || values.into_iter().filter(|v| v.is_finite()).map(f64::from);
    let mean = known().sum::<f64>() / known().count() as f64;
    values.map(|v| if v.is_finite() { f64::from(v) } else { mean })
}

/// Value at the sample origin and its change along x and y, from three projected corners.
fn plane([a, b, c]: [Vec3; 3], v: [f64; 3]) -> [f64; 3] {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let det = ab[0] * ac[1] - ab[1] * ac[0];
    if det.abs() < 1e-9 {
        return [v[0], 0.0, 0.0];
    }
    let (u, w) = (v[1] - v[0], v[2] - v[0]);
    let (gx, gy) = ((u * ac[1] - w * ab[1]) / det, (w * ab[0] - u * ac[0]) / det);
    [v[0] - gx * a[0] - gy * a[1], gx, gy]
}

/// Colours one row of samples.
fn colour_row(row: &mut [Option<Dot>], j: usize, raster: &Raster, ready: &[Ready], paint: &Paint) {
    let facets = &raster.facet[j * raster.width..(j + 1) * raster.width];
    let y = j as f32 + 0.5;
    let mut last: Option<(u32, f32, Rgb, Zone)> = None;
    for (i, (dot, &f)) in row.iter_mut().zip(facets).enumerate() {
        let Some(r) = ready.get(f as usize).filter(|_| f != NOTHING) else {
            *dot = None;
            continue;
        };
        let value = r.value[0] + r.value[1] * (i as f32 + 0.5) + r.value[2] * y;
        let (colour, zone) = match last {
            Some((g, v, colour, zone)) if g == f && (v == value || v.is_nan()) => (colour, zone),
            _ if paint.values.is_empty() => (UNMEASURED, Zone::Unmeasured),
            _ => (paint.scale.colour(value), paint.scale.zone(value)),
        };
        last = Some((f, value, colour, zone));
        let light = r.shade * hatching(zone, i, j);
        *dot = Some(Dot { colour: colour.map(|c| (f32::from(c) * light).min(255.0) as u8), zone });
    }
}

/// How dark the hatching makes a sample: dense diagonals where a value fails, sparse ones the other way where it warns.
fn hatching(zone: Zone, i: usize, j: usize) -> f32 {
    match zone {
        Zone::Fail if (i + j) % 14 < 4 => 0.62,
        Zone::Warn if (i + 20_000 - j) % 22 < 3 => 0.72,
        _ => 1.0,
    }
}

/// Whether ink runs between two neighbouring samples: an outline, a crease, a step in depth, or a limit.
fn edge(
    raster: &Raster,
    ready: &[Ready],
    here: &[Option<Dot>],
    there: &[Option<Dot>],
    at: usize,
    (i, i2): (usize, usize),
    axis: usize,
) -> bool {
    let next = if axis == 0 { at + 1 } else { at + raster.width };
    let (f, g) = (raster.facet[at], raster.facet[next]);
    if f == g && (f == NOTHING || here[i].map(|d| d.zone) == there[i2].map(|d| d.zone)) {
        return false;
    }
    let (Some(a), Some(b)) = (ready.get(f as usize), ready.get(g as usize)) else {
        return f != g;
    };
    let zones = here[i].map(|d| d.zone).zip(there[i2].map(|d| d.zone));
    if zones.is_some_and(|(p, q)| p != q && p > Zone::Unmeasured && q > Zone::Unmeasured) {
        return true;
    }
    if f == g {
        return false;
    }
    let facing: f32 = (0..3).map(|k| a.normal[k] * b.normal[k]).sum();
    let step = raster.depth[next] - raster.depth[at];
    // On one surface the step is between the slopes of its two facets; eight samples beyond that it is an outline.
    let (least, most) = (a.slope[axis].min(b.slope[axis]), a.slope[axis].max(b.slope[axis]));
    facing < CREASE_COSINE || step > most + 8.0 || step < least - 8.0
}
