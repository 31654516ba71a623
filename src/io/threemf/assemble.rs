//! The mesh of all build items.

use super::scene::{Node, Placed, Scene, damaged};
use super::settings::Settings;
use super::transform::Transform;
use super::volumes::Volumes;
use crate::error::{Error, Result};
use crate::geometry::TriangleMesh;
use crate::io::accept;
use crate::notice::Notice;

/// Instances may make this many facets of few; beyond it, only as many as the file really holds.
const MOST_INSTANCED: u64 = 1 << 24;

/// The facets of all items, each object welded by itself, so that bodies which touch stay apart.
///
/// # Errors
/// [`Error::Damaged`] for objects that hold themselves; [`Error::TooLarge`] if instances multiply beyond 2²⁴ facets;
/// [`Error::Unsupported`] for volumes that a slicer takes out of the part.
pub(super) fn assemble(mut scene: Scene, settings: &Settings, notices: &mut Vec<Notice>) -> Result<TriangleMesh> {
    let order = inner_first(&scene)?;
    check_size(&scene, &order)?;
    let mut volumes = Volumes::new(settings);
    volumes.take_apart(&mut scene.nodes);
    let welded: Vec<TriangleMesh> = scene.nodes.iter().map(welded).collect();
    let mut mesh = TriangleMesh::default();
    for item in &scene.items {
        let Some(built) = scene.nodes.get(item.at) else { continue };
        let mut walk = volumes.enter(built.object.id);
        let mut stack = vec![(item.at, item.transform)];
        while let Some((at, transform)) = stack.pop() {
            let Some(node) = scene.nodes.get(at) else { continue };
            if volumes.leaves_out(&mut walk, at, node, scene.part(node.part))? {
                continue;
            }
            for component in node.components.iter().rev() {
                stack.push((component.at, component.transform.then(&transform)));
            }
            if let Some(own) = welded.get(at) {
                append(&mut mesh, own, &transform).map_err(|problem| damaged(scene.part(node.part), None, problem))?;
            }
        }
    }
    notices.extend(volumes.notices(&scene.nodes));
    Ok(mesh)
}

/// The objects so that each comes after all that it holds.
fn inner_first(scene: &Scene) -> Result<Vec<usize>> {
    #[derive(Clone, Copy, PartialEq)]
    enum Mark {
        New,
        Open,
        Done,
    }
    let mut marks = vec![Mark::New; scene.nodes.len()];
    let mut order = Vec::new();
    for start in 0..scene.nodes.len() {
        // Depth-first with a stack of our own: a chain of components may be as long as the file.
        let mut stack = vec![(start, 0)];
        while let Some((at, next)) = stack.pop() {
            let (Some(mark), Some(node)) = (marks.get_mut(at), scene.nodes.get(at)) else { continue };
            if *mark == Mark::Done {
                continue;
            }
            *mark = Mark::Open;
            let Some(component) = node.components.get(next) else {
                *mark = Mark::Done;
                order.push(at);
                continue;
            };
            stack.push((at, next + 1));
            if marks.get(component.at) == Some(&Mark::Open) {
                let id = scene.nodes.get(component.at).map_or(0, |n| n.object.id);
                let problem = format!("object {id} holds itself");
                return Err(damaged(scene.part(node.part), component.line, problem));
            }
            stack.push((component.at, 0));
        }
    }
    Ok(order)
}

/// Counts what the items make, before any of it is made; an object without facets counts as one.
fn check_size(scene: &Scene, order: &[usize]) -> Result<()> {
    let mut facets = vec![0u64; scene.nodes.len()];
    let sum = |placed: &[Placed], facets: &[u64]| {
        placed.iter().fold(0u64, |sum, p| sum.saturating_add(facets.get(p.at).copied().unwrap_or(0)))
    };
    for &at in order {
        let Some(node) = scene.nodes.get(at) else { continue };
        let own = (node.object.triangles.len() as u64).max(1).saturating_add(sum(&node.components, &facets));
        if let Some(to) = facets.get_mut(at) {
            *to = own;
        }
    }
    let made = sum(&scene.items, &facets);
    let distinct: u64 = scene.nodes.iter().map(|n| n.object.triangles.len() as u64).sum();
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
fn welded(node: &Node) -> TriangleMesh {
    let corner = |i: u32| node.object.vertices.get(i as usize).copied().unwrap_or_default();
    TriangleMesh::weld(node.object.triangles.iter().map(|t| t.map(corner)))
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
