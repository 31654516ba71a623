//! The same part in other clothes: format, order of facets, place, quarter turn.

use crate::{fixtures, judge_bytes, judge_mesh, process};
use amcheck::analyze::Options;
use amcheck::check::{Basis, Finding};
use amcheck::geometry::TriangleMesh;
use amcheck::geometry::vector::Vec3;
use amcheck::io::{Salvage, obj, ply, read, stl, threemf};
use amcheck::report::Report;

/// Fixtures with walls, gaps, slopes, several bodies and a hole in the mesh.
const PARTS: [&str; 6] = ["finned_bracket", "slits_015", "pair_010", "wall_111_024", "table_hanging", "block_open"];

fn mesh_of(name: &str) -> TriangleMesh {
    read(name, &fixtures::bytes(name), Salvage::Refuse).expect("a fixture").mesh
}

fn fdm() -> Options {
    Options::new(process("fdm", &[]))
}

/// What is exact comes from other corners first and differs in the last digits that are printed.
const DIGITS: f64 = 1e-5;

/// The same states, exact values that differ by at most the share `close`, others each in the bracket of the other, and places that
/// differ by at most a sample once they are carried over.
#[track_caller]
pub fn same(name: &str, a: &Report, b: &Report, close: f64, carry: impl Fn(Vec3) -> Vec3) {
    assert_eq!(a.verdict, b.verdict, "{name}");
    let h = a.grid.spacing_mm;
    for (ca, cb) in a.checks.iter().zip(&b.checks) {
        let what = format!("{name} {}", ca.name);
        assert_eq!((ca.state, ca.findings.len()), (cb.state, cb.findings.len()), "{what}");
        for (f, g) in ca.findings.iter().zip(&cb.findings) {
            assert_eq!((f.state, f.count, f.basis), (g.state, g.count, g.basis), "{what}");
            let tolerance = close * f.value.abs().max(1.0);
            let holds = |f: &Finding, x: f64| f.low - tolerance <= x && x <= f.high + tolerance;
            let agree = (f.value - g.value).abs() <= tolerance;
            let agree = agree || (f.basis != Basis::Exact && holds(f, g.value) && holds(g, f.value));
            assert!(agree, "{what}: {} {}", f.value, g.value);
            // A value that is the same all along a wall has no one place: it lies in the box of the finding.
            let p = carry(f.at_mm);
            let reach = (0..3).all(|x| p[x] >= g.box_mm[0][x] - h && p[x] <= g.box_mm[1][x] + h);
            assert!(reach, "{what}: {p:?} {:?}", g.box_mm);
        }
    }
}

#[test]
fn every_format_gets_the_same_findings() {
    for name in PARTS {
        let mesh = mesh_of(name);
        let written = |write: fn(&TriangleMesh, &mut dyn std::io::Write) -> std::io::Result<()>| {
            let mut bytes = Vec::new();
            write(&mesh, &mut bytes).expect("memory takes it");
            bytes
        };
        let files = [
            ("stl", written(stl::write)),
            ("3mf", written(threemf::write)),
            ("obj", written(obj::write)),
            ("ply", written(ply::write)),
        ];
        let reports =
            files.map(|(suffix, bytes)| judge_bytes(&format!("part.{suffix}"), &bytes, &fdm()).expect(suffix));
        for other in &reports[1..] {
            same(name, &reports[0], other, DIGITS, |p| p);
        }
    }
}

#[test]
fn the_order_of_facets_changes_no_finding() {
    for name in PARTS {
        let mut mesh = mesh_of(name);
        let at_rest = judge_mesh(mesh.clone(), &fdm());
        let mut state = 7u64;
        for i in (1..mesh.triangles.len()).rev() {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            mesh.triangles.swap(i, (state >> 33) as usize % (i + 1));
            mesh.triangles[i].rotate_left((state >> 20) as usize % 3);
        }
        let shuffled = judge_mesh(mesh, &fdm());
        assert_eq!((&at_rest.verdict, &at_rest.checks), (&shuffled.verdict, &shuffled.checks), "{name}");
    }
}

#[test]
fn a_metre_away_and_a_quarter_turn_on_the_findings_are_the_same() {
    let upright = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let quarter = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    for name in PARTS {
        let at_rest = judge_mesh(mesh_of(name), &fdm());
        let shift = [1000.0, -1000.0, 1000.0];
        let away = judge_mesh(mesh_of(name).transformed(upright, shift), &fdm());
        same(name, &at_rest, &away, DIGITS, |p| [0, 1, 2].map(|a| p[a] + shift[a]));
        let turned = judge_mesh(mesh_of(name).transformed(quarter, [0.0; 3]), &fdm());
        same(name, &at_rest, &turned, DIGITS, |p| [-p[1], p[0], p[2]]);
    }
}
