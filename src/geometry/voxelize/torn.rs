//! Surfaces that are not closed: what is refused, and what the winding number makes of them.

use super::tests::{block, sphere, winding};
use super::{occupancy, voxelize};
use crate::geometry::solid::InsideRule::{Crossings, Winding};
use crate::geometry::{Solid, TriangleMesh};
use crate::grid::Grid;
use crate::random::Lcg;
use crate::units::Length;

#[test]
fn open_surfaces_and_hopeless_spacings_are_refused() {
    let mut mesh = block([0.0; 3], [2.0; 3]);
    mesh.triangles.remove(0);
    let grid = Grid::covering([0.0; 3], [2.0; 3], Length::mm(0.1), 1, [0.0; 3]).unwrap();
    assert_eq!(occupancy(&mesh, &grid).unwrap_err().code(), "E041");
    let tiny = Grid::new([0.0; 3], Length::mm(1e-9), [2, 2, 2]).unwrap();
    assert_eq!(occupancy(&block([0.0; 3], [2.0; 3]), &tiny).unwrap_err().code(), "E041");
    let nothing = voxelize(&TriangleMesh::default(), &grid, Crossings).unwrap();
    assert!(nothing.outer.is_empty() && nothing.density.volume().as_mm3() == 0.0);
}

#[test]
fn the_winding_rule_agrees_with_crossings_on_closed_surfaces() {
    let mesh = sphere(3.0, 4).transformed(Lcg(9).rotation(), [0.1, 0.2, 0.3]);
    let grid = Grid::covering([-3.0; 3], [3.3; 3], Length::mm(0.2), 1, [0.1, 0.2, 0.3]).unwrap();
    let [a, b] = [Crossings, Winding].map(|rule| voxelize(&mesh, &grid, rule).unwrap());
    b.validate().unwrap();
    assert_eq!((&a.inner, &a.centres, &a.outer), (&b.inner, &b.centres, &b.outer));
    for (x, y) in a.density.field().values().iter().zip(b.density.field().values()) {
        assert!((x - y).abs() < 1e-5, "{x} {y}");
    }
    assert_eq!(b.doubt.unwrap().share, 0.0);
}

#[test]
fn tubes_and_torn_balls_are_filled_and_the_doubt_is_said() {
    let mut tube = block([0.0; 3], [12.0, 2.0, 2.0]);
    tube.triangles.drain(0..4); // both ends along x: rows pass through without touching a facet
    let grid = Grid::covering([-6.0, 0.0, 0.0], [18.0, 2.0, 2.0], Length::mm(0.1), 2, [0.3; 3]).unwrap();
    let solid = voxelize(&tube, &grid, Winding).unwrap();
    solid.validate().unwrap();
    let volume = solid.density.volume().as_mm3();
    // Half of all directions leave through the cap seen from its middle; at its edges the caps lie a little inwards.
    assert!((volume - 48.0).abs() < 1.0, "{volume}");
    let doubt = solid.doubt.unwrap();
    assert!(doubt.share > 0.01 && doubt.share < 0.3, "{doubt:?}");
    assert!(doubt.at_mm[0].min(12.0 - doubt.at_mm[0]).abs() < 1.0 && (doubt.winding - 0.5).abs() < 0.1, "{doubt:?}");
    let mut torn = sphere(3.0, 4);
    let mut r = Lcg(2);
    torn.triangles.retain(|_| r.below(40) != 0);
    let solid = solid_by_winding(&torn, 0.15);
    let truth = sphere(3.0, 4).signed_volume();
    assert!((solid.density.volume().as_mm3() / truth - 1.0).abs() < 0.02);
}

fn solid_by_winding(mesh: &TriangleMesh, h: f64) -> Solid {
    let (lo, hi) = mesh.bounds().unwrap();
    let solid = voxelize(mesh, &Grid::covering(lo, hi, Length::mm(h), 1, [0.0; 3]).unwrap(), Winding).unwrap();
    solid.validate().unwrap();
    solid
}

#[test]
fn torn_surfaces_are_classified_like_every_sample_by_itself() {
    let mut r = Lcg(21);
    for n in 0..6 {
        let mut mesh = match n % 3 {
            0 => block([0.0; 3], [5.0, 4.0, 3.0]).joined(&block([1.0; 3], [2.0; 3]).flipped()),
            1 => sphere(2.5, 2),
            _ => sphere(2.5, 2).joined(&block([-1.0; 3], [4.0, 1.0, 1.5])),
        };
        let torn = if n < 3 { 1 } else { 3 };
        for _ in 0..torn {
            let at = r.below(mesh.triangles.len() as u64) as usize;
            mesh.triangles.remove(at);
        }
        let mesh = mesh.transformed(r.rotation(), r.point(-1.0, 1.0));
        let (lo, hi) = mesh.bounds().unwrap();
        let grid = Grid::covering(lo, hi, Length::mm(0.2), 2, r.point(-0.4, 0.4)).unwrap();
        let solid = voxelize(&mesh, &grid, Winding).unwrap();
        let wrong = (0..grid.samples())
            .filter(|&at| {
                let w = winding(&mesh, grid.position(grid.index(at)));
                // The far field is good to 5e-3.
                (w - 0.5).abs() > 0.01 && solid.centres.contains(grid.index(at)) != (w >= 0.5)
            })
            .count();
        // What is not evaluated lies within a few samples of a hole's edge.
        assert!(wrong * 2000 <= grid.samples(), "{n}: {wrong} of {}", grid.samples());
    }
}

/// A box without its largest face: half of what it encloses is in doubt, and none of that is looked at sample by sample.
#[test]
fn what_a_missing_face_leaves_in_doubt_is_counted_as_by_every_sample() {
    let mut r = Lcg(31);
    for (size, h) in [([12.0, 8.0, 3.0], 0.2), ([6.0, 6.0, 6.0], 0.15), ([20.0, 4.0, 2.0], 0.2)] {
        let mut mesh = block([0.0; 3], size);
        mesh.triangles.truncate(10);
        let mesh = mesh.transformed(r.rotation(), r.point(-1.0, 1.0));
        let (lo, hi) = mesh.bounds().unwrap();
        let grid = Grid::covering(lo, hi, Length::mm(h), 2, r.point(-0.4, 0.4)).unwrap();
        let solid = voxelize(&mesh, &grid, Winding).unwrap();
        let (mut doubtful, mut inside, mut wrong) = (0u64, 0u64, 0u64);
        for at in 0..grid.samples() {
            let index = grid.index(at);
            let w = winding(&mesh, grid.position(index));
            let untouched = solid.inner.contains(index) || !solid.outer.contains(index);
            doubtful += u64::from(untouched && (w - 0.5).abs() < 0.25);
            inside += u64::from(w >= 0.5);
            wrong += u64::from((w - 0.5).abs() > 0.01 && solid.centres.contains(index) != (w >= 0.5));
        }
        let doubt = solid.doubt.unwrap();
        let counted = doubt.volume_mm3 / grid.sample_volume().as_mm3();
        // Between two probes that are clear, and in short stretches beside the surface, nobody looks.
        assert!((counted / doubtful as f64 - 1.0).abs() < 0.1, "{size:?} {counted} {doubtful}");
        // Stretches between the rim and what is known beside it are taken for like that.
        let along_rim = 2.0 * (size[0] + size[1]) / h;
        assert!(doubtful > inside / 5 && (wrong as f64) < 2.0 * along_rim, "{size:?} {doubtful} {inside} {wrong}");
    }
}
