//! Tools: the ones a user names, and the ones amcheck knows, listed and drawn.

use super::words::{MEMORY, allowance};
use crate::access::{Basis, Tool};
use crate::error::{Error, Place, Result, printable};
use crate::memory::Allowance;
use crate::process::{TOOLS, ToolChoice};
use crate::units::short;
use std::fmt::Write;
use std::path::Path;

/// Columns and lines of a drawing.
const WIDE: usize = 33;
const HIGH: usize = 24;

/// The tools that a user names: built in, a description in TOML, or a mesh whose tip is at its origin and whose axis is +z.
///
/// # Errors
/// [`Error::UnknownName`] for a name that is neither, otherwise as [`Tool::chosen`] and [`Allowance::mesh`].
pub fn chosen(names: &[String], memory: &Allowance) -> Result<Vec<ToolChoice>> {
    names.iter().map(|name| choice(name, memory)).collect()
}

fn choice(name: &str, memory: &Allowance) -> Result<ToolChoice> {
    let path = Path::new(name);
    if TOOLS.iter().any(|(n, _)| *n == name) || !(name.contains('.') || path.exists()) {
        return ToolChoice::named(name);
    }
    let stem = path.file_stem().map_or_else(|| name.to_string(), |s| s.to_string_lossy().into_owned());
    let mesh_of = |path: &Path| {
        memory.mesh(path).map(|loaded| {
            let scale = loaded.unit_mm.unwrap_or(1.0);
            if scale == 1.0 { loaded.mesh } else { loaded.mesh.scaled(scale) }
        })
    };
    let made = if name.ends_with(".toml") {
        let text = std::fs::read_to_string(path).map_err(|e| Error::Profile {
            file: printable(name),
            place: Place::Whole,
            problem: e.to_string(),
            remedy: "name a readable TOML file, a mesh, or a built-in tool: see `amcheck tools`".into(),
        })?;
        let named = text.parse::<toml::Table>().ok().and_then(|t| Some(t.get("mesh")?.as_str()?.to_string()));
        let beside = |mesh: String| path.parent().unwrap_or(Path::new("")).join(mesh);
        ToolChoice { name: stem, text, mesh: named.map(|m| mesh_of(&beside(m))).transpose()? }
    } else {
        ToolChoice { name: stem, text: String::new(), mesh: Some(mesh_of(path)?) }
    };
    Tool::chosen(&made)?;
    Ok(made)
}

/// All built-in tools in a line each, or one of them (or of a file) drawn, with its description.
///
/// # Errors
/// As [`chosen`].
pub fn list(name: Option<&str>) -> Result<String> {
    if let Some(name) = name {
        let choice = choice(name, &allowance(MEMORY)?)?;
        return Ok(format!("{}\n{}", drawn(&Tool::chosen(&choice)?), choice.text));
    }
    let mut text = String::new();
    let tools: Vec<Tool> =
        TOOLS.iter().map(|(name, _)| Tool::chosen(&ToolChoice::named(name)?)).collect::<Result<_>>()?;
    let wide = tools.iter().map(|t| t.title.chars().count()).max().unwrap_or(0) + 2;
    for ((name, _), tool) in TOOLS.iter().zip(&tools) {
        let sizes = tool.meridian().map_or(String::new(), |m| {
            let (cutter, length) = (2.0 * m.cutter_radius(), m.cutter_length());
            format!("cutter {} mm wide, {} mm long", short(cutter), short((length * 100.0).round() / 100.0))
        });
        let _ = writeln!(text, "{name:<18}{:<wide$}{sizes}", tool.title);
    }
    text.push_str(
        "\n`amcheck tools NAME` draws one and prints its description, from which one of your own can be made.\n",
    );
    Ok(text)
}

/// A section through a coaxial tool, tip below: # cutter, + neck, . holder.
fn drawn(tool: &Tool) -> String {
    let basis = match tool.basis {
        Basis::Sourced => "sourced",
        Basis::Convention => "convention",
        Basis::User => "user",
    };
    let mut text = format!("{}  {}\n[{basis}] {}\n", tool.name, tool.title, tool.source);
    let Some(m) = tool.meridian() else {
        let _ = writeln!(text, "a mesh of {} facets", tool.mesh(0.0, 3).triangles.len());
        return text;
    };
    let (top, half) = (m.length(), m.widest());
    // Characters are about twice as high as wide.
    let step = (top / HIGH as f64).max(4.0 * half / WIDE as f64);
    for line in (0..(top / step).ceil().max(1.0) as usize).rev() {
        let z = (line as f64 + 0.5) * step;
        let radius = m.largest_within(z - 0.5 * step, z + 0.5 * step).unwrap_or(0.0);
        let across = ((radius * WIDE as f64 / (2.0 * half)).round() as usize).clamp(0, WIDE / 2);
        let mark = match m.role_at(z.min(top - 1e-9)).word() {
            "cutter" => "#",
            "neck" => "+",
            _ => ".",
        };
        let row = format!("{}{}", " ".repeat(WIDE / 2 - across), mark.repeat(2 * across + 1));
        let _ = writeln!(
            text,
            "{:>8} mm  {row:<WIDE$}  {} mm",
            short((z * 10.0).round() / 10.0),
            short((20.0 * radius).round() / 10.0)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tool_is_listed_and_can_be_drawn() {
        let text = list(None).unwrap();
        for (name, described) in TOOLS {
            assert!(text.contains(name));
            let drawn = list(Some(name)).unwrap();
            assert!(drawn.contains('#') && drawn.contains('.') && drawn.contains("[convention]"), "{drawn}");
            assert!(drawn.contains(described));
        }
        assert!(list(Some("end-mil-6")).unwrap_err().remedy().contains("end-mill-6"));
        assert!(chosen(&["none.toml".into()], &allowance(MEMORY).unwrap()).is_err());
    }
}
