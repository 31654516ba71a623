//! Projects of slicers: objects in model parts of their own, and volumes that are no material.

use crate::good::{self, MODEL, RELATIONS, TETRAHEDRON};
use amcheck::Error;
use amcheck::geometry::Health;
use amcheck::io::{Loaded, threemf};

const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
const PRODUCTION: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
const PARTS: &str = "Metadata/model_settings.config";
const RUNS: &str = "Metadata/Slic3r_PE_model.config";
const OBJECTS: &str = "3D/Objects/all_1.model";

/// The volume of the tetrahedron of `good`, and of a box, in mm³.
const TETRA: f64 = 36.0;

/// A box as an object; its facets are 12.
fn cuboid(attributes: &str, edges: [f64; 3]) -> String {
    format!("<object {attributes}>{}</object>", mesh(&[edges]))
}

/// The mesh of boxes beside each other, 12 facets each.
fn mesh(boxes: &[[f64; 3]]) -> String {
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let (mut vertices, mut triangles) = (String::new(), String::new());
    for (n, edges) in boxes.iter().enumerate() {
        for i in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|a| if i >> a & 1 == 1 { edges[a] } else { 0.0 });
            vertices += &format!("<vertex x=\"{}\" y=\"{y}\" z=\"{z}\"/>", x + 100.0 * n as f64);
        }
        for q in quads.map(|q| q.map(|i| i + 8 * n)) {
            for [a, b, c] in [[q[0], q[1], q[2]], [q[0], q[2], q[3]]] {
                triangles += &format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
            }
        }
    }
    format!("<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>")
}

fn component(id: u32, more: &str) -> String {
    format!("<component objectid=\"{id}\" {more}/>")
}

fn assembly(id: u32, components: &[String]) -> String {
    format!("<object id=\"{id}\"><components>{}</components></object>", components.concat())
}

/// A model part that is not the root.
fn part(attributes: &str, resources: &str, build: &str) -> String {
    format!(
        "<model {attributes} xmlns=\"{CORE}\" xmlns:p=\"{PRODUCTION}\"><resources>{resources}</resources>{build}</model>"
    )
}

/// A package with a root of these resources beside a tetrahedron as object 1, and further parts.
fn package(resources: &str, build: &str, parts: &[(&str, &str)]) -> Vec<u8> {
    let root = good::model(&format!("xmlns:p=\"{PRODUCTION}\""), resources, build);
    let mut all = vec![("_rels/.rels", RELATIONS.as_bytes()), (MODEL, root.as_bytes())];
    all.extend(parts.iter().map(|(name, text)| (*name, text.as_bytes())));
    good::package(&all)
}

/// A package of one assembly, object 9, of components in a model part with a tetrahedron as object 1 and these.
fn linked(objects: &str, components: &[String], settings: &str) -> Vec<u8> {
    let objects = part("", &format!("{TETRAHEDRON}{objects}"), "");
    package(&assembly(9, components), "<item objectid=\"9\"/>", &[(OBJECTS, &objects), (PARTS, settings)])
}

fn at_path(id: u32) -> String {
    component(id, &format!("p:path=\"/{OBJECTS}\" transform=\"1 0 0 0 1 0 0 0 1 {} 0 0\"", 200 * id))
}

#[track_caller]
fn load(bytes: &[u8]) -> Loaded {
    threemf::read(bytes).unwrap_or_else(|e| panic!("{e} @{:?}", e.place()))
}

/// The volume that is read, and the codes of the notices with their counts.
#[track_caller]
fn found(bytes: &[u8]) -> (f64, Vec<(String, Option<u64>)>) {
    let loaded = load(bytes);
    let volume = (Health::of(&loaded.mesh).volume_mm3() * 1e6).round() / 1e6;
    (volume, loaded.notices.into_iter().map(|n| (n.code, n.count)).collect())
}

#[track_caller]
fn volume(bytes: &[u8]) -> f64 {
    let (volume, notices) = found(bytes);
    assert_eq!(notices, []);
    volume
}

