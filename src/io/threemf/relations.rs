//! Which part of a package is its model.

use super::package::Package;
use super::xml::{Step, Xml};
use crate::error::{Error, Place, Result};

/// The type of the relationship from the package to its model.
const MODEL: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
const RELATIONS: &str = "_rels/.rels";

/// The part that the package names as its model, and its name.
///
/// # Errors
/// [`Error::Unsupported`] for a zip archive that is no 3MF package, naming the mesh in it if there is one;
/// [`Error::Damaged`] if it names none, two, or one that is not there.
pub(super) fn model_part(package: &mut Package<'_>) -> Result<(usize, String)> {
    let Some(relations) = package.find(RELATIONS) else { return Err(no_package(package)) };
    let bytes = package.read(relations)?;
    let mut targets = Vec::new();
    let mut xml = Xml::new(&bytes, RELATIONS);
    loop {
        match xml.next()? {
            Step::Open(tag) if tag.name() == b"Relationship" => {
                if xml.text(&tag, "Type")?.as_deref() == Some(MODEL) {
                    let target = xml.text(&tag, "Target")?;
                    targets.push(target.ok_or_else(|| xml.bad("a relationship without target".into()))?);
                }
            }
            Step::Open(_) | Step::Close => {}
            Step::End => break,
        }
    }
    let bad = |problem: String| Error::Damaged {
        format: "3MF",
        place: Place::Member { name: RELATIONS.into(), line: None },
        problem,
        remedy: "export the package again".into(),
    };
    match targets.as_slice() {
        [] => Err(bad("the package names no model".into())),
        [target] => {
            let found = package.find(target);
            let index =
                found.ok_or_else(|| bad(format!("the model {} is not there", crate::error::printable(target))))?;
            Ok((index, target.trim_start_matches('/').to_string()))
        }
        more => Err(bad(format!("the package names {} models", more.len()))),
    }
}

/// The error of an archive without relationships.
fn no_package(package: &Package<'_>) -> Error {
    let is_mesh = |name: &&str| [".stl", ".obj", ".ply", ".3mf"].iter().any(|s| name.to_lowercase().ends_with(s));
    let remedy = match package.names().find(is_mesh) {
        Some(name) => format!("unpack it first; it holds {}", crate::error::printable(name)),
        None => "unpack it first, or export 3MF again".into(),
    };
    Error::Unsupported { what: "a zip archive that is no 3MF package".into(), place: Place::Whole, remedy }
}
