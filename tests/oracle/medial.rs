//! Walls, gaps, pins, holes and wedges on the mesh.

use crate::random::Random;
use amcheck::geometry::Adjacency;
use amcheck::geometry::{MeshDistance, TriangleMesh, cuboid, extruded, revolved};
use amcheck::medial::crease::{Sharpness, creases};
use amcheck::medial::rod::{End, Rod, Search, Wanted};
use amcheck::medial::{Cover, Features, Question, Shape, Side};
use std::f64::consts::PI;

/// What turning and shifting by 30 mm may do to a length in double precision, with room.
const ROUNDING: f64 = 1e-9;

/// Least lower bound and least ball of the sheets of a mesh, up to a width.
fn thinnest(mesh: &TriangleMesh, side: Side, up_to: f64) -> Option<(f64, f64)> {
    let question = Question {
        limits: vec![up_to],
        notice: 1.25 * up_to,
        tolerance: 1e-9,
        agree: Question::agree_for(up_to),
        finest: Question::finest_for(up_to),
        budget: 1 << 20,
    };
    let cover = Cover::search(&MeshDistance::new(mesh), &Features::new(mesh, side, |_| true), &question);
    let sheets = || cover.samples.iter().filter(|s| s.shape == Shape::Sheet);
    let low = sheets().map(|s| s.low).chain(cover.unresolved.iter().map(|u| u.low)).reduce(f64::min)?;
    Some((low, sheets().map(|s| s.diameter).reduce(f64::min)?))
}

fn rods(mesh: &TriangleMesh, side: Side, within: f64) -> Vec<Rod> {
    let (distance, next) = (MeshDistance::new(mesh), Adjacency::of(mesh, |_| true));
    Search { mesh, distance: &distance, next: &next, wanted: Wanted { side, within, elongation: 1.5 } }
        .run(|_| true)
        .rods
}

#[test]
fn slabs_and_gaps_are_as_thick_as_they_are() {
    let mut r = Random(1);
    let mut violated = Vec::new();
    for case in 0..4000 {
        let t = r.between(0.02, 2.0);
        let [a, b] = [0; 2].map(|_| t + r.between(0.5, 10.0));
        let (side, mesh) = if case % 2 == 0 {
            (Side::Material, cuboid([0.0; 3], [a, b, t]))
        } else {
            let upper = cuboid([0.0, 0.0, 3.0 + t], [a, b, 6.0 + t]);
            (Side::Void, cuboid([0.0; 3], [a, b, 3.0]).joined(&upper))
        };
        match thinnest(&r.moved(&mesh), side, 1.2 * t) {
            Some((low, high)) if low <= t + ROUNDING && t <= high + ROUNDING => {}
            other => violated.push((case, t, other)),
        }
    }
    assert!(violated.is_empty(), "{} of 4000: {:?}", violated.len(), &violated[..violated.len().min(5)]);
}

#[test]
fn leaning_walls_are_measured_along_their_normal() {
    let mut r = Random(2);
    let mut violated = 0;
    for _ in 0..500 {
        // A prism whose section is a parallelogram: t is the distance of its long sides. Its acute angles are above 60°: no wedges.
        let (t, lean) = (r.between(0.1, 1.0), r.between(1.1, 1.5));
        let width = t / lean.sin();
        let mut mesh = cuboid([0.0; 3], [width, 8.0, 6.0]);
        mesh.vertices.iter_mut().for_each(|v| v[0] += v[2] / lean.tan());
        let found = thinnest(&r.moved(&mesh), Side::Material, 1.2 * t);
        violated += usize::from(!found.is_some_and(|(low, high)| low <= t + ROUNDING && t <= high + ROUNDING));
    }
    assert_eq!(violated, 0);
}

