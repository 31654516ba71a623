//! A view of the part: title, painted part, pins, legend, scale bar.

use super::camera::Camera;
use super::canvas::Canvas;
use super::colour::{FAINT, INK, PAPER, Rgb, STAGE, Scale, Zone, state_colour};
use super::lettering::{Lettering, Style};
use super::paint::{self, Paint, SAMPLES};
use super::pin::{self, Pin};
use super::raster::{Faces, Raster};
use super::sides::{Sides, hidden};
use super::{Picture, png};
use crate::error::printable;
use crate::geometry::vector::{Vec3, dot};
use crate::report::exhibit::{Exhibit, SurfaceMap};
use crate::report::phrase::{self, Numbered};
use crate::report::schema::Report;
use crate::units::short;

/// Width and height of a view.
const VIEW: [usize; 2] = [1200, 760];
/// Width and height of a close-up.
const CLOSE: [usize; 2] = [460, 288];
/// Width and height of a thumbnail.
const THUMBNAIL: [usize; 2] = [320, 200];
/// Height of the title over a view.
pub(super) const TITLE: f64 = 66.0;
/// Most pins on a view.
const PINS: usize = 16;

/// What all views share.
pub struct Scene<'a> {
    pub(super) report: &'a Report,
    pub(super) exhibit: &'a Exhibit,
    pub(super) findings: &'a [Numbered<'a>],
    pub(super) letters: &'a Lettering,
    faces: Faces,
    sides: Sides,
}

