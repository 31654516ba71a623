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
}

/// The share of its way to the middle of its polygon that an apex goes at once.
const STEP: f64 = 0.125;

/// How often it does before it goes there.
const STEPS: u8 = 16;

/// Turns edges back, and then draws apexes to the middles of their polygons, until no two facets of the crowd cross.
///
/// Then the apexes go as far back as none do, and those that cannot get there onto the surface beside, by `onto`.
///
/// What is left of a polygon at the worst is a fan about a point in its middle. Polygons of one cell lie on both sides of a plane, those of
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
        // Of the apexes of both facets the one that was drawn least, and of those the one that is farthest from where it goes.
        let apart = |v: u32| {
            let middle = *fans.middles.get((v as usize).checked_sub(fans.first)?)?;
            let steps = drawn.get(&v).map(|drawn| drawn.0).unwrap_or_default();
            Some((steps, -distance(mesh.vertices[v as usize], middle), v, middle)).filter(|apart| apart.1 < 0.0)
        };
        let apexes = pair.map(|facet| mesh.triangles[facet as usize]).concat().into_iter().filter_map(apart);
        let first = apexes.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        if let Some((steps, _, v, middle)) = first {
            let p = &mut mesh.vertices[v as usize];
            drawn.entry(v).or_insert((0, *p)).0 += 1;
            *p = if steps < STEPS { add(scale(*p, 1.0 - STEP), scale(middle, STEP)) } else { middle };
            moved.push(v);
        }
    });
    let places: Vec<(u32, Vec3)> = drawn.into_iter().map(|(v, (_, place))| (v, place)).collect();
    crowd.put_back(mesh, &places, onto);
}
