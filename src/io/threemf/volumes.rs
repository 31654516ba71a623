//! Which meshes the volumes of a slicer's settings are, and what is left out of the part because of them.

use super::model::{Object, Purpose};
use super::role::Role;
use super::scene::Node;
use super::settings::{Mesh, Settings, Volume};
use crate::error::{Error, Place, Result, printable};
use crate::notice::{Notice, number_of};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Most names of volumes in one notice, for each kind.
const MOST_NAMES: usize = 3;

/// The declared volumes, with what was found of them.
pub(super) struct Volumes<'a> {
    declared: &'a [Volume],
    /// The volumes of an object, in the order of its components.
    listed: HashMap<u32, Vec<usize>>,
    /// The first volume of an object that names a mesh.
    first: HashMap<(u32, u32), usize>,
    /// Volumes that were taken out of an object's own facets, by object.
    apart: HashMap<usize, Vec<usize>>,
    found: Vec<bool>,
    /// Numbers of the objects of the root model, and of those that are built, that walks came to.
    reached: HashSet<u32>,
    left_out: BTreeMap<Role, (u64, Vec<String>)>,
    others: u64,
}

/// A build item on the way through its components.
pub(super) struct Walk {
    /// The number of the object that is built.
    object: u32,
    /// How many meshes were met so far.
    meshes: usize,
}

impl<'a> Volumes<'a> {
    pub(super) fn new(settings: &'a Settings) -> Self {
        let declared = settings.volumes.as_slice();
        let mut listed: HashMap<u32, Vec<usize>> = HashMap::new();
        let mut first = HashMap::new();
        for (i, volume) in declared.iter().enumerate() {
            if let (Some(object), Mesh::Object(id)) = (volume.object, volume.mesh) {
                listed.entry(object).or_default().push(i);
                first.entry((object, id)).or_insert(i);
            }
        }
        Volumes {
            declared,
            listed,
            first,
            apart: HashMap::new(),
            found: vec![false; declared.len()],
            reached: HashSet::new(),
            left_out: BTreeMap::new(),
            others: 0,
        }
    }

    /// Takes runs of facets that are no material out of the objects of the root model, which alone they speak of.
    pub(super) fn take_apart(&mut self, nodes: &mut [Node]) {
        let mut runs: HashMap<u32, Vec<(usize, u32, u32)>> = HashMap::new();
        for (i, volume) in self.declared.iter().enumerate().filter(|(_, v)| v.role != Role::Material) {
            if let (Some(object), Mesh::Facets(first, last)) = (volume.object, volume.mesh) {
                runs.entry(object).or_default().push((i, first, last));
            }
        }
        for (at, node) in nodes.iter_mut().enumerate().filter(|(_, n)| n.part == 0) {
            let Some(runs) = runs.get(&node.object.id) else { continue };
            // How many runs begin less how many end at each facet: runs may be as many as facets.
            let mut steps = vec![0i64; node.object.triangles.len() + 1];
            for &(i, first, last) in runs {
                let (first, end) = (first as usize, last as usize + 1);
                let fits = first < end && end < steps.len();
                let Some(found) = self.found.get_mut(i).filter(|_| fits) else { continue };
                steps.get_mut(first).into_iter().for_each(|n| *n += 1);
                steps.get_mut(end).into_iter().for_each(|n| *n -= 1);
                *found = true;
                self.apart.entry(at).or_default().push(i);
            }
            let mut open = 0;
            let mut steps = steps.into_iter();
            node.object.triangles.retain(|_| {
                open += steps.next().unwrap_or(0);
                open == 0
            });
        }
    }

    /// Begins at a build item.
    pub(super) fn enter(&mut self, object: u32) -> Walk {
        self.reached.insert(object);
        Walk { object, meshes: 0 }
    }

    /// Whether an object that a walk comes to is no material; then it is counted.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a negative volume.
    pub(super) fn leaves_out(&mut self, walk: &mut Walk, at: usize, node: &Node, part: &str) -> Result<bool> {
        if node.part == 0 {
            self.reached.insert(node.object.id);
        }
        for i in self.apart.get(&at).cloned().unwrap_or_default() {
            self.leave_out_declared(i)?;
        }
        let object = &node.object;
        if let Some(i) = self.declared_of(walk, object) {
            return self.leave_out_declared(i).map(|()| true);
        }
        let role = object.cura.role();
        if role != Role::Material {
            let name = if object.name.is_empty() {
                format!("object {}", object.id)
            } else {
                format!("`{}`, object {}", printable(&object.name), object.id)
            };
            let place = Place::Member { name: part.to_string(), line: Some(object.line) };
            return self.leave_out(role, name, place).map(|()| true);
        }
        self.others += u64::from(object.purpose != Purpose::Model);
        Ok(object.purpose != Purpose::Model)
    }