impl<'a> Scene<'a> {
    pub fn new(report: &'a Report, exhibit: &'a Exhibit, findings: &'a [Numbered<'a>], letters: &'a Lettering) -> Self {
        let faces = if report.part.watertight { Faces::Front } else { Faces::Both };
        Scene { report, exhibit, findings, letters, faces, sides: Sides::new(&exhibit.corners, faces) }
    }

    /// A place of the input frame in the frame of the build.
    pub(super) fn posed(&self, p: Vec3) -> Vec3 {
        self.report.part.posed(p)
    }

    /// The side from which a check is best seen.
    pub(super) fn side(&self, map: Option<&SurfaceMap>, finding: Option<&Numbered>) -> Camera {
        let marked: Vec<bool> = map.map_or(Vec::new(), |m| {
            let scale = Scale::of(m);
            m.values.chunks_exact(3).map(|v| v.iter().any(|&v| scale.zone(v) >= Zone::Warn)).collect()
        });
        let place = finding.map(|n| self.posed(n.finding.at_mm));
        self.sides.best(&marked, place, finding.map_or(0.0, |n| self.skin(n)))
    }

    /// How much material may stand before a finding's place without hiding it: a place in the middle of a wall
    /// is seen on its skin.
    fn skin(&self, n: &Numbered) -> f64 {
        let own = if n.finding.unit == "mm" { 0.6 * n.finding.high } else { 0.0 };
        own.min(0.1 * span(self.report.part.box_mm)) + 0.006 * span(self.report.part.box_mm)
    }

    /// Paints the part over the whole canvas; returns what was seen.
    pub(super) fn paint(&self, canvas: &mut Canvas, camera: &Camera, map: Option<&SurfaceMap>) -> Raster {
        let corners = &self.exhibit.corners;
        let raster = Raster::new(corners, camera, SAMPLES * canvas.width(), SAMPLES * canvas.height(), self.faces);
        let none = Scale { low: 0.0, high: 1.0, fail: None, warn: None, sense: crate::check::Sense::Min };
        let paint = Paint { scale: map.map_or(none, Scale::of), values: map.map_or(&[], |m| &m.values) };
        paint::paint(canvas, &raster, corners, camera, &paint);
        raster
    }

    /// The part painted by a map, or bare.
    pub fn overview(&self, map: Option<&SurfaceMap>) -> Picture {
        let mut canvas = Canvas::new(VIEW[0], VIEW[1], STAGE);
        let of_map = |n: &&Numbered| map.is_some_and(|m| m.check == n.check.name);
        let worst = self.findings.iter().find(of_map).or(self.findings.first());
        let n = SAMPLES as f64;
        let (w, h) = (VIEW[0] as f64, VIEW[1] as f64);
        let stage = [60.0 * n, (TITLE + 28.0) * n, (w - 60.0) * n, (h - 104.0) * n];
        let side = self.side(map, worst);
        let camera = side.fitted(self.exhibit.corners.iter().copied(), stage);
        let raster = self.paint(&mut canvas, &camera, map);
        let pins = self.pins(&camera, &raster, |n| map.is_none_or(|m| m.check == n.check.name));
        pin::set(&mut canvas, self.letters, &pins, [0.0, TITLE, w, h]);
        self.title(&mut canvas, map);
        if let Some(map) = map {
            legend(&mut canvas, self.letters, map, [20.0, h - 102.0]);
        }
        scale_bar(&mut canvas, self.letters, camera.scale / n, [w - 24.0, h - 26.0], 150.0);
        triad(&mut canvas, self.letters, &camera, [w - 66.0, TITLE + 62.0]);
        let (name, alt) = match map {
            Some(m) => (m.check.clone(), self.alt(m)),
            None => ("part".into(), "The part, unpainted.".into()),
        };
        Picture { name, png: png::encode(&canvas, 200), alt }
    }

    /// The part painted by the map of its worst finding, small, with the pins of that check and nothing else.
    pub fn thumbnail(&self) -> Picture {
        let mut canvas = Canvas::new(THUMBNAIL[0], THUMBNAIL[1], STAGE);
        let worst = self.findings.first();
        let map = worst.and_then(|n| self.exhibit.maps.iter().find(|m| m.check == n.check.name));
        let n = SAMPLES as f64;
        let (w, h) = (THUMBNAIL[0] as f64, THUMBNAIL[1] as f64);
        let stage = [14.0 * n, 14.0 * n, (w - 14.0) * n, (h - 14.0) * n];
        let camera = self.side(map, worst).fitted(self.exhibit.corners.iter().copied(), stage);
        let raster = self.paint(&mut canvas, &camera, map);
        let own = |n: &Numbered| worst.is_some_and(|w| w.check.name == n.check.name);
        let mut pins = self.pins(&camera, &raster, own);
        pins.retain(|p| p.own);
        pin::set(&mut canvas, self.letters, &pins, [0.0, 0.0, w, h]);
        Picture { name: "thumbnail".into(), png: png::encode(&canvas, 64), alt: "The part, small.".into() }
    }

    /// How near a picture is to the part, where it shows a coarser copy.
    fn coarser(&self) -> Option<String> {
        self.exhibit.coarsened.map(|copy| format!("drawn within {}", phrase::at_most(copy.within_mm, "mm")))
    }

    /// What a view shows, in words.
    fn alt(&self, map: &SurfaceMap) -> String {
        let found = self.findings.iter().filter(|n| n.check.name == map.check);
        let pins: Vec<String> = found.map(|n| format!("{} ({})", n.number, n.measured())).take(8).collect();
        let limits = phrase::limits(map.fail, map.warn, map.sense, &map.unit);
        if pins.is_empty() {
            format!("The part painted by {}; {limits}; nothing found.", map.title.to_lowercase())
        } else {
            format!("The part painted by {}; {limits}; pins {}.", map.title.to_lowercase(), pins.join(", "))
        }
    }

    /// Pins of the findings, those the view is about before the others.
    pub(super) fn pins(&self, camera: &Camera, raster: &Raster, own: impl Fn(&Numbered) -> bool) -> Vec<Pin> {
        let mut chosen: Vec<&Numbered> = self.findings.iter().collect();
        chosen.sort_by_key(|n| (!own(n), n.number));
        chosen.truncate(PINS);
        let n = SAMPLES as f64;
        let pin = |f: &&Numbered| {
            let place = self.posed(f.finding.at_mm);
            let p = camera.project(place);
            let hidden = hidden(raster, camera, place, self.skin(f));
            Pin { number: f.number, state: f.shown(), at: [p[0] / n, p[1] / n], hidden, own: own(f) }
        };
        chosen.iter().map(pin).collect()
    }

    /// Verdict, sentence, part and map over the view.
    pub(super) fn title(&self, canvas: &mut Canvas, map: Option<&SurfaceMap>) {
        let w = canvas.width() as f64;
        let state = phrase::verdict_state(self.report.verdict);
        canvas.panel([0.0, 0.0, w, TITLE], 0.0, PAPER, 1.0);
        canvas.panel([0.0, 0.0, 6.0, TITLE], 0.0, state_colour(state), 1.0);
        canvas.line([0.0, TITLE], [w, TITLE], 1.0, [205, 212, 218], 1.0);
        let letters = self.letters;
        let headline = format!("{} {}", state.glyph(), phrase::headline(self.report.verdict));
        let end = letters.draw(canvas, [22.0, 29.0], &headline, &Style::bold(21.0, state_colour(state)));
        let counts: Vec<String> = phrase::counts(self.report).into_iter().map(|(_, _, words)| words).collect();
        letters.draw(canvas, [end + 16.0, 29.0], &counts.join(" · "), &Style::regular(15.0, FAINT));
        let right = map.map_or(String::new(), |m| m.title.clone());
        letters.draw_right(canvas, [w - 22.0, 29.0], &right, &Style::bold(18.0, INK));
        let small = Style::regular(13.5, FAINT);
        let part = format!("{}  {}", printable(&self.report.part.file), phrase::extent(self.report.part.box_mm));
        let coarser = self.coarser().map_or(String::new(), |said| format!(" · {said}"));
        let part = letters.fitted(&part, &small, 0.36 * w - letters.width(&coarser, &small)) + &coarser;
        letters.draw_right(canvas, [w - 22.0, 52.0], &part, &small);
        let room = w - 70.0 - letters.width(&part, &small);
        letters.draw(canvas, [22.0, 52.0], &letters.fitted(&self.report.summary, &small, room), &small);
    }

    /// The worst place of a check, near.
    pub fn close_up(&self, n: &Numbered) -> Picture {
        let mut canvas = Canvas::new(CLOSE[0], CLOSE[1], STAGE);
        let map = self.exhibit.maps.iter().find(|m| m.check == n.check.name);
        let place = self.posed(n.finding.at_mm);
        let camera = self.side(map, Some(n));
        // The finding's own box and some surroundings, but never less than a tenth of the part.
        let own = span(n.finding.box_mm);
        let whole = span(self.report.part.box_mm);
        let reach = (1.7 * own).clamp(0.16 * whole, 0.8 * whole).max(1e-6);
        let s = SAMPLES as f64;
        let (w, h) = (CLOSE[0] as f64, CLOSE[1] as f64);
        let camera = camera.centred(place, s * h / reach, [0.5 * s * w, 0.5 * s * h]);
        let raster = self.paint(&mut canvas, &camera, map);
        let mut pins = self.pins(&camera, &raster, |m| m.check.name == n.check.name);
        pins.retain(|p| p.own && p.at[0] > 0.0 && p.at[0] < w && p.at[1] > 0.0 && p.at[1] < h);
        pin::set(&mut canvas, self.letters, &pins, [0.0, 0.0, w, h]);
        scale_bar(&mut canvas, self.letters, camera.scale / s, [w - 14.0, h - 16.0], 90.0);
        let alt = format!("Close-up of finding {}: {}", n.number, n.finding.message);
        Picture { name: format!("close-{}", n.check.name), png: png::encode(&canvas, 64), alt }
    }
}

