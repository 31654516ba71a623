//! The 3-D view: a compressed program and a compressed part inside the page, and nothing where they would be too long.

use super::page::Context;
use crate::report::glb::{self, Detail};
use crate::report::markup::{Markup, markup};
use crate::report::phrase;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, GzBuilder};
use rayon::prelude::*;
use std::io::Write;

/// The program: three.js (MIT, see `viewer/THREE-LICENSE.txt`) and `viewer/*.js`, rebuilt by
/// `npm ci && npm run build` in `viewer/`.
const PROGRAM: &[u8] = include_bytes!("viewer/viewer.min.js.gz");

/// Bytes that the compressed part may take however long the rest of the page is.
const LEAST: usize = 250_000;
/// Bytes of scripts and elements that come with it.
const AROUND: usize = 16_000;

/// The place of the view on the stage.
pub fn place() -> Markup {
    Markup::raw("<div id=\"viewer\" hidden></div><p class=\"note\" id=\"viewer-note\" hidden></p>")
}

/// How fine the part may be shown, finest first.
const PARTS: [Detail; 7] = [
    Detail::FULL,
    Detail { cells: 8192, codes: 510 },
    Detail { cells: 2048, codes: 255 },
    Detail { cells: 512, codes: 128 },
    Detail { cells: 256, codes: 64 },
    Detail { cells: 128, codes: 64 },
    Detail { cells: 64, codes: 32 },
];

/// How fine its layers may be shown; they give way before the part does.
const LAYERS: [Detail; 7] = [
    Detail::FULL,
    Detail { cells: 512, codes: 64 },
    Detail { cells: 128, codes: 64 },
    Detail { cells: 96, codes: 64 },
    Detail { cells: 64, codes: 64 },
    Detail { cells: 48, codes: 32 },
    Detail { cells: 32, codes: 32 },
];

/// Share of the room that the part may take where layers come with it.
const OWN: f64 = 0.72;

/// What fits: the part and its layers as text, and how fine they are.
struct Fitted {
    text: String,
    part: Detail,
    layers: Option<Detail>,
}

/// The finest part that fits into its share of `most` bytes and leaves room for layers, with the finest layers that fit beside it;
/// the finest part alone where there is room for no layers at all.
fn fitted(c: &Context, most: usize) -> Option<Fitted> {
    let source = glb::Source::of(c.exhibit);
    let alone = |part: Detail| {
        let copy = glb::Copy::of(&source, part);
        let bytes = copy.with(None);
        (copy, bytes)
    };
    let layered = !c.exhibit.layers.is_empty();
    let own = if layered { (OWN * most as f64) as usize } else { most };
    let mut found: Option<Fitted> = None;
    let mut parts = PARTS.as_slice();
    while let Some(fit) = finest(parts, own, c.exhibit.corners.len(), alone) {
        let (part, copy) = (fit.detail, fit.copy);
        let known = found.get_or_insert(Fitted { text: fit.text, part, layers: None });
        if !layered {
            break;
        }
        // Layers that did not fit at their coarsest beside a part are tried again beside a coarser one.
        let of_layers = c.exhibit.layers.iter().map(|l| l.corners.len()).sum();
        if let Some(fit) = finest(&LAYERS, most, of_layers, |layers| ((), copy.with(Some(layers)))) {
            *known = Fitted { text: fit.text, part, layers: Some(fit.detail) };
            break;
        }
        parts = fit.coarser;
    }
    found
}

/// What of a list fits.
struct Fit<'a, T> {
    detail: Detail,
    text: String,
    copy: T,
    coarser: &'a [Detail],
}

/// Room for each corner in a page, bytes, where the finest copy has a chance to fit.
const LIKELY: usize = 2;

/// The first of a list, finest first, that packs into `room` bytes as text. The finest mostly fits and is tried alone where there is
/// room for the corners it has; the others are tried two by two.
fn finest<'a, T: Send>(
    list: &'a [Detail],
    room: usize,
    corners: usize,
    written: impl Fn(Detail) -> (T, Vec<u8>) + Sync,
) -> Option<Fit<'a, T>> {
    let tried = |&detail: &Detail| {
        let (copy, bytes) = written(detail);
        zipped_within(&bytes, room / 4 * 3).map(|z| (STANDARD.encode(z), copy))
    };
    let (first, rest) = list.split_at(usize::from(corners * LIKELY <= room).min(list.len()));
    let mut passed = 0;
    for some in std::iter::once(first).chain(rest.chunks(2)).filter(|some| !some.is_empty()) {
        let texts: Vec<Option<(String, T)>> = some.par_iter().map(tried).collect();
        for (text, &detail) in texts.into_iter().zip(some) {
            passed += 1;
            if let Some((text, copy)) = text {
                return Some(Fit { detail, text, copy, coarser: list.get(passed..).unwrap_or_default() });
            }
        }
    }
    None
}

