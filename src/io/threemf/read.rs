//! Reading 3MF.

use super::model::extension_name;
use super::{assemble, model, package, relations};
use crate::error::{Error, Result, printable};
use crate::io::{Loaded, accept, sniff};
use crate::notice::Notice;

/// Settings of one slicer in which volumes of a mesh may be declared to be no material.
const MODIFIERS: &str = "Metadata/Slic3r_PE_model.config";
/// Settings longer than this are not searched.
const LONGEST_SETTINGS: usize = 8 << 20;

/// The mesh of a 3MF package: all build items under their transforms, in file units.
///
/// Each object is welded by itself; instances keep their vertices apart, so that bodies which touch stay
/// bodies. A mirroring transform turns the facets round. Support and other objects, and items marked as not
/// printable, are left out and said.
///
/// # Errors
/// [`Error::Damaged`] with part and line; [`Error::Unsupported`] naming a required extension, encryption, or
/// a zip archive that is no package; [`Error::TooLarge`] for parts that inflate beyond 2 GiB or by more than 200
/// times, for parts that overlap and for instances without end; [`Error::NoGeometry`] for nothing to build.
///
/// # Limits
/// Core specification only: what an extension adds to geometry is refused if required, noticed if not.
pub fn read(bytes: &[u8]) -> Result<Loaded> {
    let mut package = package::Package::open(bytes)?;
    let (index, part) = relations::model_part(&mut package)?;
    let mut text = package.read(index)?;
    if text.starts_with(b"\xff\xfe") || text.starts_with(b"\xfe\xff") {
        text = sniff::decode_utf16(&text).into_bytes();
    }
    let model = model::read(&text, &part)?;
    drop(text);
    if model.items.is_empty() {
        return Err(Error::NoGeometry {
            problem: format!("the 3MF package builds nothing; it holds {} objects", model.objects.len()),
            remedy: "put the part on the plate and export again".into(),
        });
    }
    let mut notices: Vec<Notice> = model
        .foreign
        .iter()
        .map(|namespace| {
            let name = printable(extension_name(namespace));
            Notice::new("extension-ignored", format!("elements of the 3MF extension {name} were left out"))
        })
        .collect();
    if model.unprinted > 0 {
        let message = format!("{} build items marked as not printable were left out", model.unprinted);
        notices.push(Notice::new("objects-excluded", message).counted(model.unprinted));
    }
    notices.extend(modifier_volumes(&mut package));
    let mesh = assemble::assemble(&model, &part, &mut notices)?;
    let mesh = accept::with_extent(mesh, "3MF")?;
    // The text may hold any number of digits; nearly all writers print f32.
    Ok(Loaded { mesh, format: "3MF", unit_mm: Some(model.unit_mm), notices, relative_step: f64::powi(2.0, -24) })
}

/// A notice if a slicer's settings declare parts of a mesh as modifiers: they are read as material here.
fn modifier_volumes(package: &mut package::Package<'_>) -> Option<Notice> {
    let settings = package.read(package.find(MODIFIERS)?).ok().filter(|s| s.len() <= LONGEST_SETTINGS)?;
    let text = String::from_utf8_lossy(&settings);
    let kinds = ["ParameterModifier", "NegativeVolume", "SupportBlocker", "SupportEnforcer"];
    kinds.iter().any(|k| text.contains(k)).then(|| {
        Notice::new("modifier-volumes", "the package holds a slicer's modifier volumes, which were read as material")
    })
}
