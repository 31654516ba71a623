//! The faults of files in the wild, row by row.

use crate::good::{self, MODEL, RELATIONS};
use amcheck::Error;
use amcheck::geometry::Health;
use amcheck::io::{Loaded, Salvage, read, read_path};
use std::path::Path;

fn load(bytes: &[u8]) -> Result<Loaded, Error> {
    read("part.stl", bytes, Salvage::Refuse)
}

/// Refused with exit code 4, with this word in message, place or remedy.
#[track_caller]
fn refused(bytes: &[u8], word: &str) {
    let e = load(bytes).expect_err(word);
    let text = format!("{e} @{} {}", e.place().unwrap_or_default(), e.remedy());
    assert!(e.exit_code() == 4 && text.contains(word), "{word}: {} {text}", e.exit_code());
}

/// Refused with exit code 5.
#[track_caller]
fn too_large(bytes: &[u8]) {
    let e = load(bytes).expect_err("too large");
    assert_eq!(e.exit_code(), 5, "{e}");
}

/// Read, with exactly these notices beside the one about the suffix.
#[track_caller]
fn noticed(bytes: &[u8], codes: &[&str]) -> Loaded {
    let loaded = load(bytes).unwrap_or_else(|e| panic!("{e}"));
    let found: Vec<&str> = loaded.notices.iter().map(|n| n.code.as_str()).filter(|c| *c != "wrong-suffix").collect();
    assert_eq!(found, codes);
    loaded
}

