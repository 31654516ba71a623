//! The 3-D view: a compressed program and a compressed part inside the page, and nothing where they would be too long.

use super::page::Context;
use crate::report::glb::{self, Detail};
use crate::report::markup::{Markup, markup};
use crate::report::phrase;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, GzBuilder};
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

/// How fine the part and its layers may be shown, finest first; layers give way before the part does.
const DETAILS: [[Detail; 2]; 8] = [
    [Detail::FULL, Detail::FULL],
    [Detail::FULL, Detail { cells: 512, codes: 64 }],
    [Detail::FULL, Detail { cells: 128, codes: 64 }],
    [Detail { cells: 2048, codes: 255 }, Detail { cells: 128, codes: 64 }],
    [Detail { cells: 512, codes: 128 }, Detail { cells: 128, codes: 64 }],
    [Detail { cells: 256, codes: 64 }, Detail { cells: 96, codes: 64 }],
    [Detail { cells: 128, codes: 64 }, Detail { cells: 64, codes: 64 }],
    [Detail { cells: 64, codes: 32 }, Detail { cells: 48, codes: 32 }],
];

/// Program and part as text for `page.js`, as fine as fits into `room` bytes; a coarser copy is said.
pub fn data(c: &Context, room: usize) -> Markup {
    if c.exhibit.corners.is_empty() {
        return Markup::default();
    }
    let program = STANDARD.encode(PROGRAM);
    let most = room.saturating_sub(program.len() + AROUND).max(LEAST);
    let layered = !c.exhibit.layers.is_empty();
    let fits = |[detail, layers]: &[Detail; 2]| {
        let part = STANDARD.encode(zipped(&glb::write_at(c.exhibit, *detail, *layers)));
        (part.len() <= most).then_some((*detail, part))
    };
    // Without layers the steps that only coarsen them say nothing else.
    let tried = DETAILS.iter().enumerate().filter(|(i, _)| layered || !(1..=2).contains(i)).map(|(_, d)| d);
    let Some((detail, part)) = tried.into_iter().find_map(fits) else {
        return Markup::raw(
            "<p class=\"note\">The part is too large for a 3-D view in this page; the pictures show it.</p>\n",
        );
    };
    let said = if detail == Detail::FULL {
        Markup::default()
    } else {
        let longest = (0..3).map(|a| c.report.part.box_mm[1][a] - c.report.part.box_mm[0][a]).fold(0.0, f64::max);
        let step = longest / f64::from(detail.cells);
        markup!(
            "<p class=\"note\">The 3-D view shows a coarser copy in steps of {}, so that the page stays small; all numbers and \
             pictures come from the whole part.</p>\n",
            phrase::quantity((step * 1000.0).ceil() / 1000.0, "mm")
        )
    };
    markup!(
        "{}<script type=\"text/plain\" id=\"viewer-part\">{}</script>\n<script type=\"text/plain\" id=\"viewer-program\">{}</script>\n",
        said,
        Markup::made(part),
        Markup::made(program)
    )
}

/// Bytes as a gzip file without time or name.
pub fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut to = GzBuilder::new().mtime(0).write(Vec::new(), Compression::new(6));
    // Writing to memory cannot fail.
    let _ = to.write_all(bytes);
    to.finish().unwrap_or_default()
}
