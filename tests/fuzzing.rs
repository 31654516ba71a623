//! The fuzz targets on seeded mutations: what a fuzzer looks for by the hour is looked for a little on every run.
#![cfg(feature = "report")]

#[path = "fuzz/targets.rs"]
mod targets;

use std::panic::catch_unwind;

/// A small generator: multiplier and increment of Knuth's MMIX, the upper bits taken.
struct Lcg(u64);

impl Lcg {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

/// Runs of each seed; `AMCHECK_MUTATIONS` sets another number for a long run.
fn cases() -> u64 {
    std::env::var("AMCHECK_MUTATIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(300)
}

/// One to four bytes, words or stretches changed.
fn mutated(seed: &[u8], random: &mut Lcg) -> Vec<u8> {
    const WORDS: [&str; 12] =
        ["nan", "-", "1e999", "mm", "deg", "=", ",", ":", "\"", "[limits.thin-wall]", "4294967296", "\u{1b}é"];
    let mut bytes = seed.to_vec();
    for _ in 0..1 + random.below(4) {
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(24)).min(bytes.len());
        match random.below(6) {
            0 => bytes.truncate(at),
            1 if !bytes.is_empty() => bytes[at] = random.below(256) as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            4 => drop(bytes.splice(at..at, WORDS[random.below(WORDS.len())].bytes())),
            _ => bytes[at..end].iter_mut().for_each(|b| *b ^= 0x55),
        }
    }
    bytes
}

fn run(name: &str, target: fn(&[u8]), seeds: &[&[u8]]) {
    for (s, seed) in seeds.iter().enumerate() {
        target(seed);
        for case in 0..cases() {
            let mut random = Lcg(case * 2654435761 + 40503 * s as u64 + name.len() as u64);
            let bytes = mutated(seed, &mut random);
            if catch_unwind(|| target(&bytes)).is_err() {
                panic!("{name}, seed {s}, case {case}: {:?}", String::from_utf8_lossy(&bytes));
            }
        }
    }
}

#[test]
fn profiles_hold() {
    run(
        "profile",
        targets::profile,
        &[
            b"inherits = \"fdm\"\ntitle = \"mine\"\n[machine]\nbuild_volume_mm = [200, 200, 180]\nlayer_height_mm = 0.2\n",
            b"inherits = \"sla\"\n[limits.thin-wall]\nfail = \"0.4mm\"\nwarn = \"0.6mm\"\nsource = \"ours\"\n[limits.overhang]\nwarn = \"45deg\"\n",
            include_bytes!("../src/process/builtin/lpbf.toml"),
        ],
    );
}

#[test]
fn tools_hold() {
    run(
        "tool",
        targets::tool,
        &[
            include_bytes!("../src/process/builtin/tools/ball-mill-6.toml"),
            b"title = \"hook\"\nmesh = \"hook.stl\"\n[[sharp]]\nname = \"tip\"\nat_mm = [0, 0.5, -1e1]\n",
            b"[[piece]]\nrole = \"cutter\"\nshape = \"cone\"\ndiameter_mm = 1\nupper_diameter_mm = 3\nlength_mm = 6\n\
              [[piece]]\nrole = \"holder\"\ndiameter_mm = 40\nlength_mm = 60\nfrom_mm = 12\n",
        ],
    );
}

#[test]
fn what_a_parser_quotes_is_escaped() {
    // Found by a long run: the error of a role that holds a carriage return held it, too; only the command escaped it.
    for word in ["hold\\r", "\\u001b[2J"] {
        targets::tool(format!("[[piece]]\nrole = \"{word}\"\ndiameter_mm = 6\nlength_mm = 5\n").as_bytes());
        targets::tool(format!("\"{word}\" = 1\n").as_bytes());
        targets::acceptances(format!("[[accept]]\n\"{word}\" = 1\n").as_bytes());
        targets::profile(format!("inherits = \"fdm\"\n\"{word}\" = 1\n").as_bytes());
        targets::profile(format!("inherits = \"{word}\"\n").as_bytes());
    }
}

#[test]
fn acceptances_hold() {
    run(
        "acceptances",
        targets::acceptances,
        &[b"[[accept]]\ncheck = \"thin-wall\"\nat_mm = [40.2, 4.5, 16.5]\nno_worse_than = 0.45\nreason = \"a hinge\"\nuntil = 2027-06-30\n\
            [[accept]]\ncheck = \"narrow-gap\"\nbox_mm = [[0, 0, 0], [1, 2, 3]]\nreason = \"meant\"\n"],
    );
}

#[test]
fn options_hold() {
    run(
        "options",
        targets::options,
        &[b"0.4mm\n400um\n45deg\n1.2 rad\nball:2mm\nbox:2x1x1mm\ncylinder:r1h3mm\ncone:r2r0.5h3mm\n2/8\nthin-wall=0.4mm,0.6mm\noverhang=45deg"],
    );
}

#[test]
fn meshes_become_voxels() {
    // Corners of a cube and of a facet that crosses it, as the target reads them.
    let corner = |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 1 { 16_384i16 } else { -16_384 });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let cube = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).flatten().flat_map(corner);
    let closed: Vec<u8> = cube.flat_map(i16::to_le_bytes).collect();
    let crossing =
        [closed.clone(), [-20_000i16, 0, 0, 20_000, 1, 0, 0, 3, 20_000].map(i16::to_le_bytes).concat()].concat();
    run("voxels", targets::mesh_to_voxels, &[&closed, &crossing]);
}

#[test]
fn readers_hold_on_each_others_files() {
    let stl = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\nf -3 -2 -1\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let path = "G21 G90\nM83\nG1 X10 Y5 Z0.2 F1800\nG1 X20 E1.5\nG3 X10 Y15 I-10 J0 E2\n0 0 0\n1 2 3\n";
    let seeds = [stl, obj, ply, path].map(str::as_bytes);
    for (name, target) in [
        ("stl", targets::read_stl as fn(&[u8])),
        ("obj", targets::read_obj),
        ("ply", targets::read_ply),
        ("3mf", targets::read_threemf),
        ("path", targets::read_path),
    ] {
        run(name, target, &seeds);
    }
}