/// Refused with this code, with each of these words in message, place or remedy.
#[track_caller]
fn refused(bytes: &[u8], code: &str, words: &[&str]) {
    let e: Error = threemf::read(bytes).map(|l| l.mesh.triangles.len()).expect_err(code);
    let text = format!("{e} @{} {}", e.place().unwrap_or_default(), e.remedy());
    assert!(e.code() == code && words.iter().all(|w| text.contains(w)), "{} {text}", e.code());
}

/// A project as Bambu Studio and OrcaSlicer write it: a body, a modifier, a blocker and a second body on another plate.
pub fn bambu() -> Vec<(&'static str, Vec<u8>)> {
    let objects = [
        cuboid("id=\"1\" type=\"model\" p:UUID=\"00010000\"", [2.0, 3.0, 4.0]),
        cuboid("id=\"2\" type=\"other\"", [1.0; 3]),
        cuboid("id=\"3\" type=\"model\"", [5.0; 3]),
    ];
    let root = format!(
        "<?xml version=\"1.0\"?><model unit=\"millimeter\" xmlns=\"{CORE}\" xmlns:p=\"{PRODUCTION}\" \
         xmlns:BambuStudio=\"http://schemas.bambulab.com/package/2021\" requiredextensions=\"p\">\
         <metadata name=\"Application\">BambuStudio-02.01.00</metadata><resources>{}{}</resources><build p:UUID=\"2c\">\
         <item objectid=\"4\" p:UUID=\"4\" transform=\"1 0 0 0 1 0 0 0 1 90 90 0\" printable=\"1\"/>\
         <item objectid=\"6\" transform=\"1 0 0 0 1 0 0 0 1 400 90 0\" printable=\"1\"/></build></model>",
        assembly(4, &[1, 2, 3].map(at_path)),
        assembly(6, &[component(5, "p:path=\"/3D/Objects/other_2.model\"")]),
    );
    let settings = r#"<?xml version="1.0" encoding="UTF-8"?><config><object id="4"><metadata key="name" value="body"/>
        <part id="1" subtype="normal_part"><metadata key="name" value="body"/><mesh_stat edges_fixed="0"/></part>
        <part id="2" subtype="modifier_part"><metadata key="name" value="dense"/></part>
        <part id="3" subtype="support_blocker"><metadata key="name" value="no support"/></part></object>
        <object id="6"><part id="5" subtype="normal_part"/></object>
        <plate><metadata key="plater_id" value="1"/><model_instance><metadata key="object_id" value="4"/></model_instance></plate>
        <plate><metadata key="plater_id" value="2"/><model_instance><metadata key="object_id" value="6"/></model_instance></plate>
        <assemble><assemble_item object_id="4"/></assemble></config>"#;
    vec![
        ("_rels/.rels", RELATIONS.as_bytes().to_vec()),
        (MODEL, root.into_bytes()),
        (OBJECTS, part("requiredextensions=\"p\"", &objects.concat(), "<build/>").into_bytes()),
        ("3D/Objects/other_2.model", part("", &cuboid("id=\"5\"", [1.0, 1.0, 7.0]), "").into_bytes()),
        (PARTS, settings.as_bytes().to_vec()),
        ("Metadata/plate_1.png", b"\x89PNG".to_vec()),
        ("Metadata/slice_info.config", b"<config><plate/></config>".to_vec()),
    ]
}

#[test]
fn a_project_is_read_without_its_modifiers() {
    let parts = bambu();
    let parts: Vec<(&str, &[u8])> = parts.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
    let bytes = good::package(&parts);
    let (volume, notices) = found(&bytes);
    assert_eq!(volume, 2.0 * 3.0 * 4.0 + 7.0);
    assert_eq!(notices, [("several-plates".to_string(), Some(2)), ("volumes-excluded".to_string(), Some(2))]);
    let told = &load(&bytes).notices[1].message;
    for word in ["1 modifier (`dense`, part 2 of object 4)", "1 support blocker (`no support`, part 3 of object 4)"] {
        assert!(told.contains(word), "{told}");
    }
}

