//! The whole answer on one picture, fit for a slide: verdict, the part with its pins, the worst findings, every check.

use super::canvas::Canvas;
use super::colour::{FAINT, INK, PAPER, STAGE, state_colour};
use super::lettering::Style;
use super::paint::SAMPLES;
use super::view::{Scene, TITLE, legend, scale_bar, triad};
use super::{Picture, pin, png};
use crate::check::{Basis, State};
use crate::error::printable;
use crate::report::phrase::{self, Numbered};
use crate::report::schema::CheckReport;

/// Width and height of the picture.
const SIZE: [usize; 2] = [1600, 900];
/// Where the findings begin.
const COLUMN: f64 = 1060.0;
/// Height of the strip of checks.
const STRIP: f64 = 108.0;

impl Scene<'_> {
    /// The summary of the report; the part is painted by the map of the worst finding that has one.
    pub fn summary(&self) -> Picture {
        let (w, h) = (SIZE[0] as f64, SIZE[1] as f64);
        let mut canvas = Canvas::new(SIZE[0], SIZE[1], STAGE);
        let counting: Vec<&Numbered> = self.findings.iter().filter(|n| n.finding.counts()).collect();
        let map_of = |n: &&Numbered| self.exhibit.maps.iter().find(|m| m.check == n.check.name);
        let map = counting.iter().find_map(map_of).or(self.exhibit.maps.first());
        let worst = counting.iter().find(|n| map.is_some_and(|m| m.check == n.check.name)).or(counting.first());
        let n = SAMPLES as f64;
        let stage = [36.0 * n, (TITLE + 30.0) * n, (COLUMN - 36.0) * n, (h - STRIP - 108.0) * n];
        let side = self.side(map, worst.copied());
        let camera = side.fitted(self.exhibit.corners.iter().copied(), stage);
        let raster = self.paint(&mut canvas, &camera, map);
        let pins = self.pins(&camera, &raster, |_| true);
        pin::set(&mut canvas, self.letters, &pins, [0.0, TITLE, COLUMN, h - STRIP]);
        let floor = h - STRIP;
        if let Some(map) = map {
            legend(&mut canvas, self.letters, map, [20.0, floor - 96.0]);
        }
        scale_bar(&mut canvas, self.letters, camera.scale / n, [COLUMN - 26.0, floor - 22.0], 150.0);
        triad(&mut canvas, self.letters, &camera, [COLUMN - 62.0, TITLE + 60.0]);
        canvas.panel([COLUMN, TITLE, w, h], 0.0, PAPER, 1.0);
        canvas.panel([0.0, floor, w, h], 0.0, PAPER, 1.0);
        canvas.line([COLUMN, TITLE], [COLUMN, floor], 1.0, [205, 212, 218], 1.0);
        canvas.line([0.0, floor], [w, floor], 1.0, [205, 212, 218], 1.0);
        self.listed(&mut canvas, &counting, floor);
        self.strip(&mut canvas, floor);
        self.title(&mut canvas, map);
        let alt = format!("{}: {}", phrase::headline(self.report.verdict), self.report.summary);
        Picture { name: "summary".into(), png: png::encode(&canvas, 220), alt }
    }

    /// The worst findings, one under the other: the worst of each check before the second of any.
    fn listed(&self, canvas: &mut Canvas, counting: &[&Numbered], floor: f64) {
        let (x, room) = (COLUMN + 24.0, SIZE[0] as f64 - COLUMN - 48.0);
        let head = match counting.len() {
            0 => "No finding in the checks that ran".to_string(),
            1 => "1 finding".into(),
            n => format!("{n} findings, worst first"),
        };
        self.letters.draw(canvas, [x, TITLE + 32.0], &head, &Style::bold(17.0, INK));
        let mut order: Vec<&&Numbered> = counting.iter().collect();
        order.sort_by_key(|n| (std::cmp::Reverse(n.finding.state), n.within, n.number));
        let mut y = TITLE + 48.0;
        let mut shown = 0;
        for n in &order {
            let below = self.one(canvas, n, [x, y], room, Drawn::No);
            if below > floor - 24.0 {
                break;
            }
            y = self.one(canvas, n, [x, y], room, Drawn::Yes);
            shown += 1;
        }
        if shown < order.len() {
            let more = format!("{} more stand in the report", order.len() - shown);
            self.letters.draw(canvas, [x, floor - 10.0], &more, &Style::regular(13.0, FAINT));
        }
    }

    /// One finding from a height downwards; returns where the next begins.
    fn one(&self, canvas: &mut Canvas, n: &Numbered, [x, y]: [f64; 2], room: f64, drawn: Drawn) -> f64 {
        let f = n.finding;
        let (bold, text, small) = (Style::bold(15.0, INK), Style::regular(13.5, INK), Style::regular(12.5, FAINT));
        let indent = x + 34.0;
        let bracket = n.bracket().map_or(String::new(), |b| format!(" ({b})"));
        let basis = if f.basis == Basis::Estimated { ", estimated" } else { "" };
        let head = format!("{} {}{bracket}{basis}", n.check.name, n.measured());
        let mut lines = vec![(head, bold, 1)];
        let place = phrase::whereabouts(self.posed(f.at_mm), self.report.part.posed_box());
        let sizes = n.size().into_iter().map(|s| format!(" · {s}")).collect::<String>();
        lines.push((format!("{} · {place}{sizes}", phrase::deciding(f)), small, 1));
        let word = if f.state == State::Undecided { "To decide" } else { "Fix" };
        lines.push((format!("{word}: {}", f.fix), text, 2));
        let mut at = y + 20.0;
        for (words, style, most) in lines {
            for line in self.broken(&words, &style, room - 34.0, most) {
                if drawn == Drawn::Yes {
                    self.letters.draw(canvas, [indent, at], &line, &style);
                }
                at += 18.5;
            }
        }
        if drawn == Drawn::Yes {
            let pin =
                pin::Pin { number: n.number, state: n.shown(), at: [x + 13.0, y + 16.0], hidden: false, own: true };
            pin::set(canvas, self.letters, &[pin], [0.0, 0.0, SIZE[0] as f64, SIZE[1] as f64]);
        }
        at + 6.0
    }

    /// A text in lines of a length in pixels; the last is cut where it does not fit.
    fn broken(&self, text: &str, style: &Style, length: f64, most: usize) -> Vec<String> {
        let mut lines = vec![String::new()];
        for word in text.split_whitespace().map(printable) {
            let last = lines.last().cloned().unwrap_or_default();
            let longer = if last.is_empty() { word.clone() } else { format!("{last} {word}") };
            if last.is_empty() || self.letters.width(&longer, style) <= length || lines.len() == most {
                lines.pop();
                lines.push(longer);
            } else {
                lines.push(word);
            }
        }
        lines.iter().map(|l| self.letters.fitted(l, style, length)).collect()
    }

    /// Every check as a glyph and its name, in the order of the report, in rows.
    fn strip(&self, canvas: &mut Canvas, floor: f64) {
        let checks: Vec<&CheckReport> = self.report.checks.iter().collect();
        let columns = 6;
        let wide = (SIZE[0] as f64 - 40.0) / columns as f64;
        for (i, c) in checks.iter().take(4 * columns).enumerate() {
            let (x, y) = (22.0 + wide * (i % columns) as f64, floor + 26.0 + 23.0 * (i / columns) as f64);
            let colour = state_colour(c.state);
            self.letters.draw(canvas, [x, y], c.state.glyph(), &Style::bold(14.0, colour));
            let quiet = matches!(c.state, State::Pass | State::NotRun | State::NotApplicable);
            let style = if quiet { Style::regular(13.5, FAINT) } else { Style::bold(13.5, INK) };
            let mut words = printable(&c.name);
            if c.state == State::Pass {
                words += &phrase::beside_name(c);
            }
            let words = self.letters.fitted(&words, &style, wide - 36.0);
            self.letters.draw(canvas, [x + 20.0, y], &words, &style);
        }
    }
}

/// Whether a finding is drawn, or only measured.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Drawn {
    Yes,
    No,
}