/// The longest side of a box.
fn span(box_mm: [Vec3; 2]) -> f64 {
    (0..3).map(|a| box_mm[1][a] - box_mm[0][a]).fold(0.0, f64::max)
}

/// The legend: name and unit, colours with the hard steps, a tick at each limit, and both ends.
pub(super) fn legend(canvas: &mut Canvas, letters: &Lettering, map: &SurfaceMap, [x, y]: [f64; 2]) {
    let (w, h) = (372.0, 82.0);
    canvas.panel([x - 1.0, y - 1.0, x + w + 1.0, y + h + 1.0], 8.0, [205, 212, 218], 1.0);
    canvas.panel([x, y, x + w, y + h], 7.0, PAPER, 1.0);
    let unit = phrase::unit_sign(&map.unit);
    let title = if unit.is_empty() { map.title.clone() } else { format!("{} ({unit})", map.title) };
    letters.draw(canvas, [x + 14.0, y + 20.0], &title, &Style::bold(13.0, INK));
    let scale = Scale::of(map);
    let (x0, x1, y0) = (x + 14.0, x + w - 14.0, y + 43.0);
    let across = |v: f64| x0 + (x1 - x0) * ((v - scale.low) / (scale.high - scale.low)).clamp(0.0, 1.0);
    for i in 0..(x1 - x0) as usize {
        let v = scale.low + (scale.high - scale.low) * (i as f64 + 0.5) / (x1 - x0);
        for j in 0..14 {
            let (px, py) = (x0 as usize + i, y0 as usize + j);
            canvas.set(px, py, hatched(scale.colour(v as f32), scale.zone(v as f32), px, py));
        }
    }
    let mut ends = f64::MIN;
    let mut ticks: Vec<(f64, &str)> = [(scale.fail, "must"), (scale.warn, "should")]
        .into_iter()
        .filter_map(|(limit, word)| limit.map(|l| (l, word)))
        .collect();
    ticks.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (limit, word) in ticks {
        let at = across(limit);
        canvas.line([at, y0 - 4.0], [at, y0 + 18.0], 2.0, INK, 1.0);
        let text = format!("{word} {} {}", phrase::relation(scale.sense), phrase::quantity(limit, &map.unit));
        let style = Style::bold(11.5, INK);
        let from = (at - 0.5 * letters.width(&text, &style)).max(ends + 8.0).max(x0);
        ends = letters.draw(canvas, [from, y0 - 7.0], &text, &style);
    }
    let small = Style::regular(12.0, FAINT);
    letters.draw(canvas, [x0, y0 + 31.0], &short(scale.low), &small);
    // Nothing lies beyond 90°.
    let beyond = if map.unit == "deg" && scale.high >= 90.0 { "" } else { "≥ " };
    letters.draw_right(canvas, [x1, y0 + 31.0], &format!("{beyond}{}", short(scale.high)), &small);
}

