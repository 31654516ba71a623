//! The committed sample report, byte for byte; `REGENERATE=1` rewrites it.

use crate::{fixtures, process};
use amcheck::analyze::{Options, prepare, run};
use amcheck::io::{Salvage, read};
use amcheck::report::{html, json, render};
use std::path::PathBuf;

const PART: &str = "finned_bracket";

#[test]
fn the_sample_report_is_what_the_command_writes() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("reports/sample");
    let name = format!("{PART}.stl");
    let bytes = fixtures::bytes(PART);
    let options = Options::new(process("fdm", &[]));
    let loaded = read(&name, &bytes, Salvage::Refuse).expect("a mesh");
    let analysis = run(prepare(&name, &bytes, loaded, &options).expect("a part"), &options).expect("a report");
    let report = json::write(&analysis.report);
    if std::env::var_os("REGENERATE").is_some() {
        let pictures = render::pictures(&analysis.report, &analysis.exhibit);
        let page = html::page(&analysis.report, &analysis.exhibit, &pictures);
        let mut files =
            vec![("report.json".to_string(), report.clone().into_bytes()), ("report.html".into(), page.into_bytes())];
        files.extend(pictures.into_iter().map(|p| (format!("{}.png", p.name), p.png)));
        std::fs::create_dir_all(&folder).expect("the folder");
        for (file, bytes) in files {
            std::fs::write(folder.join(file), bytes).expect("the file");
        }
    }
    let kept = std::fs::read_to_string(folder.join("report.json")).expect("reports/sample/report.json");
    assert!(kept == report, "reports/sample is stale: run this test with REGENERATE=1 and read the difference");
}
