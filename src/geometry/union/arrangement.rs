//! The pieces that the facets of a mesh cut each other into, and which of them bound its union: exactly.

use super::contact::{Facet, contact, crossing, is_flat};
use super::exact::{BITS, Exact, Lattice, Plane};
use super::net::Net;
use crate::geometry::health::pairs::{groups, near_pairs};
use crate::geometry::vector::Vec3;
use crate::geometry::{MeshDistance, TriangleMesh};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// The facets of a mesh on a lattice, and the points in which they meet.
pub(super) struct Arrangement {
    pub(super) facets: Vec<Facet>,
    pub(super) tree: MeshDistance,
    pub(super) points: Vec<Exact>,
    /// Triangles of points, and the facet that each is of.
    pub(super) pieces: Vec<[u32; 3]>,
    pub(super) facet: Vec<u32>,
    /// Where the points that were vertices are in the mesh.
    vertices: Vec<Vec3>,
    /// Steps of the lattice in a millimetre.
    scale: f64,
}

/// What cuts a facet: points on it that are not its corners, and segments that are not its edges.
#[derive(Default)]
struct Cuts {
    points: Vec<u32>,
    segments: Vec<[u32; 2]>,
}

/// The points known so far.
struct Points {
    all: Vec<Exact>,
    known: FxHashMap<Exact, u32>,
}

impl Points {
    fn number(&mut self, point: Exact) -> u32 {
        let next = self.all.len() as u32;
        *self.known.entry(point).or_insert_with_key(|point| {
            self.all.push(point.clone());
            next
        })
    }
}

impl Arrangement {
    /// The arrangement of the facets of a mesh, its vertices moved onto a lattice of 2⁻³⁹ of its size or less; `None` if its vertices are
    /// no finite numbers, or all so near 0 that no float tells the lattice's step.
    ///
    /// # Cost
    /// O(T log T), and for each pair of facets that have a point in common a few quotients of large integers.
    pub(super) fn of(mesh: &TriangleMesh) -> Option<Self> {
        let most = mesh.vertices.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
        if !(most > 0.0 && mesh.vertices.iter().flatten().all(|x| x.is_finite())) {
            return None;
        }
        let scale = Some(2f64.powi(BITS - 1 - most.log2().floor() as i32)).filter(|scale| scale.is_finite())?;
        let (lattice, vertices, facets) = on_lattice(mesh, scale);
        let corners = facets.iter().map(|f| f.corners.map(|p| p.map(|x| x as f64)));
        let tree = MeshDistance::new(&TriangleMesh::weld(corners));
        let all: Vec<Exact> = lattice.iter().map(|&p| Exact::on_lattice(p)).collect();
        let known = all.iter().cloned().zip(0..).collect();
        let mut points = Points { all, known };
        let cuts = cuts(&facets, &tree, &mut points)?;
        let nets: Vec<(u32, Option<Vec<[u32; 3]>>)> =
            cuts.par_iter().map(|(&f, cuts)| (f, net(&facets, f, &points.all, cuts))).collect();
        let mut nets = nets.into_iter().peekable();
        let (mut pieces, mut facet) = (Vec::new(), Vec::new());
        for (number, of) in (0u32..).zip(&facets) {
            let made = match nets.next_if(|(f, _)| *f == number) {
                Some((_, made)) => made?,
                None => vec![of.vertices],
            };
            facet.extend(made.iter().map(|_| number));
            pieces.extend(made);
        }
        Some(Arrangement { facets, tree, points: points.all, pieces, facet, vertices, scale })
    }

    /// Where a point is in the mesh, millimetres.
    pub(super) fn place(&self, point: u32) -> Vec3 {
        let made = || self.points.get(point as usize).map_or([0.0; 3], |p| p.near().map(|x| x / self.scale));
        self.vertices.get(point as usize).copied().unwrap_or_else(made)
    }
}

