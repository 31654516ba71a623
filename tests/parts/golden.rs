//! The reports of the committed parts, byte for byte; `REGENERATE=1 cargo test --release --test parts golden` rewrites them.

use crate::{fixtures, process};
use amcheck::analyze::{Analysis, Options, prepare, run};
use amcheck::io::{Salvage, read};
use amcheck::report::stances::COMPARED;
use amcheck::report::{Exhibited, html, json, render};
use rayon::ThreadPoolBuilder;
use std::path::{Path, PathBuf};

/// The part whose whole report is kept as a sample.
const SAMPLE: &str = "finned_bracket";

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn asked_to_rewrite() -> bool {
    std::env::var_os("REGENERATE").is_some()
}

fn analysis(part: &str, exhibited: Exhibited) -> Analysis {
    let (name, bytes) = (format!("{part}.stl"), fixtures::bytes(part));
    let options = Options { exhibited, ..Options::new(process("fdm", &[])) };
    let loaded = read(&name, &bytes, Salvage::Refuse).expect("a mesh");
    run(prepare(&name, &bytes, loaded, &options).expect("a part"), &options).expect("a report")
}

/// Report of a part with so many threads.
fn report(part: &str, threads: usize) -> String {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| json::write(&analysis(part, Exhibited::Nothing).report))
}

/// The first line in which two texts differ.
fn first_difference(kept: &str, made: &str) -> String {
    let (mut old, mut new) = (kept.lines(), made.lines());
    for number in 1.. {
        match (old.next(), new.next()) {
            (Some(a), Some(b)) if a == b => {}
            (None, None) => break,
            (a, b) => {
                return format!(
                    "line {number}: {} -> {}",
                    a.unwrap_or("nothing").trim(),
                    b.unwrap_or("nothing").trim()
                );
            }
        }
    }
    "only in line ends".into()
}

#[test]
fn golden_reports_of_all_fixtures() {
    let place = folder("fixtures/reports");
    let mut stale = Vec::new();
    for (i, (part, _)) in fixtures::all().into_iter().enumerate() {
        // One thread for half of the parts and three for the others; what is kept was written with all there are.
        let made = if asked_to_rewrite() {
            json::write(&analysis(part, Exhibited::Nothing).report)
        } else {
            report(part, 1 + 2 * (i % 2))
        };
        let file = place.join(format!("{part}.json"));
        if asked_to_rewrite() {
            std::fs::create_dir_all(&place).expect("the folder");
            std::fs::write(&file, &made).expect("the file");
        }
        match std::fs::read_to_string(&file) {
            Ok(kept) if kept == made => {}
            Ok(kept) => stale.push(format!("{part}, {}", first_difference(&kept, &made))),
            Err(e) => stale.push(format!("{part}: {e}")),
        }
    }
    stale.extend(orphans(&place).into_iter().map(|p| format!("no part is left for {}", p.display())));
    assert!(stale.is_empty(), "run with REGENERATE=1 and read the difference:\n{}", stale.join("\n"));
}

/// Reports whose part is gone; they are taken away where reports are rewritten.
fn orphans(place: &Path) -> Vec<PathBuf> {
    let known: Vec<String> = fixtures::all().into_iter().map(|(part, _)| format!("{part}.json")).collect();
    let orphan = |p: &PathBuf| p.file_name().is_none_or(|n| !known.contains(&n.to_string_lossy().into_owned()));
    let kept = std::fs::read_dir(place).expect("the folder").flatten().map(|e| e.path());
    let orphans: Vec<PathBuf> = kept.filter(orphan).collect();
    if asked_to_rewrite() {
        orphans.iter().for_each(|p| std::fs::remove_file(p).expect("the file"));
        return Vec::new();
    }
    orphans
}

#[test]
fn golden_sample_is_what_the_command_writes() {
    let folder = folder("reports/sample");
    let analysis = analysis(SAMPLE, Exhibited::Stances(COMPARED));
    let report = json::write(&analysis.report);
    if asked_to_rewrite() {
        let pictures = render::pictures(&analysis.report, &analysis.exhibit);
        let page = html::page(&analysis.report, &analysis.exhibit, &pictures);
        let mut files =
            vec![("report.json".to_string(), report.clone().into_bytes()), ("report.html".into(), page.into_bytes())];
        files.extend(pictures.into_iter().map(|p| (format!("{}.png", p.name), p.png)));
        std::fs::create_dir_all(&folder).expect("the folder");
        let earlier = std::fs::read_dir(&folder).expect("the folder").flatten().map(|e| e.path());
        earlier.for_each(|p| std::fs::remove_file(p).expect("a file of an earlier run"));
        for (file, bytes) in files {
            std::fs::write(folder.join(file), bytes).expect("the file");
        }
    }
    let kept = std::fs::read_to_string(folder.join("report.json")).expect("reports/sample/report.json");
    assert!(kept == report, "reports/sample is stale: run this test with REGENERATE=1 and read the difference");
}
