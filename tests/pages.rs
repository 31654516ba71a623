//! The page of every fixture in a real browser: ready, quiet, asking for nothing, every control working, the rules of axe
//! kept in the light and in the dark, and complete without script and without WebGL.

mod chromium;
mod sample;

use amcheck::analyze::{Options, prepare, run};
use amcheck::io::{Salvage, read};
use amcheck::process::Process;
use amcheck::report::{Exhibit, Exhibited, Report, html, json, render};
use amcheck::units::Length;
use chromium::{Folder, browser, element, open};
use flate2::read::GzDecoder;
use serde_json::{Value, json};
use std::io::Read;
use std::path::Path;

/// A page and what it was made from.
struct Page {
    file: String,
    report: Report,
    exhibit: Exhibit,
}

/// The committed parts, judged by what finds most in them, and two that are invented: a crowd of checks, a hostile name.
fn pages() -> Vec<Page> {
    let parts = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts");
    let mut names: Vec<_> = std::fs::read_dir(parts).unwrap().flatten().map(|e| e.path()).collect();
    names.retain(|p| p.extension().is_some_and(|e| e == "stl"));
    names.sort();
    let mut pages: Vec<Page> = names.iter().map(|p| judged(p)).collect();
    let crowd = sample::crowded("crowd.stl");
    pages.push(Page { file: "crowd.html".into(), report: crowd.0, exhibit: crowd.1 });
    let hostile = sample::report(sample::HOSTILE);
    pages.push(Page { file: "hostile.html".into(), report: hostile, exhibit: sample::exhibit(3.0) });
    pages
}

fn judged(path: &Path) -> Page {
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let bytes = std::fs::read(path).unwrap();
    // One page shows local thickness as well.
    let thickness = name.starts_with("finned").then(|| Length::mm(2.0));
    let options =
        Options { exhibited: Exhibited::Stances(3), thickness, ..Options::new(Process::named("fdm").unwrap()) };
    let loaded = read(&name, &bytes, Salvage::Refuse).unwrap();
    let analysis = run(prepare(&name, &bytes, loaded, &options).unwrap(), &options).unwrap();
    Page { file: name.replace(".stl", ".html"), report: analysis.report, exhibit: analysis.exhibit }
}

/// Opens the pages one after the other; what was seen of each, by file.
fn look(browser: &Path, folder: &Folder, pages: &[Page], asked: Value, flags: &[&str]) -> (Value, Vec<String>) {
    let asked = json::inside_html(&asked.to_string());
    let harness = include_str!("pages/harness.js");
    let page = format!(
        "<!doctype html><meta charset=\"utf-8\"><title>harness</title><script type=\"application/json\" id=\"asked\">{asked}</script>\
         <body><script>{harness}</script>"
    );
    let path = folder.write("harness.html", &page);
    // The harness reads what is inside its frames: files count as one origin for it.
    let flags = [&["--allow-file-access-from-files", "--disable-web-security"], flags].concat();
    let seen = open(browser, folder, &path, "", 60_000 * (1 + pages.len() as u32), &flags);
    let text = element(&seen.dom, "seen").unwrap_or_else(|| panic!("the harness came to no end: {:?}", seen.console));
    (serde_json::from_str(&text).unwrap(), seen.console)
}

#[test]
fn every_page_works_in_a_browser() {
    let Some(browser) = browser() else { return };
    let (folder, pages) = (Folder::new(), pages());
    for p in &pages {
        let pictures = render::pictures(&p.report, &p.exhibit);
        let page = html::page(&p.report, &p.exhibit, &pictures);
        assert!(page.len() < 2_000_000, "{}: {} bytes", p.file, page.len());
        let compared = p.exhibit.stances.as_ref().map_or(0, |s| s.pictures.len());
        assert_eq!(page.matches("The part in orientation ").count(), compared, "{}: thumbnails are missing", p.file);
        assert!(page.contains("Which way to print") && page.contains("this run"), "{}: no orientations", p.file);
        folder.write(&p.file, &page);
    }
    let names: Vec<&str> = pages.iter().map(|p| p.file.as_str()).collect();
    let mut axe = String::new();
    GzDecoder::new(&include_bytes!("data/axe.min.js.gz")[..]).read_to_string(&mut axe).unwrap();
    let asked = json!({"names": names, "axe": axe, "modes": ["link", "scriptless"]});
    let (seen, console) = look(&browser, &folder, &pages, asked, &[]);
    assert_eq!(console, Vec::<String>::new());
    let schema = jsonschema::validator_for(&serde_json::from_str(json::SCHEMA_TEXT).unwrap()).unwrap();
    for p in &pages {
        let said = &seen[&p.file];
        assert!(said["broken"].is_null(), "{}: {}", p.file, said["broken"]);
        follows_the_schema(&schema, p);
        println!("{}: {} triangles, {} findings", p.file, said["itself"]["triangles"], said["itself"]["findings"]);
        works(p, said);
        keeps_the_rules(p, said);
        is_whole_without_script(p, &said["scriptless"]);
    }
    let asked = json!({"names": names, "axe": null, "modes": []});
    let (blind, _) = look(&browser, &folder, &pages, asked, &["--disable-3d-apis"]);
    for p in &pages {
        let said = &blind[&p.file];
        assert_eq!(said["ready"], "fallback", "{}: {said}", p.file);
        assert!(said["note"].as_str().unwrap().contains("WebGL"), "{}: {}", p.file, said["note"]);
    }
}