    /// The declared volume that a mesh is, if that is no material: the one of the same rank if it names this mesh, as
    /// meshes may be shared, else the first that does.
    fn declared_of(&mut self, walk: &mut Walk, object: &Object) -> Option<usize> {
        if object.triangles.is_empty() {
            return None;
        }
        let rank = walk.meshes;
        walk.meshes += 1;
        let mesh = |i: &usize| self.declared.get(*i).is_some_and(|v| v.mesh == Mesh::Object(object.id));
        let same_rank = self.listed.get(&walk.object).and_then(|l| l.get(rank)).copied().filter(mesh);
        let i = same_rank.or_else(|| self.first.get(&(walk.object, object.id)).copied())?;
        if let Some(found) = self.found.get_mut(i) {
            *found = true;
        }
        self.declared.get(i).filter(|v| v.role != Role::Material).map(|_| i)
    }

    fn leave_out_declared(&mut self, i: usize) -> Result<()> {
        let Some(volume) = self.declared.get(i) else { return Ok(()) };
        let place = Place::Member { name: volume.file.to_string(), line: Some(volume.line) };
        self.leave_out(volume.role, volume.told(), place)
    }

    fn leave_out(&mut self, role: Role, name: String, place: Place) -> Result<()> {
        if role == Role::Negative {
            return Err(Error::Unsupported {
                what: format!("a negative volume ({name}), which the slicer takes out of the part,"),
                place,
                remedy: "subtract it in the slicer or in CAD, and export the result as a mesh".into(),
            });
        }
        let (count, names) = self.left_out.entry(role).or_default();
        *count += 1;
        if names.len() <= MOST_NAMES && !names.contains(&name) {
            names.push(name);
        }
        Ok(())
    }

    /// What was left out, and what could not be told apart.
    pub(super) fn notices(self, nodes: &[Node]) -> Vec<Notice> {
        let unknown = self.unknown(nodes);
        let mut notices = Vec::new();
        if self.others > 0 {
            let message = format!("{} support or other objects were left out", self.others);
            notices.push(Notice::new("objects-excluded", message).counted(self.others));
        }
        if !self.left_out.is_empty() {
            let kinds: Vec<String> = self.left_out.iter().map(|(role, (n, names))| listed(*role, *n, names)).collect();
            let message = format!("left out, as they are no material to the slicer: {}", kinds.join("; "));
            let count = self.left_out.values().map(|(n, _)| n).sum();
            notices.push(Notice::new("volumes-excluded", message).counted(count));
        }
        if !unknown.is_empty() {
            let kinds: Vec<String> = unknown.iter().map(|(role, n)| number_of(*n, role.words())).collect();
            let message = format!(
                "the slicer's settings hold {} without a mesh of the file that they belong to: all was read as material",
                kinds.join(", ")
            );
            notices.push(Notice::new("modifier-volumes", message).counted(unknown.values().sum()));
        }
        notices
    }

    /// How many volumes of each kind that are no material belong to no mesh; those of objects that are not built do not matter.
    fn unknown(&self, nodes: &[Node]) -> BTreeMap<Role, u64> {
        let known: HashSet<u32> = nodes.iter().filter(|n| n.part == 0).map(|n| n.object.id).collect();
        let mut unknown = BTreeMap::new();
        for (volume, found) in self.declared.iter().zip(&self.found) {
            let idle = volume.object.is_some_and(|id| known.contains(&id) && !self.reached.contains(&id));
            if volume.role != Role::Material && !found && !idle {
                *unknown.entry(volume.role).or_default() += 1;
            }
        }
        unknown
    }
}

/// `2 modifiers (`a`, part 2 of object 3; …)`.
fn listed(role: Role, count: u64, names: &[String]) -> String {
    let more = if names.len() > MOST_NAMES { ", …" } else { "" };
    let shown: Vec<&str> = names.iter().take(MOST_NAMES).map(String::as_str).collect();
    format!("{} ({}{more})", number_of(count, role.words()), shown.join(", "))
}
