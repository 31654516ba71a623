//! The 3-D view: a compressed program and a compressed part inside the page, and nothing where they would be too long.

use super::Context;
use crate::report::glb;
use crate::report::markup::{Markup, markup};
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

/// Program and part as text for `page.js`; nothing without a part, a sentence where the part is too large.
pub fn data(c: &Context) -> Markup {
    if c.exhibit.corners.is_empty() {
        return Markup::default();
    }
    let part = STANDARD.encode(zipped(&glb::write(c.exhibit)));
    if part.len() > MOST {
        return markup!(
            "<p class=\"note\" id=\"viewer-none\">The part is too large for a 3-D view in this page ({} bytes compressed); the pictures show it.</p>\n",
            part.len()
        );
    }
    let program = STANDARD.encode(PROGRAM);
    markup!(
        "<script type=\"text/plain\" id=\"viewer-part\">{}</script>\n<script type=\"text/plain\" id=\"viewer-program\">{}</script>\n",
        Markup::made(part),
        Markup::made(program)
    )
}

/// Bytes as a gzip file without time or name.
fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut to = GzBuilder::new().mtime(0).write(Vec::new(), Compression::new(6));
    // Writing to memory cannot fail.
    let _ = to.write_all(bytes);
    to.finish().unwrap_or_default()
}
