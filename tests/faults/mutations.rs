//! Seeded mutations of good files.

use crate::{good, projects};
use amcheck::Error;
use amcheck::error::Place;
use amcheck::geometry::Health;
use amcheck::io::{Loaded, Salvage, read};
use std::panic::catch_unwind;

/// A small generator: multiplier and increment of Knuth's MMIX, the upper bits taken.
pub struct Lcg(pub u64);

impl Lcg {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        self.0 >> 33
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.next() as usize % n.max(1)
    }
}

const WORDS: [&str; 14] = [
    "nan",
    "-inf",
    "1e400",
    "3.4e38",
    "-1",
    "0",
    "4294967296",
    "99999999999999999999",
    "1,5",
    "0x10",
    "",
    "vertex",
    "\u{1b}[31m",
    "endsolid",
];

/// One mutation of a file, chosen by the generator.
pub fn mutate(bytes: &mut Vec<u8>, random: &mut Lcg) {
    let n = bytes.len();
    if n == 0 {
        return;
    }
    let (at, length) = (random.below(n), 1 + random.below(64));
    let end = (at + length).min(n);
    match random.below(12) {
        0 => bytes.truncate(at),
        1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes[at] = random.next() as u8,
        3 => bytes[at..end].fill(0),
        4 => bytes[at..end].fill(0xff),
        5 => {
            bytes.drain(at..end);
        }
        6 => {
            let copy = bytes[at..end].to_vec();
            let to = random.below(n);
            bytes.splice(to..to, copy);
        }
        7 => {
            let noise: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
            bytes.splice(at..at, noise);
        }
        8 => replace_word(bytes, at, WORDS[random.below(WORDS.len())]),
        9 => {
            let value = [f32::NAN, f32::INFINITY, f32::MAX, 1e-42, -0.0][random.below(5)];
            let to = at.min(n.saturating_sub(4));
            bytes.splice(to..(to + 4).min(n), value.to_le_bytes());
        }
        10 => {
            let count = [0, 1, u32::MAX, 0x0100_0000, n as u32 / 50][random.below(5)];
            // Where binary STL counts, and where zip counts.
            let to = [80, n.saturating_sub(12), n.saturating_sub(6), at][random.below(4)].min(n.saturating_sub(4));
            bytes.splice(to..(to + 4).min(n), count.to_le_bytes());
        }
        _ => {
            let to = random.below(n);
            bytes.swap(at, to);
        }
    }
}

/// Puts a word in the place of the one at a byte.
fn replace_word(bytes: &mut Vec<u8>, at: usize, word: &str) {
    let is_word = |b: &u8| b.is_ascii_alphanumeric() || b"+-.".contains(b);
    let start = bytes[..at].iter().rposition(|b| !is_word(b)).map_or(0, |i| i + 1);
    let end = bytes[at..].iter().position(|b| !is_word(b)).map_or(bytes.len(), |i| at + i);
    bytes.splice(start..end.max(start), word.bytes());
}

/// Holds what every reading must keep, whatever the bytes.
fn check(bytes: &[u8], salvage: Salvage) -> Result<Loaded, Error> {
    let result = catch_unwind(|| read("part.stl", bytes, salvage)).expect("a reader panicked");
    match &result {
        Ok(loaded) => {
            let mesh = &loaded.mesh;
            assert!(!mesh.triangles.is_empty());
            assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.vertices.len()));
            assert!(mesh.vertices.iter().flatten().all(|x| x.is_finite()));
            let health = catch_unwind(|| Health::of(mesh)).expect("health panicked");
            assert_eq!(health.facet_body.len(), mesh.triangles.len());
            assert!(health.notices().iter().chain(&loaded.notices).all(|n| !n.message.contains(char::is_control)));
        }
        Err(e) => {
            let text = format!("{e} {} {}", e.place().unwrap_or_default(), e.remedy());
            assert!([4, 5].contains(&e.exit_code()), "{text}");
            assert!(!text.contains(char::is_control) && text.len() < 1000, "{text:?}");
            assert!(!matches!(e, Error::Damaged { place: Place::Whole, .. }), "no place: {text}");
        }
    }
    result
}

