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

/// Most bytes that the compressed part may add to the page, so that the whole stays under 2 MB.
const MOST: usize = 1_200_000;

/// The place of the view on the stage.
pub fn place() -> Markup {
    Markup::raw("<div id=\"viewer\" hidden></div><p class=\"note\" id=\"viewer-note\" hidden></p>")
}

/// How fine the part may be shown, finest first.
const DETAILS: [Detail; 6] = [
    Detail::FULL,
    Detail { cells: 2048, codes: 255 },
    Detail { cells: 512, codes: 128 },
    Detail { cells: 256, codes: 64 },
    Detail { cells: 128, codes: 64 },
    Detail { cells: 64, codes: 32 },
];

/// Program and part as text for `page.js`, as fine as the page has room for; a coarser copy is said.
pub fn data(c: &Context) -> Markup {
    if c.exhibit.corners.is_empty() {
        return Markup::default();
    }
    let fits = |detail: &Detail| {
        let part = STANDARD.encode(zipped(&glb::write_at(c.exhibit, *detail)));
        (part.len() <= MOST).then_some((*detail, part))
    };
    let Some((detail, part)) = DETAILS.iter().find_map(fits) else {
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
        Markup::made(STANDARD.encode(PROGRAM))
    )
}

/// Bytes as a gzip file without time or name.
pub fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut to = GzBuilder::new().mtime(0).write(Vec::new(), Compression::new(6));
    // Writing to memory cannot fail.
    let _ = to.write_all(bytes);
    to.finish().unwrap_or_default()
}
