//! A model part: objects and what is built of them.

use super::cura::{CURA, Cura};
use super::transform::Transform;
use super::xml::{Step, Tag, Xml};
use crate::error::{Error, Place, Result, printable};
use crate::geometry::vector::Vec3;
use crate::io::accept;
use std::collections::BTreeSet;

pub(super) const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";

/// The extension by which the root model names objects of other model parts.
const PRODUCTION: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";

/// Namespaces that are read or change no geometry: required or not, they stand in nobody's way.
const HARMLESS: [&str; 6] = [
    PRODUCTION,
    CURA,
    "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
    "http://schemas.openxmlformats.org/markup-compatibility/2006",
];

/// What an object is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Model,
    Other,
}

/// Where a model part stands in the package.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Standing {
    /// The package names it: what it builds is the part.
    Root,
    /// The root names it: its objects alone matter.
    Named,
}

/// A reference to an object under a transform.
#[derive(Debug, Clone)]
pub(super) struct Instance {
    /// The model part of the object, if it is another.
    pub(super) path: Option<String>,
    pub(super) object: u32,
    pub(super) transform: Transform,
    pub(super) line: u64,
}

/// A mesh, or an assembly of other objects.
#[derive(Debug)]
pub(super) struct Object {
    pub(super) id: u32,
    pub(super) name: String,
    pub(super) purpose: Purpose,
    pub(super) cura: Cura,
    pub(super) line: u64,
    pub(super) vertices: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) components: Vec<Instance>,
}

/// A model part.
#[derive(Debug)]
pub(super) struct Model {
    /// Millimetres per unit.
    pub(super) unit_mm: f64,
    pub(super) objects: Vec<Object>,
    pub(super) items: Vec<Instance>,
    /// Items that are marked as not to be printed.
    pub(super) unprinted: u64,
    /// Namespaces of elements inside objects that were passed over.
    pub(super) foreign: BTreeSet<String>,
}

/// Where in the tree the cursor is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum At {
    Root,
    Model,
    Resources,
    Object,
    Mesh,
    Vertices,
    Triangles,
    Components,
    Metadata,
    Build,
    Elsewhere,
}

/// What is known of a part while it is read.
struct Reading<'a> {
    part: &'a str,
    standing: Standing,
    ids: BTreeSet<u32>,
}

/// Reads a model part.
///
/// # Errors
/// [`Error::Damaged`] with part and line; [`Error::Unsupported`] naming a required extension.
pub(super) fn read(bytes: &[u8], part: &str, standing: Standing) -> Result<Model> {
    let mut model =
        Model { unit_mm: 1.0, objects: Vec::new(), items: Vec::new(), unprinted: 0, foreign: BTreeSet::new() };
    let mut xml = Xml::new(bytes, part);
    let mut reading = Reading { part, standing, ids: BTreeSet::new() };
    let mut stack = vec![At::Root];
    loop {
        match xml.next()? {
            Step::Open(tag) => {
                let here = stack.last().copied().unwrap_or(At::Elsewhere);
                stack.push(model.open(&xml, here, &tag, &mut reading)?);
            }
            Step::Close => {
                stack.pop();
            }
            Step::End => break,
        }
    }
    Ok(model)
}

impl Model {
    /// Takes in one opening tag; where its children are.
    fn open(&mut self, xml: &Xml<'_>, here: At, tag: &Tag<'_>, reading: &mut Reading<'_>) -> Result<At> {
        if here == At::Root {
            if tag.namespace != CORE || tag.name() != b"model" {
                return Err(xml.bad("the part is no 3MF model".into()));
            }
            return self.root(xml, tag, reading.part).map(|()| At::Model);
        }
        if tag.namespace == CURA && matches!((here, tag.name()), (At::Object, b"settings") | (At::Metadata, b"setting"))
        {
            return self.metadata(xml, tag, "key").map(|()| At::Metadata);
        }
        if tag.namespace != CORE {
            if !HARMLESS.contains(&tag.namespace.as_ref()) && matches!(here, At::Object | At::Mesh | At::Triangles) {
                self.foreign.insert(tag.namespace.to_string());
            }
            return Ok(At::Elsewhere);
        }
        Ok(match (here, tag.name()) {
            (At::Model, b"resources") => At::Resources,
            (At::Model, b"build") if reading.standing == Standing::Root => At::Build,
            (At::Resources, b"object") => {
                let id = claimed_id(xml, tag, &mut reading.ids)?;
                self.object(xml, tag, id)?;
                At::Object
            }
            (At::Resources, _) => claimed_id(xml, tag, &mut reading.ids).map(|_| At::Elsewhere)?,
            (At::Build, b"item") => {
                if xml.text(tag, "printable")?.as_deref() == Some("0") {
                    self.unprinted += 1;
                } else {
                    self.items.push(instance(xml, tag, reading.standing)?);
                }
                At::Elsewhere
            }
            _ => self.open_in_object(xml, here, tag, reading.standing)?,
        })
    }