#[test]
fn a_path_names_the_object_of_the_other_part() {
    // Object 1 is the tetrahedron in the root, and a box in the other part.
    let other = part("", &cuboid("id=\"1\"", [2.0, 3.0, 4.0]), "");
    let read = |resources: &str, build: &str| volume(&package(resources, build, &[(OBJECTS, &other)]));
    let path = format!("p:path=\"/{OBJECTS}\"");
    assert_eq!(read("", "<item objectid=\"1\"/>"), TETRA);
    assert_eq!(read("", &format!("<item objectid=\"1\" {path}/>")), 24.0);
    let both =
        assembly(3, &[component(1, ""), component(1, &format!("{path} transform=\"2 0 0 0 1 0 0 0 1 50 0 0\""))]);
    assert_eq!(read(&both, "<item objectid=\"3\"/>"), TETRA + 48.0);
    assert_eq!(read("", &format!("<item objectid=\"1\" p:path=\"/{MODEL}\"/>")), TETRA);
    let prefix = format!("<item objectid=\"1\" xmlns:made=\"{PRODUCTION}\" made:path=\"/{OBJECTS}\"/>");
    assert_eq!(read("", &prefix), 24.0);
    assert_eq!(read("", "<item objectid=\"1\" xmlns:x=\"http://x.org\" x:path=\"/none\"/>"), TETRA);
    // Numbers of a part are in its unit, and what it builds is nobody's business.
    let other =
        part("unit=\"centimeter\"", &cuboid("id=\"1\"", [2.0, 3.0, 4.0]), "<build><item objectid=\"9\"/></build>");
    let item = format!("<item objectid=\"1\" {path}/>");
    assert_eq!(volume(&package("", &item, &[(OBJECTS, &other)])), 24_000.0);
}

#[test]
fn paths_that_lead_nowhere_are_refused() {
    let other = part("", &cuboid("id=\"5\"", [1.0; 3]), "");
    let item = |attributes: &str| package("", &format!("<item objectid=\"5\" {attributes}/>"), &[(OBJECTS, &other)]);
    assert_eq!(volume(&item(&format!("p:path=\"/{OBJECTS}\""))), 1.0);
    refused(
        &item("p:path=\"/3D/none.model\""),
        "E011",
        &["/3D/none.model", "does not exist", "3D/3dmodel.model, line 8"],
    );
    refused(&item("p:path=\"\""), "E011", &["does not exist"]);
    refused(&item("q:path=\"/3D/Objects/all_1.model\""), "E011", &["q:path", "namespace"]);
    refused(&item("path=\"/3D/Objects/all_1.model\""), "E011", &["path", "namespace"]);
    refused(&item("p:path=\"/_rels/.rels\""), "E011", &["no 3MF model", "_rels/.rels"]);
    let lost = package("", "<item objectid=\"7\" p:path=\"/3D/Objects/all_1.model\"/>", &[(OBJECTS, &other)]);
    refused(&lost, "E011", &["object 7 of /3D/Objects/all_1.model"]);
    // Only the root may name other parts.
    let twice = part("", &assembly(5, &[component(1, &format!("p:path=\"/{MODEL}\""))]), "");
    let item = format!("<item objectid=\"5\" p:path=\"/{OBJECTS}\"/>");
    refused(&package("", &item, &[(OBJECTS, &twice)]), "E011", &["not the root", OBJECTS]);
    let ring = assembly(2, &[component(2, &format!("p:path=\"/{MODEL}\""))]);
    refused(&package(&ring, "<item objectid=\"2\"/>", &[]), "E011", &["object 2 holds itself"]);
    let ring = part("", &assembly(5, &[component(5, "")]), "");
    refused(&package("", &item, &[(OBJECTS, &ring)]), "E011", &["object 5 holds itself", OBJECTS]);
}