#[test]
fn pins_have_the_area_of_their_polygon() {
    let mut r = Random(3);
    for case in 0..1500 {
        let (n, radius, height) = (r.whole(5, 60), r.between(0.1, 2.0), r.between(1.2, 8.0));
        let height = 2.0 * radius * height.max(1.2);
        let foot = radius + r.between(2.0, 5.0);
        let outline =
            [[0.0, 0.0], [foot, 0.0], [foot, 2.0], [radius, 2.0], [radius, 2.0 + height], [0.0, 2.0 + height]];
        let mesh = r.moved(&revolved(&outline, n));
        let n = n as f64;
        let diameter = 2.0 * radius * (n * (2.0 * PI / n).sin() / (2.0 * PI)).sqrt();
        let found = rods(&mesh, Side::Material, 1.1 * 2.0 * radius);
        let pin = found.iter().find(|p| p.length > p.diameter() && p.ends.contains(&End::Closed));
        let pin = pin.unwrap_or_else(|| panic!("{case}: no pin of {diameter} with {n} sides: {found:?}"));
        let s = &pin.narrowest;
        assert!((pin.diameter() - diameter).abs() < 1e-6 * diameter, "{case}: {} {diameter}", pin.diameter());
        assert!(s.inscribed <= 2.0 * radius * (PI / n).cos() + 1e-6 && s.circumscribed >= 2.0 * radius - 1e-6);
        assert!(s.inscribed <= diameter && diameter <= s.circumscribed, "{case}: {s:?}");
        assert!((pin.length - height).abs() <= 0.02 * diameter, "{case}: {} {height}", pin.length);
    }
}

#[test]
fn tilted_holes_have_the_area_of_their_polygon() {
    let mut r = Random(4);
    for case in 0..1500 {
        let (n, radius, depth) = (r.whole(6, 60), r.between(0.1, 2.0), r.between(0.3, 5.0));
        let blind = case % 2 == 1;
        let depth = if blind { 2.2 * radius + depth } else { depth };
        let rim = radius + r.between(1.0, 4.0);
        let bottom = -r.between(0.5, 3.0);
        let through = vec![[radius, 0.0], [rim, 0.0], [rim, depth], [radius, depth]];
        let pocket = vec![[0.0, bottom], [rim, bottom], [rim, depth], [radius, depth], [radius, 0.0], [0.0, 0.0]];
        let mesh = r.moved(&revolved(if blind { &pocket } else { &through }, n));
        let n = n as f64;
        let diameter = 2.0 * radius * (n * (2.0 * PI / n).sin() / (2.0 * PI)).sqrt();
        let found = rods(&mesh, Side::Void, 2.2 * radius);
        assert_eq!(found.len(), 1, "{case}: {blind} {diameter} {depth} {found:?}");
        let hole = &found[0];
        assert!((hole.diameter() - diameter).abs() < 1e-6 * diameter, "{case}: {} {diameter}", hole.diameter());
        assert!(hole.narrowest.inscribed <= diameter && diameter <= hole.narrowest.circumscribed);
        assert_eq!(hole.ends.contains(&End::Closed), blind, "{case}: {:?}", hole.ends);
        assert!((hole.length - depth).abs() <= 0.04 * diameter, "{case}: {} {depth}", hole.length);
    }
}

#[test]
fn wedges_have_their_angle_and_depth() {
    let mut r = Random(5);
    for case in 0..1500 {
        let degrees = r.between(2.0, 59.0);
        let half = 10.0 * (0.5 * degrees).to_radians().tan();
        let mesh = r.moved(&extruded(&[[0.0, 0.0], [10.0, -half], [10.0, half]], &[[0, 1, 2]], 8.0));
        let thick = r.between(0.1, 0.2);
        let next = Adjacency::of(&mesh, |_| true);
        let sought = Sharpness { widest: PI / 3.0, thick, blunt: 0.05 * thick, step: 1e-9 };
        let found = creases(&mesh, &MeshDistance::new(&mesh), &next, sought);
        assert_eq!(found.len(), 1, "{case}: {degrees}");
        assert!((found[0].angle.to_degrees() - degrees).abs() < 1e-6, "{case}: {degrees} {found:?}");
        let depth = 0.5 * thick / (0.5 * degrees.to_radians()).sin();
        assert!(
            (found[0].depth / depth - 1.0).abs() < 0.01 && found[0].thickness <= thick + ROUNDING,
            "{case}: {found:?} {depth}"
        );
    }
}
