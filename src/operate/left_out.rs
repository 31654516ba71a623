//! What of a result is finer than the samples that it was made of, and missing.

use super::shape::Operated;
use crate::geometry::vector::{Vec3, bounds};
use crate::geometry::{DisjointSets, TriangleMesh};
use crate::notice::Notice;
use crate::units::{Length, short};
use rustc_hash::FxHashMap;

/// A piece with no side longer than so many spacings is a crumb.
const CRUMB: f64 = 3.0;
/// How far a surface may end from the box of the exact result, in spacings.
const SHORT: f64 = 2.0;
/// As many crumbs as may be meant: a sphere of three samples is a sphere.
const MEANT: usize = 2;

impl Operated {
    /// Says where the surface comes in crumbs, as it does where the result is thinner than the spacing: the rest is left out.
    ///
    /// # Cost
    /// O(facets).
    pub fn left_out(&self, spacing: Length) -> Option<Notice> {
        let crumbs = crumbs(&self.mesh, spacing * CRUMB);
        let &[at, ..] = crumbs.as_slice() else { return None };
        (crumbs.len() > MEANT).then(|| {
            let text = format!(
                "{} loose pieces are no longer than {CRUMB} samples, one at ({}) mm: where the result is thinner than the spacing parts of it \
                 are left out; choose a smaller --voxel",
                crumbs.len(),
                at.map(short).join(", ")
            );
            Notice::new("thinner-than-spacing", text).at(at)
        })
    }

    /// Says where a closing fills what may be room for its element, because no sample tells.
    pub fn may_fill_too_much(&self) -> Option<Notice> {
        let (count, at) = self.filled?;
        let (is, one) = if count == 1 { ("gap or room", "") } else { ("gaps or rooms", "one ") };
        let text = format!(
            "{count} {is} about as wide as the element, {one}near ({}) mm, may be open and came out filled: the spacing does not tell; choose a smaller \
             --voxel",
            at.map(short).join(", ")
        );
        Some(Notice::new("thinner-than-spacing", text).at(at))
    }

    /// Says where the surface ends farther from the box that the exact result touches than samples explain: what reached there is thinner
    /// than the spacing.
    pub fn falls_short(&self, (lo, hi): (Vec3, Vec3), spacing: Length) -> Option<Notice> {
        let (from, to) = self.mesh.bounds()?;
        let short_by = (0..3).map(|a| (from[a] - lo[a]).max(hi[a] - to[a])).fold(0.0, f64::max);
        (short_by > SHORT * spacing.as_mm()).then(|| {
            let text = format!(
                "the result ends {} mm short of where its box does: what reaches there is thinner than the spacing and left out; choose a \
                 smaller --voxel",
                short(short_by)
            );
            Notice::new("thinner-than-spacing", text)
        })
    }
}

/// A corner of each piece of a mesh whose sides are no longer than a length.
fn crumbs(mesh: &TriangleMesh, longest: Length) -> Vec<Vec3> {
    let mut pieces = DisjointSets::new(mesh.vertices.len());
    for &[a, b, c] in &mesh.triangles {
        pieces.join(a, b);
        pieces.join(b, c);
    }
    let mut corners: FxHashMap<u32, Vec<Vec3>> = FxHashMap::default();
    for &[a, ..] in &mesh.triangles {
        corners.entry(pieces.root(a)).or_default();
    }
    for (vertex, &corner) in (0..).zip(&mesh.vertices) {
        if let Some(own) = corners.get_mut(&pieces.root(vertex)) {
            own.push(corner);
        }
    }
    let is_small = |own: &Vec<Vec3>| {
        bounds(own.iter().copied()).is_some_and(|(lo, hi)| (0..3).all(|a| hi[a] - lo[a] <= longest.as_mm()))
    };
    let mut found: Vec<(u32, Vec3)> = corners
        .iter()
        .filter(|(_, own)| is_small(own))
        .filter_map(|(root, own)| Some((*root, *own.first()?)))
        .collect();
    found.sort_unstable_by_key(|piece| piece.0);
    found.into_iter().map(|piece| piece.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn small_pieces_are_crumbs_and_large_ones_are_not() {
        let large = cuboid([0.0; 3], [5.0, 1.0, 0.2]);
        let crumb = |x: f64| cuboid([x, 9.0, 0.0], [x + 0.2, 9.2, 0.1]);
        let mesh = large.joined(&crumb(0.0)).joined(&crumb(3.0));
        assert_eq!(crumbs(&mesh, Length::mm(0.3)).len(), 2);
        assert_eq!(crumbs(&mesh, Length::mm(0.15)).len(), 0);
        assert_eq!(crumbs(&mesh, Length::mm(6.0)).len(), 3);
    }
}