/// A finger turns the part and leaves its size; two that draw apart to three times their distance bring it as much nearer.
#[test]
fn fingers_turn_the_part_and_bring_it_nearer() {
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/parts/finned_bracket.stl");
    let pages = [Page { file: "fingers-bracket.html".into(), ..judged(&path) }];
    let [p] = &pages;
    let page = html::page(&p.report, &p.exhibit, &render::pictures(&p.report, &p.exhibit));
    // The clock of a test runs ahead of the pictures of a browser: this copy draws by the clock.
    let clock = "<script>window.requestAnimationFrame = (f) => setTimeout(() => f(performance.now()), 16);</script>";
    assert!(page.contains("<head>"));
    folder.write(&p.file, &page.replacen("<head>", &format!("<head>{clock}"), 1));
    let asked = json!({"names": [p.file], "axe": null, "modes": ["touch"]});
    let (seen, _) = look(&browser, &folder, &pages, asked, &[]);
    let touch = &seen[&p.file]["touch"];
    let ratio = |name: &str| touch[name].as_f64().unwrap_or_else(|| panic!("{seen}"));
    assert!(touch["turned"] == true && (ratio("kept") - 1.0).abs() < 1e-6, "{touch}");
    assert!((ratio("nearer") - 3.0).abs() < 0.01, "{touch}");
}

/// The JSON in the page, as a script finds it, keeps to the schema.
fn follows_the_schema(schema: &jsonschema::Validator, p: &Page) {
    let text = json::inside_html(&json::write(&p.report));
    let value: Value = serde_json::from_str(&text).unwrap();
    let faults: Vec<String> = schema.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path)).collect();
    assert!(faults.is_empty(), "{}: {faults:?}", p.file);
}

/// Every control does what it says.
fn works(p: &Page, said: &Value) {
    let (file, itself) = (&p.file, &said["itself"]);
    assert_eq!(said["ready"], "1", "{file}: {}", said["note"]);
    assert_eq!(said["fetched"], json!([]), "{file} asks for something");
    assert_eq!(itself["errors"], json!([]), "{file}");
    let (drawn, all) = (itself["triangles"].as_u64().unwrap() as usize, p.exhibit.corners.len() / 3);
    // What has no extent in steps of the copy is not drawn.
    assert!(drawn <= all && drawn as f64 > 0.98 * all as f64, "{file}: {drawn} of {all} triangles");
    let covered = itself["home"]["covered"].as_f64().unwrap();
    assert!((0.01..0.9).contains(&covered), "{file}: the part covers {covered} of the canvas");
    let maps = itself["maps"].as_array().unwrap();
    assert_eq!(maps.len(), p.exhibit.maps.len(), "{file}");
    for (shown, map) in maps.iter().zip(&p.exhibit.maps) {
        assert_eq!((&shown["check"], &shown["title"]), (&json!(map.check), &json!(map.title)), "{file}");
        assert!(
            shown["legend"].as_str().unwrap().starts_with(&map.title),
            "{file}: the legend is of another map: {shown}"
        );
    }
    for cut in itself["cuts"].as_array().unwrap() {
        assert!(cut["covered"].as_f64().unwrap() > 0.0, "{file}: a cut leaves nothing: {cut}");
        assert!(cut["covered"].as_f64().unwrap() <= covered, "{file}: a cut adds to the part: {cut}");
    }
    let slices = itself["slices"].as_array().unwrap_or_else(|| panic!("{file}: no slices"));
    let shares: Vec<f64> = slices.iter().filter_map(Value::as_f64).collect();
    assert!(shares.len() == 3 && shares.iter().all(|s| (0.0..=1.0).contains(s)), "{file}: {shares:?}");
    assert!(shares.iter().any(|s| *s > 0.0), "{file}: the slices are empty");
    assert_eq!((&itself["keyCut"], &itself["uncut"], &itself["keyMap"]), (&json!(0), &json!(-1), &json!(0)), "{file}");
    let shown = itself["layers"].as_array().unwrap();
    assert!(shown.len() == p.exhibit.layers.len() && shown.iter().all(|l| l == true), "{file}: {shown:?}");
    assert!(itself["turned"] == true && itself["zoomed"] == true && itself["theme"] == "dark", "{file}");
    let findings = p.report.findings().len().min(24);
    assert_eq!(itself["findings"].as_u64().unwrap() as usize, findings, "{file}");
    assert!(itself["apart"].as_f64().is_none_or(|d| d >= 24.0), "{file}: pins cover each other, {}", itself["apart"]);
    if findings > 0 {
        assert_eq!(itself["flight"]["to"], itself["asked"], "{file}: the flight ends elsewhere");
        assert_eq!(itself["marked"], 1, "{file}");
        assert_eq!(said["link"][0], said["link"][1], "{file}: the address leads elsewhere");
    }
}

/// No rule of axe is broken, in either theme, every fold open.
fn keeps_the_rules(p: &Page, said: &Value) {
    for theme in said["axe"].as_array().unwrap() {
        assert_eq!(theme["violations"], json!([]), "{}", p.file);
        assert!(theme["passes"].as_u64().unwrap() > 20, "{}: axe looked at too little: {theme}", p.file);
    }
}

/// Verdict, every check, every listed finding and at least one picture are there.
fn is_whole_without_script(p: &Page, said: &Value) {
    let file = &p.file;
    assert!(said["ready"].is_null(), "{file}: a script ran");
    assert_eq!(said["findings"].as_u64().unwrap() as usize, p.report.findings().len().min(24), "{file}");
    assert_eq!(said["rows"].as_u64().unwrap() as usize, p.report.checks.len(), "{file}");
    assert!(said["shown"] == 1 && said["broken"] == 0 && said["pictures"].as_u64().unwrap() > 0, "{file}: {said}");
    assert!(
        said["headline"].as_str().unwrap().contains("rintable") || said["headline"].as_str().unwrap().contains("tell")
    );
}