/// Mutations of each file; `AMCHECK_MUTATIONS` sets another number for a long run.
fn cases() -> u64 {
    std::env::var("AMCHECK_MUTATIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(300)
}

/// Runs mutations of one file; how many of them were read.
fn run(name: &str, good: &[u8]) -> u64 {
    let mut read = 0;
    for seed in 0..cases() {
        let mut random = Lcg(seed * 2654435761 + name.len() as u64);
        let mut bytes = good.to_vec();
        for _ in 0..1 + random.below(3) {
            mutate(&mut bytes, &mut random);
        }
        let salvage = if seed % 3 == 0 { Salvage::KeepWhole } else { Salvage::Refuse };
        read += u64::from(check(&bytes, salvage).is_ok());
    }
    println!("{name}: {read} of {} were read", cases());
    read
}

#[test]
fn every_mutation_ends_in_a_mesh_or_a_typed_error() {
    let start = std::time::Instant::now();
    let package = good::threemf_package();
    for (name, bytes) in [
        ("stl binary", good::stl_binary()),
        ("stl text", good::stl_text()),
        ("obj", good::obj_text()),
        ("ply text", good::ply_text()),
        ("ply binary", good::ply_binary()),
        ("3mf", package),
    ] {
        let whole = check(&bytes, Salvage::Refuse).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(whole.mesh.triangles.len() >= 36, "{name}");
        let read = run(name, &bytes);
        // Mutations that all fail, or none, would test nothing.
        assert!(0 < read && read < cases(), "{name}: {read}");
    }
    // A guard against a reader that hangs, not a benchmark: 20 s for the 1,800 cases of a plain run.
    assert!(start.elapsed().as_millis() < 12 * 6 * u128::from(cases()), "{:?}", start.elapsed());
}

#[test]
fn every_mutation_of_a_model_part_ends_in_a_mesh_or_a_typed_error() {
    let resources = r#"<object id="2" type="support"><mesh/></object><object id="3"><components><component objectid="1" transform="-1 0 0 0 1 0 0 0 1 9 9 9"/><component objectid="2"/></components></object>"#;
    let text = good::model("unit=\"inch\"", resources, "<item objectid=\"1\"/><item objectid=\"3\"/>");
    let mut read = 0;
    for seed in 0..cases() {
        let mut random = Lcg(seed * 40503 + 17);
        let mut bytes = text.clone().into_bytes();
        for _ in 0..1 + random.below(3) {
            mutate(&mut bytes, &mut random);
        }
        let parts = [("_rels/.rels", good::RELATIONS.as_bytes()), (good::MODEL, bytes.as_slice())];
        read += u64::from(check(&good::package(&parts), Salvage::Refuse).is_ok());
    }
    println!("3mf model part: {read} of {} were read", cases());
    assert!(0 < read && read < cases(), "{read}");
}

#[test]
fn every_mutation_of_a_project_ends_in_a_mesh_or_a_typed_error() {
    let mut read = 0;
    for seed in 0..cases() {
        let mut random = Lcg(seed * 52361 + 29);
        let mut parts = projects::bambu();
        let which = 1 + random.below(parts.len() - 1);
        for _ in 0..1 + random.below(3) {
            mutate(&mut parts[which].1, &mut random);
        }
        let parts: Vec<(&str, &[u8])> = parts.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
        read += u64::from(check(&good::package(&parts), Salvage::Refuse).is_ok());
    }
    println!("3mf project: {read} of {} were read", cases());
    assert!(0 < read && read < cases(), "{read}");
}

#[test]
fn every_cut_of_every_file_ends_in_a_mesh_or_a_typed_error() {
    for bytes in [good::stl_binary(), good::ply_binary(), good::threemf_package(), good::obj_text()] {
        for cut in (0..bytes.len()).step_by(7) {
            let _ = check(&bytes[..cut], Salvage::Refuse);
        }
    }
}

#[test]
fn every_mutation_of_a_path_ends_in_strokes_or_a_typed_error() {
    let gcode: &[u8] = b"G28\nG21 G90\nM83\nG92 E0\nG1 X10 Y5 Z0.2 F1800 ; go\nG1 X20 E1.5\nG3 X10 Y15 I-10 J0 E2\nG2 X0 Y5 R10 E.5*71\nM117 done\n";
    let points: &[u8] = b"# a path\n0 0 0\n1.5 0 0\n\n2 2 2\n3e0 -2 2.25\n";
    for seed in 0..2 * cases() {
        let mut random = Lcg(seed * 69069 + 5);
        let mut bytes = if seed % 2 == 0 { gcode.to_vec() } else { points.to_vec() };
        for _ in 0..1 + random.below(3) {
            mutate(&mut bytes, &mut random);
        }
        let read = if seed % 2 == 0 { amcheck::io::gcode::read } else { amcheck::io::toolpath::read_points };
        match catch_unwind(|| read(&bytes)).expect("a reader panicked") {
            Ok(path) => assert!(path.length_mm().is_finite() && !path.strokes.is_empty()),
            Err(e) => assert!([4, 5].contains(&e.exit_code()) && !e.to_string().contains(char::is_control), "{e}"),
        }
    }
}
