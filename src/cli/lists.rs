//! What amcheck knows, as text: checks, errors, processes.

use crate::check::registry;
use crate::error::{Error, Result};
use crate::process::{BUILTIN, LimitBasis, Process, ToolChoice, rule};
use crate::units::short;
use std::fmt::Write;

/// Meaning of every error code, and what to do about it.
const ERRORS: &[(&str, &str)] = &[
    ("E001", "An option or argument makes no sense as given. Exit code 2."),
    ("E002", "A name is not in the list it should be in; the nearest one is suggested. Exit code 2."),
    ("E003", "A process or tool file cannot be used: bad TOML, an unknown key, a value out of range. Exit code 2."),
    (
        "E004",
        "A tool cannot be used: no cutter, a holder inside the cutter, a cutter larger than the part, an open mesh, or no \
              direction to come from. Exit code 2.",
    ),
    ("E010", "The file could not be opened or read. Exit code 4."),
    (
        "E011",
        "The file breaks the rules of its format; the message names the byte, line or facet. --salvage reads what is whole of a \
              damaged binary STL. Exit code 4.",
    ),
    (
        "E012",
        "The file asks for something that amcheck does not read: another format, an extension that a 3MF package requires, \
              or a negative volume, which a slicer takes out of the part. Exit code 4.",
    ),
    (
        "E013",
        "There is no shape: the file holds no triangles or they have no extent, or nothing remains of a part after an offset, an \
              opening or a difference, or nothing that the spacing shows, or the element fits into it nowhere. Exit code 4.",
    ),
    (
        "E014",
        "The surface is not a solid. A part that is judged encloses nothing: beside too little of it winding numbers are those of a solid; or it is closed and \
              holds no volume. A shape is made only from a closed surface: no edge may be open, as around one missing facet, and neighbouring facets face \
              the same side. Close the holes and turn the facets first; what --repair can do of that, it says. Exit code 4.",
    ),
    ("E020", "The question needs more memory than allowed; the message says how much, and what fits. Exit code 5."),
    ("E030", "A result could not be written; what was there before is untouched. Exit code 6."),
    ("E040", "A floating-point count was too uncertain to be rounded to an integer. Exit code 70."),
    ("E041", "The operands of a field operation do not fit together. Exit code 2."),
    ("E050", "The run was stopped. Exit code 130."),
    ("E070", "amcheck broke one of its own promises; please report it. Exit code 70."),
];

/// The text of a check or an error code.
///
/// # Errors
/// [`Error::UnknownName`] with the nearest name.
pub fn explain(name: &str) -> Result<(String, u8)> {
    if let Some((code, text)) = ERRORS.iter().find(|(code, _)| code.eq_ignore_ascii_case(name.trim())) {
        return Ok((format!("{code}\n\n{}\n", wrapped(text, 0)), 0));
    }
    let known: Vec<&str> = registry::metas().flat_map(|m| [m.name, m.code]).chain(ERRORS.iter().map(|e| e.0)).collect();
    let check = registry::find(name).map_err(|_| Error::UnknownName {
        what: "check or error code",
        given: crate::error::printable(name),
        nearest: crate::error::nearest(name, known.iter().copied()),
        known: registry::metas().map(|m| m.name.to_string()).collect(),
    })?;
    let m = check.meta();
    let mut text = format!("{} {}\n{}\n", m.code, m.name, m.title);
    for (head, body) in [("What", m.what), ("Why", m.why), ("How", m.how), ("Limits", m.limits), ("Source", m.source)] {
        let _ = write!(text, "\n{head}\n{}\n", wrapped(body, 2));
    }
    let mut limits = String::new();
    for (process, _) in BUILTIN {
        for (key, l) in Process::named(process)?
            .limits
            .iter()
            .filter(|(k, _)| *k == m.name || k.starts_with(&format!("{}.", m.name)))
        {
            let unit = rule(key)?.dimension.unit();
            let number = |x: Option<f64>| x.map_or("-".to_string(), |x| format!("{} {unit}", short(x)));
            let kind = if l.basis == LimitBasis::Convention { " (convention)" } else { "" };
            let _ = writeln!(
                limits,
                "  {process:<11}{key:<28} fail {:<9} warn {:<9}{kind}",
                number(l.fail),
                number(l.warn)
            );
        }
    }
    if !limits.is_empty() {
        let _ = write!(text, "\nLimits by process\n{limits}");
    }
    Ok((text, 0))
}

/// All built-in processes with their limits and sources.
pub fn processes() -> String {
    let mut text = String::new();
    for process in BUILTIN.iter().filter_map(|(name, _)| Process::named(name).ok()) {
        let [x, y, z] = process.build_volume_mm.map(short);
        let _ = writeln!(text, "{}  {}", process.name, process.title);
        let _ = writeln!(
            text,
            "  build volume {x} × {y} × {z} mm, layer {} mm, {} {} mm",
            short(process.layer_height_mm),
            process.element.kind,
            short(process.element.width_mm)
        );
        let names = |list: &[ToolChoice]| list.iter().map(|t| t.name.as_str()).collect::<Vec<_>>().join(", ");
        for (work, list) in [("supports", &process.tools.removal), ("surfaces", &process.tools.finishing)] {
            if !list.is_empty() {
                let _ = writeln!(text, "  tools for {work}: {}", names(list));
            }
        }
        for (key, limit) in &process.limits {
            let unit = rule(key).map_or("", |r| r.dimension.unit());
            let number =
                |word: &str, x: Option<f64>| x.map_or(String::new(), |x| format!("{word} {} {unit}  ", short(x)));
            let _ = writeln!(
                text,
                "  {key:<27} {}{}[{}]",
                number("fail", limit.fail),
                number("warn", limit.warn),
                limit.basis.word()
            );
            let _ = writeln!(text, "{}", wrapped(&limit.source, 6));
        }
        text.push('\n');
    }
    text.push_str("A profile of your own starts with `inherits = \"fdm\"` and overrides what differs.\n");
    text
}

/// Text broken at 96 columns behind an indent.
fn wrapped(text: &str, indent: usize) -> String {
    let mut out = String::new();
    let mut width = 0;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if width > 0 && indent + width + 1 + length > 96 {
            out.push('\n');
            width = 0;
        }
        if width == 0 {
            out.push_str(&" ".repeat(indent));
        } else {
            out.push(' ');
            width += 1;
        }
        out.push_str(word);
        width += length;
    }
    out
}