    /// Takes in one opening tag inside an object.
    fn open_in_object(&mut self, xml: &Xml<'_>, here: At, tag: &Tag<'_>, standing: Standing) -> Result<At> {
        Ok(match (here, tag.name()) {
            (At::Object, b"metadatagroup") => At::Metadata,
            (At::Metadata, b"metadata") => self.metadata(xml, tag, "name").map(|()| At::Elsewhere)?,
            (At::Object, b"mesh") => At::Mesh,
            (At::Object, b"components") => At::Components,
            (At::Mesh, b"vertices") => At::Vertices,
            (At::Mesh, b"triangles") => At::Triangles,
            (At::Vertices, b"vertex") => self.vertex(xml, tag).map(|()| At::Elsewhere)?,
            (At::Triangles, b"triangle") => self.triangle(xml, tag).map(|()| At::Elsewhere)?,
            (At::Components, b"component") => {
                let instance = instance(xml, tag, standing)?;
                if let Some(object) = self.objects.last_mut() {
                    object.components.push(instance);
                }
                At::Elsewhere
            }
            _ => At::Elsewhere,
        })
    }

    /// What Cura says of the object; its keys carry a prefix where they stand among those of others.
    fn metadata(&mut self, xml: &Xml<'_>, tag: &Tag<'_>, name: &str) -> Result<()> {
        let Some(key) = xml.text(tag, name)? else { return Ok(()) };
        let (prefix, key) = key.split_once(':').unwrap_or(("", &key));
        let is_of_cura = tag.namespace == CURA || prefix == "cura" || xml.namespace_of(prefix).as_deref() == Some(CURA);
        if let Some(object) = self.objects.last_mut().filter(|_| is_of_cura) {
            object.cura.set(key, &xml.text_ahead());
        }
        Ok(())
    }

    /// Unit and required extensions.
    fn root(&mut self, xml: &Xml<'_>, tag: &Tag<'_>, part: &str) -> Result<()> {
        let unit = xml.text(tag, "unit")?;
        self.unit_mm = match unit.as_deref().unwrap_or("millimeter") {
            "micron" => 0.001,
            "millimeter" => 1.0,
            "centimeter" => 10.0,
            "inch" => 25.4,
            "foot" => 304.8,
            "meter" => 1000.0,
            other => return Err(xml.bad(format!("unknown unit `{}`", printable(other)))),
        };
        for prefix in xml.text(tag, "requiredextensions")?.unwrap_or_default().split_ascii_whitespace() {
            let namespace = xml.namespace_of(prefix);
            if namespace.as_deref().is_some_and(|n| HARMLESS.contains(&n)) {
                continue;
            }
            let name = namespace.as_deref().map_or("", extension_name);
            return Err(Error::Unsupported {
                what: format!("the required 3MF extension `{}`{}", printable(prefix), bracketed(name)),
                place: Place::Member { name: part.to_string(), line: Some(xml.line()) },
                remedy: "export the part as a plain mesh: 3MF core, or STL".into(),
            });
        }
        Ok(())
    }

    /// A new object, to be filled by what follows.
    fn object(&mut self, xml: &Xml<'_>, tag: &Tag<'_>, id: Option<u32>) -> Result<()> {
        let id = id.ok_or_else(|| xml.bad("an object without number".into()))?;
        let purpose = match xml.text(tag, "type")?.as_deref() {
            None | Some("model") => Purpose::Model,
            Some("support" | "solidsupport" | "surface" | "other") => Purpose::Other,
            Some(other) => return Err(xml.bad(format!("unknown type of object `{}`", printable(other)))),
        };
        self.objects.push(Object {
            id,
            name: xml.text(tag, "name")?.unwrap_or_default(),
            purpose,
            cura: Cura::default(),
            line: xml.line(),
            vertices: Vec::new(),
            triangles: Vec::new(),
            components: Vec::new(),
        });
        Ok(())
    }