/// A colour of the legend with the hatching of its zone.
fn hatched(colour: Rgb, zone: Zone, x: usize, y: usize) -> Rgb {
    let dark = match zone {
        Zone::Fail => (x + y) % 7 < 2,
        Zone::Warn => (x + 700 - y) % 11 < 2,
        _ => false,
    };
    if dark { colour.map(|c| (f64::from(c) * 0.66) as u8) } else { colour }
}

/// A bar of 1, 2 or 5 times a power of ten millimetres that ends at a point and is at most `most` pixels long.
pub fn scale_bar(canvas: &mut Canvas, letters: &Lettering, pixels_per_mm: f64, [x, y]: [f64; 2], most: f64) {
    let room = most / pixels_per_mm.max(1e-12);
    let decade = 10f64.powf(room.log10().floor());
    let length = [5.0, 2.0, 1.0].into_iter().map(|k| k * decade).find(|l| *l <= room).unwrap_or(decade);
    let from = x - length * pixels_per_mm;
    for (grow, colour) in [(2.0, PAPER), (0.0, INK)] {
        canvas.line([from, y], [x, y], 2.0 + grow, colour, 1.0);
        for end in [from, x] {
            canvas.line([end, y - 4.0], [end, y + 4.0], 2.0 + grow, colour, 1.0);
        }
    }
    letters.draw_centred(canvas, [0.5 * (from + x), y - 9.0], &phrase::quantity(length, "mm"), &Style::bold(12.5, INK));
}

/// The three axes as they are seen.
pub(super) fn triad(canvas: &mut Canvas, letters: &Lettering, camera: &Camera, [x, y]: [f64; 2]) {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let mut v = [0.0; 3];
        v[axis] = 1.0;
        let (dx, dy) = (dot(camera.right, v), -dot(camera.up, v));
        canvas.line([x, y], [x + 28.0 * dx, y + 28.0 * dy], 1.6, FAINT, 1.0);
        letters.draw_centred(canvas, [x + 38.0 * dx, y + 38.0 * dy + 4.5], name, &Style::bold(12.0, FAINT));
    }
}
