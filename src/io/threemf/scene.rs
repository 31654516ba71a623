//! The objects of all model parts of a package: the root's, and those of the parts that it names by path.

use super::model::{self, Instance, Model, Object, Standing};
use super::package::Package;
use super::relations;
use super::transform::Transform;
use crate::error::{Error, Place, Result, printable};
use crate::io::sniff;
use std::collections::{BTreeSet, HashMap};

/// A reference to an object of the scene under a transform.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    /// Which object of the scene.
    pub(super) at: usize,
    pub(super) transform: Transform,
    pub(super) line: u64,
}

/// An object with what it holds.
#[derive(Debug)]
pub(super) struct Node {
    /// The model part that it stands in; 0 is the root.
    pub(super) part: usize,
    pub(super) object: Object,
    pub(super) components: Vec<Placed>,
}

/// All objects, and what is built of them.
#[derive(Debug)]
pub(super) struct Scene {
    /// The names of the model parts.
    pub(super) parts: Vec<String>,
    /// Millimetres per unit of the root, which the scene is in.
    pub(super) unit_mm: f64,
    pub(super) nodes: Vec<Node>,
    pub(super) items: Vec<Placed>,
    pub(super) unprinted: u64,
    pub(super) foreign: BTreeSet<String>,
}

impl Scene {
    /// The name of a model part.
    pub(super) fn part(&self, part: usize) -> &str {
        self.parts.get(part).map_or("", String::as_str)
    }
}

/// Reads the root and each part that it names, once.
///
/// # Errors
/// Those of [`model::read`]; [`Error::Damaged`] for references to parts and objects that do not exist.
pub(super) fn read(package: &mut Package<'_>) -> Result<Scene> {
    let (index, name) = relations::model_part(package)?;
    let mut models = vec![part(package, index, &name, Standing::Root)?];
    let mut parts = vec![name];
    let mut read = HashMap::from([(index, 0)]);
    let mut named = HashMap::new();
    for (path, line) in paths(&models) {
        let root = parts.first().map_or("", String::as_str);
        let index = package.find(&path).ok_or_else(|| {
            damaged(root, line, format!("the model part {} is referred to and does not exist", printable(&path)))
        })?;
        let at = match read.get(&index) {
            Some(&at) => at,
            None => {
                let name = path.trim_start_matches('/').to_string();
                models.push(part(package, index, &name, Standing::Named)?);
                parts.push(name);
                read.insert(index, models.len() - 1);
                models.len() - 1
            }
        };
        named.insert(path, at);
    }
    resolved(models, parts, &named)
}

/// One model part, in whichever encoding.
fn part(package: &mut Package<'_>, index: usize, name: &str, standing: Standing) -> Result<Model> {
    let mut text = package.read(index)?;
    if text.starts_with(b"\xff\xfe") || text.starts_with(b"\xfe\xff") {
        text = sniff::decode_utf16(&text).into_bytes();
    }
    model::read(&text, name, standing)
}

/// The paths that a root model names, each once with the line of its first use, in order.
fn paths(models: &[Model]) -> Vec<(String, u64)> {
    let mut seen = BTreeSet::new();
    let all = models.iter().flat_map(|m| m.items.iter().chain(m.objects.iter().flat_map(|o| &o.components)));
    let paths = all.filter_map(|i| i.path.as_ref().map(|path| (path, i.line)));
    paths.filter(|(path, _)| seen.insert(path.as_str())).map(|(path, line)| (path.clone(), line)).collect()
}

/// The scene of models whose paths are known.
fn resolved(mut models: Vec<Model>, parts: Vec<String>, named: &HashMap<String, usize>) -> Result<Scene> {
    let mut known: HashMap<(usize, u32), usize> = HashMap::new();
    for (part, model) in models.iter().enumerate() {
        for object in &model.objects {
            let next = known.len();
            known.insert((part, object.id), next);
        }
    }
    let units: Vec<f64> = models.iter().map(|m| m.unit_mm).collect();
    let unit = |part: usize| units.get(part).copied().unwrap_or(1.0);
    let place = |from: usize, instance: &Instance| {
        let to = instance.path.as_ref().map_or(Some(from), |path| named.get(path).copied());
        let at = to.and_then(|to| known.get(&(to, instance.object)).copied());
        let (Some(to), Some(at)) = (to, at) else {
            let of = instance.path.as_ref().map_or_else(String::new, |path| format!(" of {}", printable(path)));
            let problem = format!("object {}{of} is referred to and does not exist", instance.object);
            return Err(damaged(parts.get(from).map_or("", String::as_str), instance.line, problem));
        };
        // Numbers of another part are in its own unit.
        let transform = match unit(to) / unit(from) {
            1.0 => instance.transform,
            by => Transform::scaling(by).then(&instance.transform),
        };
        Ok(Placed { at, transform, line: instance.line })
    };
    let mut nodes = Vec::with_capacity(known.len());
    for (part, model) in models.iter_mut().enumerate() {
        for mut object in std::mem::take(&mut model.objects) {
            let components = std::mem::take(&mut object.components);
            let components = components.iter().map(|c| place(part, c)).collect::<Result<_>>()?;
            nodes.push(Node { part, object, components });
        }
    }
    let root = models.first();
    let items = root.map_or(&[][..], |m| &m.items).iter().map(|i| place(0, i)).collect::<Result<_>>()?;
    let unprinted = root.map_or(0, |m| m.unprinted);
    let foreign = models.iter().flat_map(|m| m.foreign.iter().cloned()).collect();
    Ok(Scene { unit_mm: unit(0), parts, nodes, items, unprinted, foreign })
}

/// A reference that leads nowhere.
pub(super) fn damaged(part: &str, line: impl Into<Option<u64>>, problem: String) -> Error {
    let place = Place::Member { name: part.to_string(), line: line.into() };
    Error::Damaged { format: "3MF", place, problem, remedy: "export the package again".into() }
}