#[test]
fn limits_hold_for_all_parts_together() {
    let names: Vec<String> = (0..3).map(|i| format!("3D/{i}.model")).collect();
    let of = |count: usize, spaces: usize| {
        let text = part("", &(" ".repeat(spaces) + &cuboid("id=\"5\"", [1.0; 3])), "");
        let items: String = (0..count).map(|i| format!("<item objectid=\"5\" p:path=\"/{}\"/>", names[i])).collect();
        let parts: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), text.as_str())).collect();
        package("", &items, &parts)
    };
    assert_eq!(volume(&of(1, 8 << 20)), 1.0);
    refused(&of(3, 8 << 20), "E020", &["3D/1.model"]);
    // Nor does one that hardly shrinks make room for another that shrinks too well.
    let mut random = 1u64;
    let noise: String = (0..600_000)
        .map(|_| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            char::from(b'a' + (random >> 33) as u8 % 16)
        })
        .collect();
    let dense = part("", &format!("<!--{noise}-->{}", cuboid("id=\"5\"", [1.0; 3])), "");
    let bomb = part("", &(" ".repeat(20 << 20) + &cuboid("id=\"5\"", [1.0; 3])), "");
    let items = "<item objectid=\"5\" p:path=\"/3D/a.model\"/><item objectid=\"5\" p:path=\"/3D/b.model\"/>";
    refused(&package("", items, &[("3D/a.model", &dense), ("3D/b.model", &bomb)]), "E020", &["3D/b.model"]);
    let doubling: String = (2..34).map(|i| assembly(i, &[component(i - 1, ""), component(i - 1, "")])).collect();
    let item = format!("<item objectid=\"33\" p:path=\"/{OBJECTS}\"/>");
    let many = part("", &format!("{TETRAHEDRON}{doubling}"), "");
    refused(&package("", &item, &[(OBJECTS, &many)]), "E020", &["instances"]);
}

