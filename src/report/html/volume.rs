//! Slices anywhere: the part's density inside the page, drawn on three canvases when somebody asks.

use super::page::Context;
use super::viewer;
use crate::report::exhibit::Volume;
use crate::report::markup::{Markup, markup};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

/// Most characters that the volume may add to the page.
const MOST: usize = 500_000;

/// The panel with its three sliders and its data; nothing without a volume or where it would be too long.
///
/// Without script it stays hidden: the slices through the worst finding are pictures.
pub fn panel(c: &Context) -> Markup {
    let Some(data) = c.exhibit.volume.as_ref().filter(|v| v.density.len() == v.grid.samples()).map(packed) else {
        return Markup::default();
    };
    if data.len() > MOST {
        return Markup::raw("<p class=\"note\">The part is too large for slices at any place in this page.</p>");
    }
    let figures = Markup::all(["x", "y", "z"].into_iter().enumerate().map(|(axis, name)| {
        let across = ["y right, z up", "x right, z up", "x right, y up"][axis];
        markup!(
            "<figure><canvas data-axis=\"{}\" role=\"img\" aria-label=\"Slice across {}, {}\"></canvas><label>{} <input type=\"range\" data-axis=\"{}\"> \
             <output></output></label></figure>",
            axis,
            name,
            across,
            name,
            axis
        )
    }));
    markup!(
        "<details class=\"fold\" id=\"volume\" hidden><summary>Slices anywhere</summary><div class=\"slices\">{}</div></details>\n\
         <script type=\"text/plain\" id=\"volume-data\" data-grid=\"{}\">{}</script>\n",
        figures,
        described(c),
        Markup::made(data)
    )
}

/// Grid of the volume and the pins, in the frame of the build.
fn described(c: &Context) -> String {
    let Some(v) = &c.exhibit.volume else { return String::new() };
    let pins: Vec<_> = c
        .findings
        .iter()
        .take(200)
        .map(|n| json!({"number": n.number, "state": n.finding.state.word(), "at": c.report.part.posed(n.finding.at_mm)}))
        .collect();
    json!({"origin": v.grid.origin(), "spacing": v.grid.h(), "dims": v.grid.dims(), "pins": pins}).to_string()
}

/// Differences along x, which are mostly zero, as gzip in base64.
fn packed(v: &Volume) -> String {
    let mut last = 0u8;
    let differences: Vec<u8> = v.density.iter().map(|&d| d.wrapping_sub(std::mem::replace(&mut last, d))).collect();
    STANDARD.encode(viewer::zipped(&differences))
}