/// Program and part as text for `page.js`, as fine as fits into `room` bytes; a coarser copy is said.
pub fn data(c: &Context, room: usize) -> Markup {
    if c.exhibit.corners.is_empty() {
        return Markup::default();
    }
    let program = STANDARD.encode(PROGRAM);
    let most = room.saturating_sub(program.len() + AROUND).max(LEAST);
    let Some(fitted) = fitted(c, most) else {
        return Markup::raw(
            "<p class=\"note\">The part is too large for a 3-D view in this page; the pictures show it.</p>\n",
        );
    };
    markup!(
        "{}<script type=\"text/plain\" id=\"viewer-part\">{}</script>\n<script type=\"text/plain\" id=\"viewer-program\">{}</script>\n",
        coarseness(c, &fitted),
        Markup::made(fitted.text),
        Markup::made(program)
    )
}

/// What is coarser in the view than in truth, and by how much.
fn coarseness(c: &Context, fitted: &Fitted) -> Markup {
    let longest = (0..3).map(|a| c.report.part.box_mm[1][a] - c.report.part.box_mm[0][a]).fold(0.0, f64::max);
    let step = |d: Detail| phrase::quantity((longest / f64::from(d.cells) * 1000.0).ceil() / 1000.0, "mm");
    let part =
        (fitted.part != Detail::FULL).then(|| format!("a coarser copy, corners within {} as one", step(fitted.part)));
    let layers = match fitted.layers {
        None if c.exhibit.layers.is_empty() => None,
        None => Some("no layers, for which there is no room".to_string()),
        Some(Detail::FULL) => None,
        Some(d) => Some(format!("its layers, within {}", step(d))),
    };
    let said: Vec<String> = [part, layers].into_iter().flatten().collect();
    if said.is_empty() {
        return Markup::default();
    }
    // Where the pictures show a copy too, that is said beside them.
    let whole = if c.exhibit.coarsened.is_some() { "numbers" } else { "numbers and pictures" };
    markup!(
        "<p class=\"note\">The 3-D view shows {}, so that the page stays small; all {} come from the whole part.</p>\n",
        said.join(", and "),
        whole
    )
}

/// Bytes as a gzip file without time or name.
pub fn zipped(bytes: &[u8]) -> Vec<u8> {
    zipped_within(bytes, usize::MAX).unwrap_or_default()
}

/// The same, given up as soon as it is longer than `most` bytes.
fn zipped_within(bytes: &[u8], most: usize) -> Option<Vec<u8>> {
    let mut to = GzBuilder::new().mtime(0).write(Short { bytes: Vec::new(), most }, Compression::new(6));
    to.write_all(bytes).ok()?;
    to.finish().ok().map(|short| short.bytes)
}

/// Memory that takes so many bytes and no more.
struct Short {
    bytes: Vec<u8>,
    most: usize,
}

impl Write for Short {
    fn write(&mut self, part: &[u8]) -> std::io::Result<usize> {
        if self.bytes.len() + part.len() > self.most {
            return Err(std::io::Error::other("longer than there is room for"));
        }
        self.bytes.extend_from_slice(part);
        Ok(part.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_up_is_longer_and_what_is_not_is_the_same() {
        let mut random = crate::random::Lcg(9);
        let bytes: Vec<u8> = (0..300_000).map(|_| random.below(40) as u8).collect();
        let whole = zipped(&bytes);
        assert_eq!(zipped_within(&bytes, whole.len()).as_deref(), Some(whole.as_slice()));
        assert_eq!(zipped_within(&bytes, whole.len() - 1), None);
    }

    #[test]
    fn the_finest_that_fits_is_found_whether_or_not_it_is_tried_alone() {
        let mut random = crate::random::Lcg(4);
        let noise: Vec<u8> = (0..9000).map(|_| random.below(256) as u8).collect();
        let written = |d: Detail| (d.cells, noise.iter().copied().take(d.cells as usize).collect::<Vec<u8>>());
        for room in (0..12_000).step_by(97) {
            let text = |d: &Detail| STANDARD.encode(zipped(&written(*d).1));
            let plain = PARTS.iter().position(|d| text(d).len() <= room);
            for corners in [0, 1_000_000] {
                let found = finest(&PARTS, room, corners, written);
                let at = found.map(|f| (f.detail, f.coarser.len(), f.text));
                assert_eq!(at, plain.map(|n| (PARTS[n], PARTS.len() - n - 1, text(&PARTS[n]))), "{room}");
            }
        }
    }
}
