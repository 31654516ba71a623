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
    let packed =
        |part: Detail, layers: Option<Detail>| STANDARD.encode(zipped(&glb::write_at(c.exhibit, part, layers)));
    let layered = !c.exhibit.layers.is_empty();
    let own = if layered { (OWN * most as f64) as usize } else { most };
    let mut alone: Option<Fitted> = None;
    let mut parts = PARTS.as_slice();
    while let Some((part, text, coarser)) = finest(parts, own, |part| packed(part, None)) {
        let known = alone.get_or_insert(Fitted { text, part, layers: None });
        if !layered {
            break;
        }
        // Layers that did not fit at their coarsest beside a part are tried again beside a coarser one.
        if let Some((layers, text, _)) = finest(&LAYERS, most, |layers| packed(part, Some(layers))) {
            *known = Fitted { text, part, layers: Some(layers) };
            break;
        }
        parts = coarser;
    }
    alone
}

/// The first of a list, finest first, that packs into `room` bytes, with its text and what is coarser. The finest mostly fits and is
/// tried alone, the others two by two.
fn finest(
    list: &[Detail],
    room: usize,
    packed: impl Fn(Detail) -> String + Sync,
) -> Option<(Detail, String, &[Detail])> {
    let (first, rest) = list.split_at(list.len().min(1));
    for (n, pair) in std::iter::once(first).chain(rest.chunks(2)).enumerate() {
        let texts: Vec<String> = pair.par_iter().map(|&detail| packed(detail)).collect();
        let fits = texts.into_iter().zip(pair).enumerate().find(|(_, (text, _))| text.len() <= room);
        if let Some((k, (text, &detail))) = fits {
            let before = if n == 0 { 0 } else { 2 * n - 1 };
            return Some((detail, text, list.get(before + k + 1..).unwrap_or_default()));
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
    let part = (fitted.part != Detail::FULL).then(|| format!("a coarser copy in steps of {}", step(fitted.part)));
    let layers = match fitted.layers {
        None if c.exhibit.layers.is_empty() => None,
        None => Some("no layers, for which there is no room".to_string()),
        Some(Detail::FULL) => None,
        Some(d) => Some(format!("its layers in steps of {}", step(d))),
    };
    let said: Vec<String> = [part, layers].into_iter().flatten().collect();
    if said.is_empty() {
        return Markup::default();
    }
    markup!(
        "<p class=\"note\">The 3-D view shows {}, so that the page stays small; all numbers and pictures come from the whole part.</p>\n",
        said.join(", and ")
    )
}

/// Bytes as a gzip file without time or name.
pub fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut to = GzBuilder::new().mtime(0).write(Vec::new(), Compression::new(6));
    // Writing to memory cannot fail.
    let _ = to.write_all(bytes);
    to.finish().unwrap_or_default()
}
