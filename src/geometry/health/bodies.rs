//! What shells bound, once it is known which lies in which.

use super::shells::Shell;
use crate::geometry::vector::Vec3;

/// The label of a facet or shell that belongs to nothing: collapsed facets and ghosts.
pub const NO_LABEL: u32 = u32::MAX;

/// What a shell bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Material from outside: a body, or one inside a cavity of another.
    Body,
    /// As a body, but wound inside out while others are not; to be read as solid.
    Inverted,
    /// A void wholly inside material.
    Cavity,
    /// A solid wholly inside the material of another: it adds nothing to the union.
    Swallowed,
    /// Closed, with no volume worth the name.
    Ghost,
    /// Not closed: a surface with holes or mixed winding.
    Open,
}

/// A piece of material: an outer shell and its cavities.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// The outer shell.
    pub shell: u32,
    /// The shells of its cavities.
    pub cavities: Vec<u32>,
    /// Volume between outer shell and cavities, mm³; not meaningful where the outer shell does not close.
    pub volume_mm3: f64,
    /// Least and greatest corner.
    pub box_mm: [Vec3; 2],
}

/// Sets the roles, outer shells before inner; for every shell the outer shell of its body.
pub(super) fn assign_roles(shells: &mut [Shell], inside: &[Vec<u32>], sign: f64) -> Vec<Option<usize>> {
    let mut order: Vec<usize> = (0..shells.len()).filter(|&s| shells[s].role != Role::Ghost).collect();
    order.sort_by_key(|&s| (inside[s].len(), s));
    let mut layers = vec![0i32; shells.len()];
    let mut hosts = vec![None; shells.len()];
    for s in order {
        let within: i32 = inside[s].iter().map(|&t| layers[t as usize]).sum();
        // The innermost shell around has the most shells around itself.
        let around = inside[s].iter().map(|&t| t as usize).filter(|&t| layers[t] > 0);
        let innermost = around.max_by_key(|&t| (inside[t].len(), std::cmp::Reverse(t)));
        // Within a shell that is inside out, a void may be wound either way; a solid would add nothing.
        let in_inverted = innermost.is_some_and(|t| shells[t].role == Role::Inverted);
        let inward = sign * shells[s].volume_mm3 < 0.0;
        let (role, layer) = match (within >= 1, inward) {
            (true, _) if in_inverted => (Role::Cavity, -1),
            (true, true) => (Role::Cavity, -1),
            (true, false) => (Role::Swallowed, 1),
            (false, true) => (Role::Inverted, 1),
            (false, false) => (Role::Body, 1),
        };
        layers[s] = layer;
        shells[s].role = if shells[s].closed { role } else { Role::Open };
        hosts[s] = if within >= 1 { innermost.and_then(|t| hosts[t]) } else { Some(s) };
    }
    hosts
}

/// The bodies in order of their first facets, each with its cavities; sets the body of every shell.
pub(super) fn bodies(shells: &mut [Shell], hosts: &[Option<usize>]) -> Vec<Body> {
    let mut bodies: Vec<Body> = Vec::new();
    for s in (0..shells.len()).filter(|&s| hosts[s] == Some(s)) {
        shells[s].body = bodies.len() as u32;
        bodies.push(Body {
            shell: s as u32,
            cavities: Vec::new(),
            volume_mm3: shells[s].volume_mm3.abs(),
            box_mm: shells[s].box_mm,
        });
    }
    for s in 0..shells.len() {
        let Some(host) = hosts[s].filter(|&h| h != s) else { continue };
        shells[s].body = shells[host].body;
        if shells[s].role == Role::Cavity
            && let Some(body) = bodies.get_mut(shells[s].body as usize)
        {
            body.cavities.push(s as u32);
            body.volume_mm3 -= shells[s].volume_mm3.abs();
        }
    }
    bodies
}
