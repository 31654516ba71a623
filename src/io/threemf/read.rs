//! Reading 3MF.

use super::model::extension_name;
use super::{assemble, package, scene, settings};
use crate::error::{Error, Result, printable};
use crate::io::{Loaded, accept};
use crate::notice::{Notice, number_of};

/// The mesh of a 3MF package: all build items under their transforms, in the units of the root model.
///
/// Each object is welded by itself; instances keep their vertices apart, so that bodies which touch stay
/// bodies. A mirroring transform turns the facets round. Support and other objects, items marked as not
/// printable, and modifiers, support blockers, enforcers and meshes by the settings of Bambu Studio, OrcaSlicer,
/// PrusaSlicer and Cura are left out and said.
///
/// # Errors
/// [`Error::Damaged`] with part and line; [`Error::Unsupported`] naming a required extension, encryption, a volume
/// that a slicer takes out of the part, or a zip archive that is no package; [`Error::TooLarge`] for packages that
/// inflate beyond 2 GiB or by more than 200 times, for parts that overlap and for instances without end;
/// [`Error::NoGeometry`] for nothing to build.
///
/// # Limits
/// Core specification and production extension: what any other adds to geometry is refused if required, noticed if not.
pub fn read(bytes: &[u8]) -> Result<Loaded> {
    let mut package = package::Package::open(bytes)?;
    let scene = scene::read(&mut package)?;
    if scene.items.is_empty() {
        return Err(Error::NoGeometry {
            problem: format!(
                "the 3MF package builds nothing; it holds {}",
                number_of(scene.nodes.len() as u64, ["object", "objects"])
            ),
            remedy: "put the part on the plate and export again".into(),
        });
    }
    let settings = settings::read(&mut package);
    let mut notices = noticed(&scene, &settings);
    let unit_mm = Some(scene.unit_mm);
    let mesh = assemble::assemble(scene, &settings, &mut notices)?;
    let mesh = accept::with_extent(mesh, "3MF")?;
    // The text may hold any number of digits; nearly all writers print f32.
    Ok(Loaded { mesh, format: "3MF", unit_mm, notices, relative_step: f64::powi(2.0, -24) })
}

/// What was passed over, and what is judged together.
fn noticed(scene: &scene::Scene, settings: &settings::Settings) -> Vec<Notice> {
    let foreign = scene.foreign.iter().map(|namespace| {
        let name = printable(extension_name(namespace));
        Notice::new("extension-ignored", format!("elements of the 3MF extension {name} were left out"))
    });
    let unread = settings.unread.iter().map(|why| {
        let message = format!(
            "a slicer's settings were not read to their end, and what is no material to them was read as such: {why}"
        );
        Notice::new("modifier-volumes", message)
    });
    let mut notices: Vec<Notice> = foreign.chain(unread).collect();
    if scene.unprinted > 0 {
        let words =
            ["build item marked as not printable was left out", "build items marked as not printable were left out"];
        let message = number_of(scene.unprinted, words);
        notices.push(Notice::new("objects-excluded", message).counted(scene.unprinted));
    }
    if settings.plates > 1 {
        let message = format!("{} plates were read as one part, as they lie side by side", settings.plates);
        notices.push(Notice::new("several-plates", message).counted(settings.plates));
    }
    notices
}