    fn vertex(&mut self, xml: &Xml<'_>, tag: &Tag<'_>) -> Result<()> {
        let mut found = [None; 3];
        xml.attributes(tag, |name, value| {
            let axis = [b"x", b"y", b"z"].iter().position(|a| a.as_slice() == name);
            if let Some(to) = axis.and_then(|a| found.get_mut(a)) {
                *to = Some(xml.number(value)?);
            }
            Ok(())
        })?;
        let [Some(x), Some(y), Some(z)] = found else {
            return Err(xml.bad("a vertex without one of x, y, z".into()));
        };
        if let Some(problem) = accept::point_problem([x, y, z]) {
            return Err(xml.bad(problem));
        }
        if let Some(object) = self.objects.last_mut() {
            object.vertices.push([x, y, z]);
        }
        Ok(())
    }

    fn triangle(&mut self, xml: &Xml<'_>, tag: &Tag<'_>) -> Result<()> {
        let mut found = [None; 3];
        xml.attributes(tag, |name, value| {
            let corner = [b"v1", b"v2", b"v3"].iter().position(|a| a.as_slice() == name);
            if let Some(to) = corner.and_then(|c| found.get_mut(c)) {
                *to = Some(xml.whole(name, value)?);
            }
            Ok(())
        })?;
        let [Some(a), Some(b), Some(c)] = found else {
            return Err(xml.bad("a triangle without one of v1, v2, v3".into()));
        };
        let Some(object) = self.objects.last_mut() else { return Ok(()) };
        let count = object.vertices.len();
        if let Some(index) = [a, b, c].into_iter().find(|&i| i as usize >= count) {
            return Err(xml.bad(format!("a triangle names vertex {index} of {count}; they count from 0")));
        }
        object.triangles.push([a, b, c]);
        Ok(())
    }
}

/// The number of a resource, which must be its own.
fn claimed_id(xml: &Xml<'_>, tag: &Tag<'_>, ids: &mut BTreeSet<u32>) -> Result<Option<u32>> {
    let id = xml.text(tag, "id")?.map(|text| xml.whole(b"id", text.as_bytes())).transpose()?;
    match id {
        Some(id) if !ids.insert(id) => Err(xml.bad(format!("two resources with the number {id}"))),
        id => Ok(id),
    }
}

/// A component or build item.
fn instance(xml: &Xml<'_>, tag: &Tag<'_>, standing: Standing) -> Result<Instance> {
    let path = xml.text_in(tag, PRODUCTION, "path")?;
    if let (Some(path), Standing::Named) = (&path, standing) {
        let shown = printable(path);
        return Err(xml.bad(format!("a path to {shown} in a model part that is not the root, which 3MF forbids")));
    }
    let id = xml.text(tag, "objectid")?.ok_or_else(|| xml.bad("a reference without objectid".into()))?;
    let transform = match xml.text(tag, "transform")? {
        None => Transform::IDENTITY,
        Some(text) => {
            let words =
                text.split_ascii_whitespace().map(|w| xml.number(w.as_bytes())).collect::<Result<Vec<f64>>>()?;
            let count = words.len();
            let numbers =
                words.try_into().map_err(|_| xml.bad(format!("a transform of {count} numbers instead of 12")))?;
            Transform::new(numbers).map_err(|problem| xml.bad(problem))?
        }
    };
    Ok(Instance { path, object: xml.whole(b"objectid", id.as_bytes())?, transform, line: xml.line() })
}

/// The word of an extension's namespace that people know it by: `production`, `beamlattice`.
pub(super) fn extension_name(namespace: &str) -> &str {
    let mut steps = namespace.trim_end_matches('/').rsplit('/');
    steps.find(|s| !s.is_empty() && !s.bytes().all(|b| b.is_ascii_digit())).unwrap_or(namespace)
}

fn bracketed(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!(" ({})", printable(name)) }
}