/// The lattice points of the vertices of a mesh, each once, where the first vertex there was, and the facets that have an area.
fn on_lattice(mesh: &TriangleMesh, scale: f64) -> (Vec<Lattice>, Vec<Vec3>, Vec<Facet>) {
    let mut known: FxHashMap<Lattice, u32> = FxHashMap::default();
    let (mut lattice, mut vertices) = (Vec::new(), Vec::new());
    let numbers: Vec<u32> = mesh
        .vertices
        .iter()
        .map(|&p| {
            let at = p.map(|x| (x * scale).round() as i64);
            *known.entry(at).or_insert_with(|| {
                lattice.push(at);
                vertices.push(p);
                lattice.len() as u32 - 1
            })
        })
        .collect();
    let facets = mesh.triangles.iter().filter_map(|triangle| {
        let vertices = triangle.map(|v| numbers.get(v as usize).copied().unwrap_or_default());
        let corners = vertices.map(|v| lattice.get(v as usize).copied().unwrap_or_default());
        let plane = Plane::of(corners);
        (!is_flat(&plane)).then_some(Facet { vertices, corners, plane })
    });
    let facets = facets.collect();
    (lattice, vertices, facets)
}

/// What cuts each facet.
fn cuts(facets: &[Facet], tree: &MeshDistance, points: &mut Points) -> Option<BTreeMap<u32, Cuts>> {
    let found = groups(tree.tree()).map_init(Vec::new, |near, group| {
        let mut pairs = Vec::new();
        near_pairs(tree.tree(), &|f| tree.corners(f), group, 0.0, near, |f, g| {
            let (Some(of_f), Some(of_g)) = (facets.get(f as usize), facets.get(g as usize)) else { return };
            pairs.extend(contact(of_f, of_g).into_iter().map(|ends| ([f, g], ends)));
        });
        pairs
    });
    let mut contacts: Vec<([u32; 2], [Exact; 2])> = found.flatten_iter().collect();
    // Points are numbered in the order of the facets, whatever the tree.
    contacts.par_sort_by_key(|(pair, _)| *pair);
    let mut cuts: BTreeMap<u32, Cuts> = BTreeMap::new();
    for (pair, ends) in contacts {
        let ends = ends.map(|p| points.number(p));
        for f in pair {
            note(&mut cuts, (f, facets.get(f as usize)?), ends);
        }
    }
    let crossed: Vec<(u32, Vec<Exact>)> =
        cuts.par_iter().map(|(&f, cuts)| (f, crossings(&facets[f as usize], &points.all, cuts))).collect();
    for (f, crossed) in crossed {
        let numbers: Vec<u32> = crossed.into_iter().map(|p| points.number(p)).collect();
        cuts.entry(f).or_default().points.extend(numbers);
    }
    for cuts in cuts.values_mut() {
        cuts.points.sort_unstable();
        cuts.points.dedup();
    }
    Some(cuts)
}

/// Notes a segment that a facet has in common with another.
fn note(cuts: &mut BTreeMap<u32, Cuts>, (f, facet): (u32, &Facet), ends: [u32; 2]) {
    let is_corner = ends.map(|p| facet.vertices.contains(&p));
    if is_corner == [true; 2] {
        return;
    }
    let cuts = cuts.entry(f).or_default();
    cuts.points.extend(ends.into_iter().zip(is_corner).filter(|(_, own)| !own).map(|(p, _)| p));
    let segment = [ends[0].min(ends[1]), ends[0].max(ends[1])];
    if ends[0] != ends[1] && !cuts.segments.contains(&segment) {
        cuts.segments.push(segment);
    }
}

/// The points in which the segments of a facet cross each other.
fn crossings(facet: &Facet, points: &[Exact], cuts: &Cuts) -> Vec<Exact> {
    let (_, axes) = facet.plane.axes();
    let end = |p: u32| points.get(p as usize);
    let ends: Vec<[&Exact; 2]> = cuts.segments.iter().filter_map(|[a, b]| Some([end(*a)?, end(*b)?])).collect();
    let mut found = Vec::new();
    for (n, of) in ends.iter().enumerate() {
        found.extend(ends.iter().take(n).filter_map(|other| crossing(axes, *of, *other)));
    }
    found
}

/// The pieces of a facet that something cuts.
fn net(facets: &[Facet], f: u32, points: &[Exact], cuts: &Cuts) -> Option<Vec<[u32; 3]>> {
    let facet = facets.get(f as usize)?;
    let (_, axes) = facet.plane.axes();
    Net::of((points, axes), facet.vertices, &cuts.points, &cuts.segments)
}
