//! The part as one surface: bodies that overlap or touch are united first.

use crate::error::{Error, Result};
use crate::geometry::health::{Health, Role, meetings};
use crate::geometry::union::united;
use crate::geometry::{MeshDistance, TriangleMesh, body_pairs};
use crate::units::Volume;
use std::borrow::Cow;

/// Facets that are nearer than this to those of another body, or pass through each other by more, mm, or than this share of the longest side
/// where that is less: rounding in f32 is less.
const MEETING: (f64, f64) = (1e-4, 1e-5);

/// A part, with what meets itself in it united where that is possible.
pub(super) struct Whole<'a> {
    pub(super) mesh: Cow<'a, TriangleMesh>,
    /// Whether its facets bound a solid, wound outwards, and none of them lies inside of its material.
    pub(super) bounding: bool,
}

impl<'a> Whole<'a> {
    /// A part whose facets bound a solid and meet nowhere as it is, any other as its union, if there is one.
    ///
    /// # Cost
    /// The health of the mesh and a walk over pairs of facets that are near each other; that of [`united`] where some meet.
    pub(super) fn of(part: &'a TriangleMesh) -> Self {
        let as_it_is = |bounding| Whole { mesh: Cow::Borrowed(part), bounding };
        match outward(part) {
            None => as_it_is(false),
            Some(health) if health.count_of(Role::Ghost) == 0 && stands_alone(part, &health) => as_it_is(true),
            Some(_) => united(part, resolution(part)).map_or_else(|| as_it_is(false), Whole::of_union),
        }
    }

    fn of_union(union: TriangleMesh) -> Self {
        let bounding = outward_solid(&union).is_some_and(|health| stands_alone(&union, &health));
        Whole { mesh: Cow::Owned(union), bounding }
    }

    /// Of a part in one piece nothing is asked; one in several is looked at.
    fn if_in_pieces(part: &'a TriangleMesh) -> Self {
        if part.pieces() <= 1 { Whole { mesh: Cow::Borrowed(part), bounding: false } } else { Whole::of(part) }
    }

    /// What becomes of the description of a way when bodies were united before.
    pub(super) fn path(&self, path: String) -> String {
        match self.mesh {
            Cow::Borrowed(_) => path,
            Cow::Owned(_) => format!("{path}, what meets itself united first"),
        }
    }

    /// What is made of the distances to a part's facets, which have to bound it: of its union where bodies meet, or where one in a single
    /// piece is refused because some facets do not.
    ///
    /// # Errors
    /// Those of `make`.
    pub(super) fn made<T>(part: &'a TriangleMesh, make: impl Fn(&TriangleMesh) -> Result<T>) -> Result<(Whole<'a>, T)> {
        let whole = Whole::if_in_pieces(part);
        match (make(&whole.mesh), &whole.mesh) {
            (Err(refused @ Error::NotSolid { .. }), Cow::Borrowed(_)) => {
                let whole = Whole::of_union(united(part, resolution(part)).ok_or(refused)?);
                make(&whole.mesh).map(|made| (whole, made))
            }
            (made, _) => made.map(|made| (whole, made)),
        }
    }
}

/// The volume of the solid that the facets of a part bound, bodies that overlap united; `None` where they bound none for certain.
///
/// # Cost
/// Its health, pairs of facets that are near each other, and [`united`] where some meet.
pub fn solid_volume(part: &TriangleMesh) -> Option<Volume> {
    let whole = Whole::of(part);
    whole.bounding.then(|| Volume::mm3(whole.mesh.signed_volume()))
}

/// The health of a mesh that bounds a solid, wound outwards, and holds no sheets.
pub(super) fn outward_solid(mesh: &TriangleMesh) -> Option<Health> {
    outward(mesh).filter(|health| health.count_of(Role::Ghost) == 0)
}

/// The health of a closed mesh that is wound outwards.
fn outward(mesh: &TriangleMesh) -> Option<Health> {
    let health = Health::of(mesh);
    let outwards = health.shells.iter().all(|shell| !matches!(shell.role, Role::Open | Role::Inverted));
    (health.is_solid() && !health.inverted && outwards).then_some(health)
}

/// Whether no body meets another, and none passes through itself.
fn stands_alone(mesh: &TriangleMesh, health: &Health) -> bool {
    let meeting = MEETING.0.min(MEETING.1 * mesh.longest_side()).max(resolution(mesh));
    if health.count_of(Role::Swallowed) > 0 || !body_pairs(mesh, health, meeting).is_empty() {
        return false;
    }
    let found = meetings(&MeshDistance::new(mesh), |_, _| true, meeting);
    found.crossing.count + found.overlapping.count == 0
}

/// What coordinates in f32 are off by, twice, mm.
fn resolution(mesh: &TriangleMesh) -> f64 {
    let largest = mesh.bounds().map_or(0.0, |(lo, hi)| lo.into_iter().chain(hi).fold(0.0, |m: f64, x| m.max(x.abs())));
    (2.0 * f64::from(f32::EPSILON) * largest).min(MEETING.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn bodies_that_meet_are_one_and_others_stay_as_they_are() {
        let block = || cuboid([0.0; 3], [4.0, 4.0, 4.0]);
        let beside = |x: f64| block().joined(&cuboid([x, 0.0, 0.0], [x + 3.0, 4.0, 4.0]));
        for (part, owned, volume) in
            [(beside(3.0), true, 96.0), (beside(4.0), true, 112.0), (beside(4.5), false, 112.0), (block(), false, 64.0)]
        {
            let whole = Whole::of(&part);
            assert!(whole.bounding && matches!(whole.mesh, Cow::Owned(_)) == owned);
            assert!((whole.mesh.signed_volume() - volume).abs() < 1e-9);
            assert_eq!(whole.mesh.pieces() == 1, volume != 112.0 || owned);
        }
        let open = TriangleMesh { triangles: block().triangles[1..].to_vec(), ..block() };
        assert!(!Whole::of(&open).bounding);
    }

    #[test]
    fn what_is_refused_as_it_is_is_made_of_the_union() {
        // One piece: 960 mm³ along it, 64 of them twice.
        let bar = include_bytes!("../../fixtures/parts/bar_through_itself.stl");
        let part = crate::io::stl::read(bar, crate::io::Salvage::Refuse).unwrap().mesh;
        assert_eq!(part.pieces(), 1);
        let refused = |mesh: &TriangleMesh| match (mesh.signed_volume() - 896.0).abs() < 1e-3 {
            true => Ok(mesh.triangles.len()),
            false => Err(Error::NotSolid { problem: String::new(), at_mm: None, remedy: String::new() }),
        };
        let (whole, made) = Whole::made(&part, refused).expect("a union");
        assert_eq!(whole.mesh.triangles.len(), made);
        assert_eq!(whole.path("exact".into()), "exact, what meets itself united first");
    }
}