#[test]
fn parts_of_an_object_are_what_the_settings_say() {
    let boxes = [cuboid("id=\"2\"", [1.0; 3]), cuboid("id=\"3\"", [2.0; 3])].concat();
    let of = |settings: &str| linked(&boxes, &[1, 2, 3].map(at_path), &format!("<config>{settings}</config>"));
    let excluded = |n| vec![("volumes-excluded".to_string(), Some(n))];
    let unknown = |n| vec![("modifier-volumes".to_string(), Some(n))];
    let all = TETRA + 1.0 + 8.0;
    assert_eq!(found(&of("")), (all, vec![]));
    let two = r#"<object id="9"><part id="1" subtype="normal_part"/><part id="3" subtype="modifier_part"/><part id="2" subtype="support_enforcer"/></object>"#;
    assert_eq!(found(&of(two)), (TETRA, excluded(2)));
    // A word that nobody knows is material, as it is to the slicer.
    assert_eq!(found(&of(r#"<object id="9"><part id="2" subtype="brand_new"/></object>"#)), (all, vec![]));
    // A part without a number, or with one of no component, of a built object or of one that nobody knows.
    for lost in [
        r#"<object id="9"><part subtype="modifier_part"/></object>"#,
        r#"<object id="9"><part id="7" subtype="negative_part"/></object>"#,
        r#"<object id="77"><part id="2" subtype="modifier_part"/></object>"#,
        r#"<object><part id="2" subtype="modifier_part"/></object>"#,
    ] {
        assert_eq!(found(&of(lost)), (all, unknown(1)), "{lost}");
    }
    // The tetrahedron of the root is not built.
    assert_eq!(found(&of(r#"<object id="1"><part id="1" subtype="negative_part"/></object>"#)), (all, vec![]));
    let hole = r#"<object id="9"><part id="1"/><part id="2" subtype="negative_part"><metadata key="name" value="bore"/></part></object>"#;
    refused(&of(hole), "E012", &["`bore`, part 2 of object 9", PARTS, "line 1", "subtract it"]);
    // One mesh may be two parts: then their order tells which is which.
    let twice = linked(
        "",
        &[at_path(1), at_path(1)],
        r#"<config><object id="9"><part id="1"/><part id="1" subtype="modifier_part"/></object></config>"#,
    );
    assert_eq!(found(&twice), (TETRA, excluded(1)));
    assert_eq!(
        found(&linked(&boxes, &[at_path(2)], "<config><object></config>")),
        (1.0, vec![("modifier-volumes".to_string(), None)])
    );
}

#[test]
fn runs_of_facets_are_what_the_settings_say() {
    let object = format!("<object id=\"2\">{}</object>", mesh(&[[1.0; 3], [2.0; 3], [3.0; 3]]));
    let copy = assembly(3, &[component(2, "")]);
    let build = "<item objectid=\"2\"/><item objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 1 0 50 0\"/>";
    let of = |volumes: &str| {
        let settings = format!("<config><object id=\"2\" instances_count=\"2\">{volumes}</object></config>");
        package(&format!("{object}{copy}"), build, &[(RUNS, &settings)])
    };
    let run = |first: u32, last: i64, key: &str, value: &str| {
        format!(
            "<volume firstid=\"{first}\" lastid=\"{last}\"><metadata type=\"volume\" key=\"name\" value=\"plug\"/><metadata type=\"volume\" key=\"{key}\" value=\"{value}\"/></volume>"
        )
    };
    assert_eq!(found(&of(&run(0, 35, "volume_type", "ModelPart"))), (72.0, vec![]));
    let excluded = |n| vec![("volumes-excluded".to_string(), Some(n))];
    assert_eq!(found(&of(&run(12, 23, "volume_type", "ParameterModifier"))), (56.0, excluded(2)));
    assert_eq!(found(&of(&run(12, 23, "modifier", "1"))), (56.0, excluded(2)));
    let both = run(0, 11, "volume_type", "SupportBlocker") + &run(24, 35, "volume_type", "SupportEnforcer");
    assert_eq!(found(&of(&both)), (16.0, excluded(4)));
    let hole = of(&run(24, 35, "volume_type", "NegativeVolume"));
    refused(&hole, "E012", &["`plug`, facets 24 to 35 of object 2", RUNS, "subtract it"]);
    for (first, last) in [(24, 36), (23, 12), (0, -1), (0, 4_294_967_295)] {
        let lost = of(&run(first, last, "volume_type", "ParameterModifier"));
        assert_eq!(found(&lost), (72.0, vec![("modifier-volumes".to_string(), Some(1))]), "{first} {last}");
    }
}

#[test]
fn meshes_of_cura_are_what_their_objects_say() {
    let of = |settings: &[(&str, &str)]| {
        let settings: String = settings
            .iter()
            .map(|(key, value)| {
                format!("<metadata name=\"cura:{key}\" preserve=\"1\" type=\"xs:string\">{value}</metadata>")
            })
            .collect();
        let object = format!(
            "<object id=\"2\" name=\"block\"><metadatagroup>{settings}</metadatagroup>{}</object>",
            mesh(&[[2.0; 3]])
        );
        package(&object, "<item objectid=\"1\"/><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 50 0 0\"/>", &[])
    };
    assert_eq!(volume(&of(&[("support_mesh", "False"), ("infill_sparse_density", "0")])), TETRA + 8.0);
    for kind in ["support_mesh", "anti_overhang_mesh", "infill_mesh", "cutting_mesh"] {
        let (volume, notices) = found(&of(&[(kind, "True")]));
        assert_eq!((volume, notices), (TETRA, vec![("volumes-excluded".to_string(), Some(1))]), "{kind}");
    }
    let empty = [("cutting_mesh", "True"), ("wall_line_count", "0"), ("infill_sparse_density", "0.0")];
    refused(&of(&empty), "E012", &["`block`, object 2", "subtract it", MODEL]);
    let settings = "<settings xmlns=\"http://software.ultimaker.com/xml/cura/3mf/2015/10\"><setting key=\"support_mesh\">True</setting></settings>";
    let older = format!("<object id=\"2\">{settings}{}</object>", mesh(&[[2.0; 3]]));
    let older =
        package(&older, "<item objectid=\"1\"/><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 50 0 0\"/>", &[]);
    assert_eq!(found(&older), (TETRA, vec![("volumes-excluded".to_string(), Some(1))]));
}
