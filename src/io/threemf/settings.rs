//! What the settings of slicers inside a package declare of volumes and plates.

use super::package::Package;
use super::role::Role;
use super::xml::{Step, Tag, Xml};
use crate::error::{Error, Result, printable};

/// Where Bambu Studio and OrcaSlicer say what each component of an object is.
const PARTS: &str = "Metadata/model_settings.config";
/// Where PrusaSlicer and its relatives say what each run of an object's facets is.
const RUNS: &str = "Metadata/Slic3r_PE_model.config";
/// Settings longer than this are not read.
const LONGEST: u64 = 64 << 20;

/// Which mesh a volume is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mesh {
    /// The object of this number among the components.
    Object(u32),
    /// From the first to the last facet, both counted from 0.
    Facets(u32, u32),
    Unknown,
}

/// A volume as the settings declare it.
#[derive(Debug)]
pub(super) struct Volume {
    /// The number of the object that it belongs to.
    pub(super) object: Option<u32>,
    pub(super) mesh: Mesh,
    pub(super) role: Role,
    pub(super) name: String,
    pub(super) file: &'static str,
    pub(super) line: u64,
}

/// All that the settings declare.
#[derive(Debug, Default)]
pub(super) struct Settings {
    pub(super) volumes: Vec<Volume>,
    /// Plates with anything on them.
    pub(super) plates: u64,
    /// Files that could not be read, and why.
    pub(super) unread: Vec<String>,
}

/// Reads what is there; what cannot be read is listed as such.
pub(super) fn read(package: &mut Package<'_>) -> Settings {
    let mut settings = Settings::default();
    for file in [PARTS, RUNS] {
        if let Some(index) = package.find(file) {
            let done = bytes(package, index).and_then(|bytes| settings.take_in(&bytes, file));
            settings.unread.extend(done.err().map(|e| format!("{}: {e}", e.place().unwrap_or(file.into()))));
        }
    }
    settings
}

fn bytes(package: &mut Package<'_>, index: usize) -> Result<Vec<u8>> {
    let need = package.size(index);
    if need <= LONGEST {
        return package.read(index);
    }
    Err(Error::TooLarge {
        what: "reading a slicer's settings".into(),
        need_bytes: need.into(),
        allowed_bytes: LONGEST.into(),
        remedy: "export the part as a plain mesh: 3MF core, or STL".into(),
    })
}

/// Where in the tree the cursor is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum At {
    Root,
    Config,
    Object,
    Volume,
    Plate,
    Elsewhere,
}

impl Settings {
    fn take_in(&mut self, bytes: &[u8], file: &'static str) -> Result<()> {
        let mut xml = Xml::new(bytes, file);
        let mut stack = vec![At::Root];
        let mut object = None;
        let mut counted = 0;
        loop {
            match xml.next()? {
                Step::Open(tag) => {
                    let here = stack.last().copied().unwrap_or(At::Elsewhere);
                    stack.push(match (here, tag.name()) {
                        (At::Root, _) => At::Config,
                        (At::Config, b"object") => {
                            object = number(&xml, &tag, "id")?;
                            At::Object
                        }
                        (At::Config, b"plate") => {
                            counted = self.plates + 1;
                            At::Plate
                        }
                        (At::Plate, b"model_instance") => {
                            self.plates = counted;
                            At::Elsewhere
                        }
                        (At::Object, b"part" | b"volume") => {
                            self.volumes.push(volume(&xml, &tag, object, file)?);
                            At::Volume
                        }
                        (At::Volume, b"metadata") => self.metadata(&xml, &tag).map(|()| At::Elsewhere)?,
                        _ => At::Elsewhere,
                    });
                }
                Step::Close => {
                    stack.pop();
                }
                Step::End => return Ok(()),
            }
        }
    }

    /// Name and kind of the last volume. The kind stands in a key of its own, which goes before the older mark of a modifier.
    fn metadata(&mut self, xml: &Xml<'_>, tag: &Tag<'_>) -> Result<()> {
        let (Some(key), Some(value)) = (xml.text(tag, "key")?, xml.text(tag, "value")?) else { return Ok(()) };
        let Some(volume) = self.volumes.last_mut() else { return Ok(()) };
        match key.as_str() {
            "name" => volume.name = printable(&value),
            "volume_type" | "part_type" => volume.role = Role::named(&value),
            "modifier" if value == "1" && volume.role == Role::Material => volume.role = Role::Modifier,
            _ => {}
        }
        Ok(())
    }
}

