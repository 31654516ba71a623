//! How thick the part is all over, where that was asked: quantiles and volumes between bounds.

use super::page::Context;
use crate::report::markup::{Markup, markup};
use crate::report::phrase;
use crate::report::thickness::VolumeBelow;

/// The section of local thickness; nothing where it was not mapped.
pub fn section(c: &Context) -> Markup {
    let Some(t) = &c.report.thickness else { return Markup::default() };
    let said = t.sentence().map_or(Markup::default(), |s| markup!("<p>Of the material: {}.</p>", s));
    let tables = [table("Material thinner than", &t.material_below), table("Void narrower than", &t.void_below)];
    let about = format!(
        "Thickness at a place is the diameter of the largest ball inside that covers it. Counted over {} samples {} apart; \
         the truth at every sample lies between the bounds, the maps show the middle. What may be thin holds the skin, \
         about half a sample deep, that no ball is sure to reach. Void of more than {} is open space. The map along the \
         normal is the ray's length, which other tools call thickness: on slanted and curved walls it is more than the ball.",
        phrase::thousands(t.samples),
        phrase::quantity(t.spacing_mm, "mm"),
        phrase::quantity(t.widest_gap_mm, "mm")
    );
    markup!(
        "<section aria-label=\"Local thickness\"><h2>Local thickness</h2>{}<div class=\"charts\">{}</div><p class=\"dim\">{}</p></section>\n",
        said,
        Markup::all(tables),
        about
    )
}

fn table(head: &'static str, rows: &[VolumeBelow]) -> Markup {
    let rows = Markup::all(rows.iter().map(|v| {
        markup!(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>",
            phrase::quantity(v.width_mm, "mm"),
            phrase::quantity(v.low_mm3.floor(), "mm3"),
            phrase::quantity(v.high_mm3.ceil(), "mm3")
        )
    }));
    markup!(
        "<div class=\"wide card\" tabindex=\"0\" role=\"group\" aria-label=\"{}\"><table class=\"numbers even\"><thead><tr>\
         <th scope=\"col\">{}</th><th scope=\"col\">at least</th><th scope=\"col\">at most</th></tr></thead><tbody>{}</tbody></table></div>",
        head,
        head,
        rows
    )
}
