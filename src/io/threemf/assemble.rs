//! The mesh of all build items.

use super::model::{Instance, Model, Object, Purpose};
use super::transform::Transform;
use crate::error::{Error, Place, Result};
use crate::geometry::TriangleMesh;
use crate::io::accept;
use crate::notice::Notice;
use std::collections::HashMap;

/// Instances may make this many facets of few; beyond it, only as many as the file really holds.
const MOST_INSTANCED: u64 = 1 << 24;

/// The facets of all items, each object welded by itself, so that bodies which touch stay apart.
///
/// # Errors
/// [`Error::Damaged`] for references to objects that do not exist, and for objects that hold themselves;
/// [`Error::TooLarge`] if instances multiply beyond 2²⁴ facets.
pub(super) fn assemble(model: &Model, part: &str, notices: &mut Vec<Notice>) -> Result<TriangleMesh> {
    let known: HashMap<u32, usize> = model.objects.iter().enumerate().map(|(i, o)| (o.id, i)).collect();
    let find = |instance: &Instance| {
        known.get(&instance.object).copied().ok_or_else(|| {
            let problem = format!("object {} is referred to and does not exist", instance.object);
            damaged(part, Some(instance.line), problem)
        })
    };
    let order = inner_first(model, part, find)?;
    check_size(model, &order, find)?;
    let welded: Vec<TriangleMesh> = model.objects.iter().map(welded).collect();
    let mut mesh = TriangleMesh::default();
    let mut left_out = 0;
    let mut stack = Vec::new();
    for item in model.items.iter().rev() {
        stack.push((find(item)?, item.transform));
    }
    while let Some((at, transform)) = stack.pop() {
        let Some(object) = model.objects.get(at) else { continue };
        if object.purpose != Purpose::Model {
            left_out += 1;
            continue;
        }
        for component in object.components.iter().rev() {
            stack.push((find(component)?, component.transform.then(&transform)));
        }
        if let Some(own) = welded.get(at) {
            append(&mut mesh, own, &transform).map_err(|problem| damaged(part, None, problem))?;
        }
    }
    if left_out > 0 {
        notices.push(
            Notice::new("objects-excluded", format!("{left_out} support or other objects were left out"))
                .counted(left_out),
        );
    }
    Ok(mesh)
}

/// The objects so that each comes after all that it holds.
fn inner_first(model: &Model, part: &str, find: impl Fn(&Instance) -> Result<usize>) -> Result<Vec<usize>> {
    #[derive(Clone, Copy, PartialEq)]
    enum Mark {
        New,
        Open,
        Done,
    }
    let mut marks = vec![Mark::New; model.objects.len()];
    let mut order = Vec::new();
    for start in 0..model.objects.len() {
        // Depth-first with a stack of our own: a chain of components may be as long as the file.
        let mut stack = vec![(start, 0)];
        while let Some((at, next)) = stack.pop() {
            let (Some(mark), Some(object)) = (marks.get_mut(at), model.objects.get(at)) else { continue };
            if *mark == Mark::Done {
                continue;
            }
            *mark = Mark::Open;
            let Some(component) = object.components.get(next) else {
                *mark = Mark::Done;
                order.push(at);
                continue;
            };
            stack.push((at, next + 1));
            let inner = find(component)?;
            if marks.get(inner) == Some(&Mark::Open) {
                let problem = format!("object {} holds itself", component.object);
                return Err(damaged(part, Some(component.line), problem));
            }
            stack.push((inner, 0));
        }
    }
    Ok(order)
}

/// Counts what the items make, before any of it is made; an object without facets counts as one.
fn check_size(model: &Model, order: &[usize], find: impl Fn(&Instance) -> Result<usize>) -> Result<()> {
    let mut facets = vec![0u64; model.objects.len()];
    let sum = |instances: &[Instance], facets: &[u64]| -> Result<u64> {
        instances.iter().try_fold(0u64, |sum, i| Ok(sum.saturating_add(facets.get(find(i)?).copied().unwrap_or(0))))
    };
    for &at in order {
        let Some(object) = model.objects.get(at) else { continue };
        let own = (object.triangles.len() as u64).max(1).saturating_add(sum(&object.components, &facets)?);
        if let Some(to) = facets.get_mut(at) {
            *to = own;
        }
    }
    let made = sum(&model.items, &facets)?;
    let distinct: u64 = model.objects.iter().map(|o| o.triangles.len() as u64).sum();
    let allowed = MOST_INSTANCED.max(2 * distinct);
    if made <= allowed {
        return accept::facets_fit(made);
    }
    Err(Error::TooLarge {
        what: format!("{made} triangles made of {distinct} by instances"),
        need_bytes: u128::from(made) * 36,
        allowed_bytes: u128::from(allowed) * 36,
        remedy: "build fewer copies at once".into(),
    })
}

/// The own mesh of an object.
fn welded(object: &Object) -> TriangleMesh {
    let corner = |i: u32| object.vertices.get(i as usize).copied().unwrap_or_default();
    TriangleMesh::weld(object.triangles.iter().map(|t| t.map(corner)))
}

/// Adds the image of a mesh.
fn append(mesh: &mut TriangleMesh, own: &TriangleMesh, transform: &Transform) -> std::result::Result<(), String> {
    let base = mesh.vertices.len() as u32;
    for &p in &own.vertices {
        let p = transform.apply(p);
        if let Some(problem) = accept::point_problem(p) {
            return Err(format!("after its transform, {problem}"));
        }
        mesh.vertices.push(p);
    }
    let mirrors = transform.mirrors();
    mesh.triangles.extend(own.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| v + base);
        if mirrors { [a, c, b] } else { [a, b, c] }
    }));
    Ok(())
}

fn damaged(part: &str, line: Option<u64>, problem: String) -> Error {
    let place = Place::Member { name: part.to_string(), line };
    Error::Damaged { format: "3MF", place, problem, remedy: "export the package again".into() }
}