fn volume(xml: &Xml<'_>, tag: &Tag<'_>, object: Option<u32>, file: &'static str) -> Result<Volume> {
    let facets = (number(xml, tag, "firstid")?, number(xml, tag, "lastid")?);
    let mesh = match (number(xml, tag, "id")?, facets) {
        (_, (Some(first), Some(last))) if file == RUNS => Mesh::Facets(first, last),
        (Some(id), _) if file == PARTS => Mesh::Object(id),
        _ => Mesh::Unknown,
    };
    let role = Role::named(&xml.text(tag, "subtype")?.unwrap_or_default());
    Ok(Volume { object, mesh, role, name: String::new(), file, line: xml.line() })
}

/// A whole number, if there is one; slicers write −1 for none.
fn number(xml: &Xml<'_>, tag: &Tag<'_>, name: &str) -> Result<Option<u32>> {
    Ok(xml.text(tag, name)?.and_then(|text| text.trim().parse().ok()))
}

impl Volume {
    /// The volume for people: its name, and where it stands.
    pub(super) fn told(&self) -> String {
        let of = self.object.map_or_else(String::new, |id| format!(" of object {id}"));
        let place = match self.mesh {
            Mesh::Object(id) => format!("part {id}{of}"),
            Mesh::Facets(first, last) => format!("facets {first} to {last}{of}"),
            Mesh::Unknown => format!("a part{of}"),
        };
        if self.name.is_empty() { place } else { format!("`{}`, {place}", self.name) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, file: &'static str) -> Settings {
        let mut settings = Settings::default();
        settings.take_in(text.as_bytes(), file).unwrap();
        settings
    }

    #[test]
    fn parts_are_what_subtype_and_the_keys_say() {
        let found = read(
            r#"<?xml version="1.0"?><config><object id="3"><metadata key="name" value="all"/>
               <part id="1" subtype="normal_part"><metadata key="name" value="a"/><metadata key="modifier" value="0"/></part>
               <part id="2" subtype="negative_part"/><part id="-1" subtype="support_enforcer"/>
               <part id="4"><metadata key="volume_type" value="support_blocker"/></part></object>
               <plate><metadata key="plater_id" value="1"/><model_instance/></plate><plate/><plate><model_instance/><model_instance/></plate>
               </config>"#,
            PARTS,
        );
        let all: Vec<_> = found.volumes.iter().map(|v| (v.object, v.mesh, v.role)).collect();
        assert_eq!(
            all,
            [
                (Some(3), Mesh::Object(1), Role::Material),
                (Some(3), Mesh::Object(2), Role::Negative),
                (Some(3), Mesh::Unknown, Role::SupportEnforcer),
                (Some(3), Mesh::Object(4), Role::SupportBlocker),
            ]
        );
        assert_eq!((found.volumes[0].told().as_str(), found.volumes[1].line), ("`a`, part 1 of object 3", 3));
        assert_eq!(found.plates, 2);
    }

    #[test]
    fn runs_of_facets_know_the_older_mark_of_a_modifier() {
        let run = |key: &str, value: &str| {
            format!(r#"<volume firstid="0" lastid="9"><metadata type="volume" key="{key}" value="{value}"/></volume>"#)
        };
        let text = format!("<config><object id=\"1\">{}{}", run("modifier", "1"), run("volume_type", "NegativeVolume"));
        let found = read(&(text + "<volume lastid=\"9\"/></object></config>"), RUNS);
        let all: Vec<_> = found.volumes.iter().map(|v| (v.mesh, v.role)).collect();
        let run = Mesh::Facets(0, 9);
        assert_eq!(all, [(run, Role::Modifier), (run, Role::Negative), (Mesh::Unknown, Role::Material)]);
    }

    #[test]
    fn what_is_no_xml_is_said() {
        let error = Settings::default().take_in(b"<config><object></config>", PARTS).unwrap_err();
        assert!(error.place().unwrap().starts_with(PARTS), "{error:?}");
    }
}
