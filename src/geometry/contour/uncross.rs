//! Creases blunted where facets would cross.

use super::crowd::Crowd;
use super::feature::Turned;
use crate::geometry::mesh::TriangleMesh;
use crate::geometry::vector::{Vec3, add, distance, scale};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// The fans of a surface: each has its apex at a vertex from `first` on.
pub(super) struct Fans {
    /// The first vertex that is an apex.
    pub(super) first: usize,
    /// For each of them the middle of its polygon.
    pub(super) middles: Vec<Vec3>,
    /// Vertices that were put beside their edges, with their places on these and what was the middle of each polygon then.
    pub(super) aside: Option<Aside>,
}

/// The surface before vertices were put beside their edges.
pub(super) struct Aside {
    on_edges: FxHashMap<u32, Vec3>,
    middles: Vec<Vec3>,
}

impl Fans {
    /// Puts vertices beside their edges as far as no facets cross, while all apexes are in the middles of their polygons.
    pub(super) fn put_aside(
        &mut self,
        mesh: &mut TriangleMesh,
        crowd: &Crowd,
        aside: &[(u32, Vec3)],
        onto: impl Fn(Vec3) -> Vec3,
    ) {
        let on_edges = aside.iter().map(|&(v, _)| (v, mesh.vertices[v as usize])).collect();
        let apexes: Vec<Vec3> = mesh.vertices.drain(self.first..).collect();
        mesh.vertices.extend_from_slice(&self.middles);
        crowd.put_back(mesh, aside, onto);
        let mut sums = vec![([0.0; 3], 0.0); apexes.len()];
        // An apex is the first corner of its facets.
        for &[apex, corner, _] in &mesh.triangles {
            if let Some(sum) = (apex as usize).checked_sub(self.first).and_then(|at| sums.get_mut(at)) {
                *sum = (add(sum.0, mesh.vertices[corner as usize]), sum.1 + 1.0);
            }
        }
        let now = sums.into_iter().map(|(sum, corners)| scale(sum, 1.0 / corners)).collect();
        self.aside = Some(Aside { on_edges, middles: std::mem::replace(&mut self.middles, now) });
        mesh.vertices.truncate(self.first);
        mesh.vertices.extend(apexes);
    }

    /// Where a vertex at p goes that facets cross about, if it goes anywhere, and how late: an apex to the middle of its polygon, a vertex
    /// that is beside its edge back to that, and then an apex to where the middle was.
    fn home(&self, v: u32, p: Vec3) -> Option<(u8, Vec3)> {
        let Some(apex) = (v as usize).checked_sub(self.first) else {
            return Some((0, *self.aside.as_ref()?.on_edges.get(&v)?));
        };
        let (now, before) = (*self.middles.get(apex)?, self.aside.as_ref().and_then(|aside| aside.middles.get(apex)));
        if p != now && Some(&p) != before {
            return Some((0, now));
        }
        Some((LAST, *before?))
    }
}

/// The share of its way to the middle of its polygon that an apex goes at once.
const STEP: f64 = 0.125;

/// How often it does before it goes there.
const STEPS: u8 = 16;

/// Later than after all steps.
const LAST: u8 = 64;

/// Turns edges back, and then draws apexes to the middles of their polygons, until no two facets of the crowd cross.
///
/// Then the apexes go as far back as none do, and those that cannot get there onto the surface beside, by `onto`.
///
/// What is left of a polygon at the worst is a fan about a point in its middle, with its corners on their edges. Polygons of one cell lie on both sides of a plane, those of
/// several in cells of their own, so that nothing is left to cross.
///
/// # Cost
/// A tree over the facets of the crowd, and over those near what was moved for each round; each round gives up a crease or draws an apex.
pub(super) fn uncrossed(
    mesh: &mut TriangleMesh,
    crowd: &Crowd,
    fans: &Fans,
    turned: &[Turned],
    onto: impl Fn(Vec3) -> Vec3,
) {
    let mut edge_of: FxHashMap<usize, &Turned> = turned.iter().flat_map(|t| t.facets.map(|facet| (facet, t))).collect();
    let mut drawn: BTreeMap<u32, (u8, Vec3)> = BTreeMap::new();
    crowd.mend_crossings(mesh, |mesh, pair, moved| {
        let before = moved.len();
        for back in pair.map(|facet| edge_of.remove(&(facet as usize))).into_iter().flatten() {
            for (facet, before) in back.facets.into_iter().zip(back.before) {
                edge_of.remove(&facet);
                mesh.triangles[facet] = before;
                moved.extend(before);
            }
        }
        if moved.len() > before {
            return;
        }
        // Of the vertices of both facets the one that was drawn least, and of those the one that is farthest from where it goes.
        let apart = |v: u32| {
            let (late, home) = fans.home(v, mesh.vertices[v as usize])?;
            let steps = drawn.get(&v).map(|drawn| drawn.0).unwrap_or_default().max(late);
            Some((steps, -distance(mesh.vertices[v as usize], home), v, home)).filter(|apart| apart.1 < 0.0)
        };
        let apexes = pair.map(|facet| mesh.triangles[facet as usize]).concat().into_iter().filter_map(apart);
        let first = apexes.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        if let Some((steps, _, v, home)) = first {
            let p = &mut mesh.vertices[v as usize];
            let of = drawn.entry(v).or_insert((0, *p));
            of.0 = of.0.saturating_add(1);
            *p = if steps < STEPS { add(scale(*p, 1.0 - STEP), scale(home, STEP)) } else { home };
            moved.push(v);
        }
    });
    let places: Vec<(u32, Vec3)> = drawn.into_iter().map(|(v, (_, place))| (v, place)).collect();
    crowd.put_back(mesh, &places, onto);
}