#[test]
fn any_file() {
    let fails = |path: &str| read_path(Path::new(path), 1 << 20, Salvage::Refuse).unwrap_err();
    assert_eq!(fails("no/such/part.stl").exit_code(), 4);
    assert!(fails(env!("CARGO_MANIFEST_DIR")).to_string().contains("directory"));
    assert!(fails(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.tom")).remedy().contains("Cargo.toml"));
    refused(b"", "0 bytes");
    refused(b"ISO-10303-21;\nHEADER;\n", "STEP");
    refused(b"; sliced\nG28\nG1 X0 Y0\nG1 X1 Y1\nM104 S200\nG1 X2\n", "G-code");
    refused(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "PNG");
    refused(b"<!doctype html>\n<html><body>log in</body></html>", "HTML");
    refused(b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n", "git lfs pull");
    refused(b"\x1f\x8b\x08\0\0\0\0\0", "unpack");
    refused(&good::package(&[("part.stl", &good::stl_binary())]), "part.stl");
    let as_stl = load(&good::threemf_package()).unwrap();
    assert_eq!(as_stl.notices[0].code, "wrong-suffix");
}

#[test]
#[cfg(unix)]
fn pipes_and_vast_files_are_refused_and_odd_names_work() {
    use std::os::unix::ffi::OsStrExt;
    let dir = std::env::temp_dir().join(format!("amcheck-rows-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let odd = dir.join(std::ffi::OsStr::from_bytes(b"part #1 \xff.stl"));
    std::fs::write(&odd, good::stl_binary()).unwrap();
    assert!(read_path(&odd, 1 << 20, Salvage::Refuse).is_ok());
    let vast = dir.join("vast.stl");
    std::fs::File::create(&vast).unwrap().set_len(20 << 30).unwrap();
    assert_eq!(read_path(&vast, 4 << 30, Salvage::Refuse).unwrap_err().exit_code(), 5);
    let pipe = dir.join("pipe");
    if std::process::Command::new("mkfifo").arg(&pipe).status().is_ok_and(|s| s.success()) {
        assert_eq!(read_path(&pipe, 1 << 20, Salvage::Refuse).unwrap_err().exit_code(), 4);
    }
    assert_eq!(read_path(Path::new("/dev/zero"), 1 << 20, Salvage::Refuse).unwrap_err().exit_code(), 4);
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn a_file_that_changes_while_it_is_read_is_refused() {
    let folder = std::env::temp_dir().join(format!("amcheck-changing-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("growing.stl");
    std::fs::write(&path, vec![b' '; 24 << 20]).unwrap();
    let done = std::sync::atomic::AtomicBool::new(false);
    let order = std::sync::atomic::Ordering::Relaxed;
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
            // Longer and shorter in turn, about once in the time that a tenth of the reading takes.
            for turn in (0..).take_while(|_| !done.load(order)) {
                file.set_len((24 << 20) + [1, 4096, 1 << 20][turn % 3]).unwrap();
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
        });
        let start = std::time::Instant::now();
        let mut seen = false;
        while !seen && start.elapsed().as_secs() < 60 {
            let e = read_path(&path, 1 << 30, Salvage::Refuse).unwrap_err();
            seen = e.to_string().contains("changed while it was read");
            assert!(e.exit_code() == 4 && (seen || !matches!(e, Error::CannotRead { .. })), "{e}");
        }
        done.store(true, order);
        assert!(seen, "no reading met a change");
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn stl_binary() {
    let good = good::stl_binary();
    let n = good::mesh().triangles.len() as u32;
    let with = |at: usize, bytes: &[u8]| {
        let mut out = good.clone();
        out[at..at + bytes.len()].copy_from_slice(bytes);
        out
    };
    noticed(&with(0, b"solid cube facet normal"), &[]);
    refused(&with(80, &u32::MAX.to_le_bytes()), "byte 80");
    refused(&with(80, &(n + 1).to_le_bytes()), "byte 80");
    refused(&with(80, &n.to_be_bytes()), "big-endian");
    noticed(&with(80, &(n - 1).to_le_bytes()), &["count-mismatch"]);
    refused(&good[..84], "byte 80");
    refused(&[0; 84], "no triangles");
    refused(&good[..good.len() - 20], "ends inside");
    noticed(&[good.as_slice(), &[0]].concat(), &["trailing-bytes"]);
    refused(&good[..50], "84");
    noticed(&with(84 + 48, &[0x12, 0x34]), &[]);
    refused(&with(84 + 50 + 12, &f32::NAN.to_le_bytes()), "facet 2");
    refused(&with(84 + 50 + 12, &f32::INFINITY.to_le_bytes()), "range");
    refused(&with(84 + 50 + 12, &(-3.4e38f32).to_le_bytes()), "range");
    noticed(&with(84, &f32::NAN.to_le_bytes().repeat(3)), &[]);
    noticed(&with(0, &[0xff; 80]), &[]);
    let mut tiny = Vec::new();
    amcheck::io::stl::write(&good::mesh().scaled(1e-31), &mut tiny).unwrap();
    refused(&tiny, "no extent");
    for bytes in [with(84 + 12, &f32::NAN.to_le_bytes()), with(80, &(n + 9).to_le_bytes())] {
        let kept = read("part.stl", &bytes, Salvage::KeepWhole).unwrap();
        assert!(kept.notices.iter().any(|n| n.code == "salvaged") && kept.mesh.triangles.len() as u32 >= n - 1);
    }
}

#[test]
fn stl_text() {
    let text = String::from_utf8(good::stl_text()).unwrap();
    let facets = good::mesh().triangles.len();
    for variant in [
        text.replace('\n', "\r"),
        text.replace('\n', "\r\n"),
        text.replace(' ', "\t"),
        text.to_uppercase(),
        format!("\u{feff}{text}"),
        text.replace("two cubes", "\u{1b}[2J"),
        text.replacen("solid two cubes", "solid", 1),
    ] {
        assert_eq!(noticed(variant.as_bytes(), &[]).mesh.triangles.len(), facets);
    }
    noticed(text.replace("endsolid two cubes", "").as_bytes(), &["no-endsolid"]);
    let first_vertex = text.lines().nth(3).unwrap();
    let with = |line: &str| text.replacen(first_vertex, line, 1);
    refused(&text.as_bytes()[..text.find(first_vertex).unwrap() + 15], "line 4");
    refused(with("").as_bytes(), "line 7");
    refused(with("vertex 1 2 3\nvertex 4 5 6").as_bytes(), "line 7");
    refused(with("vertex 1,5 2 3").as_bytes(), "locale");
    for bad in ["1e400", "0x10", "nan"] {
        refused(with(&format!("vertex {bad} 0 0")).as_bytes(), "line 4");
    }
    let two = [text.as_bytes(), text.replace("vertex ", "vertex 1").as_bytes()].concat();
    assert_eq!(noticed(&two, &[]).mesh.triangles.len(), 2 * facets);
    too_large(&[b"solid ", vec![b'a'; 17 << 20].as_slice(), b"\nfacet"].concat());
    let bare: String =
        text.lines().map(|l| if l.contains("normal") { "facet\n".into() } else { format!("{l}\n") }).collect();
    noticed(bare.as_bytes(), &["no-normal"]);
}

#[test]
fn obj() {
    const V: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let with = |faces: &str| format!("{V}{faces}").into_bytes();
    refused(&with("f 1 2 5\n"), "line 5");
    refused(&with("f 0 1 2\n"), "line 5");
    noticed(&with("f -1 -2 -3\n"), &[]);
    let dart = b"v 0 0 0\nv 4 -2 0\nv 1 0 0\nv 4 2 0\nf 1 2 3 4\n";
    assert_eq!(noticed(dart, &[]).mesh.area(), 2.0);
    noticed(format!("mtllib ../../etc/passwd\nf 1 2 3\n{V}").as_bytes(), &[]);
    refused(&with("l 1 2\np 3\n"), "no faces");
    let wide: Vec<u8> = with("f 1 2 3\n").iter().flat_map(|&b| [0, b]).collect();
    noticed(&[&[0xfe, 0xff][..], &wide].concat(), &[]);
    noticed(&wide, &[]);
    refused(b"v 3.4e38 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "range");
}

#[test]
fn ply() {
    let text = String::from_utf8(good::ply_text()).unwrap();
    let with = |from: &str, to: &str| text.replacen(from, to, 1).into_bytes();
    refused(&with("element vertex 24", "element vertex 1000000000000"), "1000000000000");
    refused(&with("\n3 0 2 3\n", "\n2147483648 0 2 3\n"), "2147483648");
    refused(&with("\n3 0 2 3\n", "\n-3 0 2 3\n"), "-3");
    refused(&with("\n3 0 2 3\n", "\n3 0 2 24\n"), "vertex 24 of 24");
    refused(&with("property uchar red", "property uc\0har red"), "NUL");
    noticed(&with("comment", "comment \u{e9}\u{1b}"), &[]);
    noticed(text.replace('\n', "\r\n").as_bytes(), &[]);
    refused(b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n", "no faces");
}

#[test]
fn threemf_packages() {
    let model = good::model("", "", "<item objectid=\"1\"/>");
    let rels = |text: &str| good::package(&[("_rels/.rels", text.as_bytes()), (MODEL, model.as_bytes())]);
    noticed(&rels(RELATIONS), &[]);
    refused(b"<?xml version=\"1.0\"?><model/>", "package");
    refused(&rels("<Relationships/>"), "names no model");
    let twice = RELATIONS.replace("</Relationships>", "<Relationship Target=\"/3D/3dmodel.model\" Id=\"s\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>");
    refused(&rels(&twice), "2 models");
    refused(&rels(&RELATIONS.replace("3dmodel.model", "none.model")), "is not there");

    let parts = [("_rels/.rels", RELATIONS.as_bytes()), (MODEL, model.as_bytes()), ("x", b"xyz")];
    let stored = good::stored(&parts);
    let find = |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).position(|w| w == what).unwrap();
    let mut damaged = stored.clone();
    damaged[find(&stored, b"<vertex x")] = b'[';
    refused(&damaged, MODEL);
    let escaping =
        good::package(&[("_rels/.rels", RELATIONS.as_bytes()), ("../../evil", b"x"), (MODEL, model.as_bytes())]);
    refused(&escaping, "leads out");
    let cases =
        good::package(&[("a", b"x"), ("A", b"y"), ("_rels/.rels", RELATIONS.as_bytes()), (MODEL, model.as_bytes())]);
    refused(&cases, "one name");
    let doubled =
        good::stored(&[("aa", b"x"), ("ab", b"y"), ("_rels/.rels", RELATIONS.as_bytes()), (MODEL, model.as_bytes())]);
    let same: Vec<u8> =
        String::from_utf8_lossy(&doubled).contains("ab").then(|| replaced(&doubled, b"ab", b"aa")).unwrap();
    refused(&same, "twice");
    // The flag of encryption stands six bytes into a local head and eight into a record of the directory.
    let mut encrypted = stored.clone();
    let record = find(&stored, b"PK\x01\x02");
    let second = record + 46 + 11;
    let shift = find(&stored[second..], b"PK\x01\x02");
    encrypted[second + shift + 8] |= 1;
    refused(&encrypted, "encrypt");
}

/// The bytes with every occurrence of one word replaced by another of the same length.
fn replaced(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for at in 0..=bytes.len() - from.len() {
        if &bytes[at..at + from.len()] == from {
            out[at..at + from.len()].copy_from_slice(to);
        }
    }
    out
}

#[test]
fn threemf_bombs() {
    let model = good::model("", "", "<item objectid=\"1\"/>");
    let spaces = model.replace("<resources>", &format!("<resources>{}", " ".repeat(20 << 20)));
    too_large(&good::with_model(&spaces));
    // The third record of the directory points at the bytes of the second.
    let parts =
        [("_rels/.rels", RELATIONS.as_bytes()), (MODEL, model.as_bytes()), ("zzzzzzzzzzzzzzzz", model.as_bytes())];
    let stored = good::stored(&parts);
    let records: Vec<usize> = (0..stored.len() - 4).filter(|&i| &stored[i..i + 4] == b"PK\x01\x02").collect();
    let mut overlapping = stored.clone();
    let offset = stored[records[1] + 42..records[1] + 46].to_vec();
    overlapping[records[2] + 42..records[2] + 46].copy_from_slice(&offset);
    too_large(&overlapping);
    let doubling: String = (2..34)
        .map(|i| {
            let inner = format!("<component objectid=\"{}\"/>", i - 1);
            format!("<object id=\"{i}\"><components>{inner}{inner}</components></object>")
        })
        .collect();
    too_large(&good::with_model(&good::model("", &doubling, "<item objectid=\"33\"/>")));
    let empty = doubling.replacen("objectid=\"1\"", "objectid=\"99\"", 2) + "<object id=\"99\"><mesh/></object>";
    too_large(&good::with_model(&good::model("", &empty, "<item objectid=\"33\"/>")));
}

#[test]
fn threemf_models() {
    let with =
        |attributes: &str, resources: &str, build: &str| good::with_model(&good::model(attributes, resources, build));
    const ITEM: &str = "<item objectid=\"1\"/>";
    let dtd = good::model("", "", ITEM).replacen("<model", "<!DOCTYPE m [<!ENTITY a \"b\">]><model", 1);
    refused(&good::with_model(&dtd), "DTD");
    refused(&with("", &"<a>".repeat(100_000), ITEM), "deeper");
    refused(&with("", "", "<item objectid=\"7\"/>"), "object 7");
    let ring = "<object id=\"2\"><components><component objectid=\"3\"/></components></object><object id=\"3\"><components><component objectid=\"2\"/></components></object>";
    refused(&with("", ring, "<item objectid=\"2\"/>"), "holds itself");
    let item = |transform: &str| with("", "", &format!("<item objectid=\"1\" transform=\"{transform}\"/>"));
    refused(&item("1 0 0 0 1 0 0 0 0 0 0 0"), "singular");
    refused(&item("nan 0 0 0 1 0 0 0 1 0 0 0"), "nan");
    refused(&item("1,5 0 0 0 1 0 0 0 1 0 0 0"), "locale");
    refused(&item("1 0 0"), "12");
    refused(&item("1e300 0 0 0 1 0 0 0 1 0 0 0"), "range");
    let mirrored = noticed(&item("-1 0 0 0 1 0 0 0 1 0 0 0"), &[]);
    // The tetrahedron has edges of 6, so 36 mm³; f64 holds it exactly.
    assert_eq!(Health::of(&mirrored.mesh).shells[0].volume_mm3, 36.0);
    for (unit, mm) in [("micron", 0.001), ("centimeter", 10.0), ("inch", 25.4), ("foot", 304.8), ("meter", 1000.0)] {
        assert_eq!(noticed(&with(&format!("unit=\"{unit}\""), "", ITEM), &[]).unit_mm, Some(mm));
    }
    refused(&with("unit=\"furlong\"", "", ITEM), "furlong");
    let required = |ns: &str| with(&format!("requiredextensions=\"p\" xmlns:p=\"{ns}\""), "", ITEM);
    refused(&required("http://schemas.microsoft.com/3dmanufacturing/production/alternatives/2021/04"), "alternatives");
    refused(&required("http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"), "beamlattice");
    noticed(&required("http://schemas.microsoft.com/3dmanufacturing/material/2015/02"), &[]);
    refused(&with("", good::TETRAHEDRON, ITEM), "number 1");
    refused(&with("", "", "<item objectid=\"1\" objectid=\"1\"/>"), "line");
    let comma = good::model("", "", ITEM).replacen("x=\"6\"", "x=\"6,0\"", 1);
    refused(&good::with_model(&comma), "locale");
    let past = good::model("", "", ITEM).replacen("v1=\"0\"", "v1=\"4\"", 1);
    refused(&good::with_model(&past), "vertex 4 of 4");
    let support = good::TETRAHEDRON.replacen("id=\"1\"", "id=\"2\" type=\"support\"", 1);
    noticed(&with("", &support, &format!("{ITEM}<item objectid=\"2\"/>")), &["objects-excluded"]);
    refused(&with("", &support, "<item objectid=\"2\"/>"), "no triangles");
    refused(&with("", "", ""), "builds nothing");
    let one_left =
        noticed(&with("", "", &format!("{ITEM}<item objectid=\"1\" printable=\"0\"/>")), &["objects-excluded"]);
    let said = |n: &amcheck::notice::Notice| n.message == "1 build item marked as not printable was left out";
    assert!(one_left.notices.iter().any(said), "{:?}", one_left.notices);
    let foreign = "<object id=\"2\"><b:lattice xmlns:b=\"http://x.org/beamlattice/2017/02\"/></object>";
    noticed(&with("", foreign, ITEM), &["extension-ignored"]);
    let script = good::package(&[
        ("_rels/.rels", RELATIONS.as_bytes()),
        (MODEL, good::model("", "", ITEM).as_bytes()),
        ("Metadata/Slic3r_PE.config", b"post_process = rm -rf /"),
    ]);
    noticed(&script, &[]);
}

#[test]
fn zip64_end_records_are_read() {
    let small = good::with_model(&good::model("", "", "<item objectid=\"1\"/>"));
    let end = small.windows(4).rposition(|w| w == b"PK\x05\x06").unwrap();
    let field =
        |at: usize, n: usize| small[end + at..end + at + n].iter().rev().fold(0u64, |v, &b| v << 8 | u64::from(b));
    let (entries, size, offset) = (field(10, 2), field(12, 4), field(16, 4));
    let mut bytes = small[..end].to_vec();
    bytes.extend(b"PK\x06\x06");
    bytes.extend(44u64.to_le_bytes());
    bytes.extend([45, 0, 45, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    [entries, entries, size, offset].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    bytes.extend(b"PK\x06\x07");
    bytes.extend(0u32.to_le_bytes());
    bytes.extend((end as u64).to_le_bytes());
    bytes.extend(1u32.to_le_bytes());
    bytes.extend(b"PK\x05\x06");
    bytes.extend([0xff; 16]);
    bytes.extend([0, 0]);
    // Disk numbers of 0xffff too, as one widespread writer has them.
    noticed(&bytes, &[]);
}

#[test]
fn a_damaged_megabyte_is_refused_at_once() {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let stl_text = format!("solid\n{}facet normal 0 0 1\nouter loop\nvertex 0 0 blah\n", facet.repeat(12_000));
    let mut stl_binary = vec![1u8; 84 + 50 * 20_000];
    stl_binary[80..84].copy_from_slice(&20_000u32.to_le_bytes());
    let last = stl_binary.len() - 30;
    stl_binary[last..last + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let obj = format!("{}f 1 2 99999999\n", "v 0.5 0.25 0.125\nf -1 -1 -1\n".repeat(35_000));
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 70000\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n{}3 0 1 70000\n",
        "0.5 0.25 0.125\n".repeat(70_000)
    );
    let vertices = "<vertex x=\"0.5\" y=\"0.25\" z=\"0,5\"/>".repeat(28_000);
    let model =
        good::model("", "", "<item objectid=\"1\"/>").replacen("<vertices>", &format!("<vertices>{vertices}"), 1);
    let threemf = good::stored(&[("_rels/.rels", RELATIONS.as_bytes()), (MODEL, model.as_bytes())]);
    for (name, bytes) in [
        ("stl text", stl_text.into_bytes()),
        ("stl binary", stl_binary),
        ("obj", obj.into_bytes()),
        ("ply", ply.into_bytes()),
        ("3mf", threemf),
        ("zeros", vec![0; 1 << 20]),
        ("noise", (0..1u32 << 20).map(|i| (i.wrapping_mul(2654435761) >> 13) as u8).collect()),
        ("brackets", vec![b'<'; 1 << 20]),
    ] {
        assert!(bytes.len() > 900_000 && bytes.len() < 1_300_000, "{name}: {} bytes", bytes.len());
        // The best of a few: other tests run beside this one.
        let best = (0..4)
            .map(|_| {
                let start = std::time::Instant::now();
                assert!(load(&bytes).is_err(), "{name} was read");
                start.elapsed().as_millis()
            })
            .min();
        println!("{name}: refused in {best:?} ms");
        if !cfg!(debug_assertions) {
            assert!(best < Some(100), "{name}: {best:?} ms");
        }
    }
}
