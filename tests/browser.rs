//! The page in a real browser: ready, without a console error, every control doing what it says.
//!
//! `tests/pages.rs` opens the page of every fixture; here one invented part is looked at closely.

mod chromium;
mod sample;

use amcheck::report::{html, render};
use chromium::{Folder, Seen, browser, element};
use std::path::Path;

/// Whether the page's scripts may run.
#[derive(PartialEq)]
enum Scripts {
    On,
    /// Forbidden by the page's own policy, because switching them off in the browser also ends `--dump-dom`.
    Off,
}

/// Opens the sample's page in the browser, at an anchor and with more flags.
fn open(browser: &Path, file: &str, anchor: &str, scripts: Scripts, flags: &[&str]) -> Seen {
    let folder = Folder::new();
    let (report, exhibit) = (sample::report(file), sample::exhibit(3.0));
    let mut page = html::page(&report, &exhibit, &render::pictures(&report, &exhibit));
    if scripts == Scripts::Off {
        page = page.replace("script-src 'unsafe-inline' blob:", "script-src 'none'");
    }
    let path = folder.write("report.html", &page);
    chromium::open(browser, &folder, &path, anchor, 20_000, flags)
}

#[test]
fn the_page_is_ready_and_every_control_works() {
    let Some(browser) = browser() else { return };
    let seen = open(&browser, "bracket.stl", "#selftest", Scripts::On, &[]);
    assert_eq!(seen.console, Vec::<String>::new());
    assert!(seen.dom.contains("data-ready=\"1\""), "not ready: {:?}", element(&seen.dom, "viewer-note"));
    let said = element(&seen.dom, "selftest").expect("the page says nothing of itself");
    let said: serde_json::Value = serde_json::from_str(&said).unwrap();
    println!("{said}");
    assert_eq!(said["errors"], serde_json::json!([]));
    assert_eq!(said["triangles"].as_u64().unwrap() as usize, sample::exhibit(3.0).corners.len() / 3);
    assert_eq!(said["findings"], 5);
    let covered = said["home"]["covered"].as_f64().unwrap();
    assert!((0.05..0.9).contains(&covered), "the part covers {covered} of the canvas");
    let maps = said["maps"].as_array().unwrap();
    assert_eq!(maps.len(), 3);
    assert_ne!(maps[0]["colour"], maps[2]["colour"], "another map looks the same");
    for seen in ["failing", "hatched", "inked"] {
        assert!(maps[0][seen].as_u64().unwrap() > 20, "no pixel is {seen}: {}", maps[0]);
        assert!(seen == "inked" || maps[1][seen] == 0, "the map without a fail limit has {seen} pixels: {}", maps[1]);
    }
    // 0.45 mm, varied by the sample's 0.25·(z/22 − 0.2) from z = 4 mm on.
    let least = maps[0]["min"].as_f64().unwrap();
    assert!((least - 0.45 * (1.0 + 0.25 * (4.0 / 22.0 - 0.2))).abs() < 1e-3, "{least}");
    for cut in said["cuts"].as_array().unwrap() {
        assert!(cut["covered"].as_f64().unwrap() < 0.97 * covered, "a cut takes nothing away: {cut} of {covered}");
        assert!(cut["strips"].as_u64().unwrap() > 20, "the section is not painted: {cut}");
    }
    let slices = said["slices"].as_array().unwrap();
    assert!(slices.len() == 3 && slices.iter().all(|s| (0.01..0.99).contains(&s.as_f64().unwrap())), "{slices:?}");
    assert_eq!(said["layers"], serde_json::json!([true]), "a layer is shown and nothing changes");
    assert_eq!((&said["keyCut"], &said["uncut"]), (&0.into(), &(-1).into()));
    assert_eq!(said["flight"]["to"], said["asked"], "the flight ends elsewhere");
    assert_eq!(said["hash"], "#trapped-volume-1");
    for yes in ["turned", "zoomed", "opened"] {
        assert_eq!(said[yes], true, "{yes}");
    }
    assert_eq!((&said["marked"], &said["theme"], &said["pins"]), (&1.into(), &"dark".into(), &5.into()));
    assert!(said["faded"].as_u64().unwrap() >= 1, "the sealed void's pin is not faded");
}

#[test]
fn without_webgl_the_pictures_stay_and_the_page_says_why() {
    let Some(browser) = browser() else { return };
    let seen = open(&browser, "bracket.stl", "", Scripts::On, &["--disable-3d-apis"]);
    assert!(seen.dom.contains("data-ready=\"fallback\""));
    let note = element(&seen.dom, "viewer-note").unwrap();
    assert!(note.contains("WebGL") && note.contains("pictures"), "{note}");
}

#[test]
fn without_script_everything_essential_is_there() {
    let Some(browser) = browser() else { return };
    let seen = open(&browser, "bracket.stl", "", Scripts::Off, &[]);
    assert!(!seen.dom.contains("data-ready"));
    assert_eq!(seen.dom.matches("class=\"finding ").count(), 5);
    assert!(seen.dom.contains("data:image/png;base64,") && seen.dom.contains("Not printable as is"));
}

#[test]
fn a_hostile_name_changes_nothing() {
    let Some(browser) = browser() else { return };
    let seen = open(&browser, sample::HOSTILE, "#selftest", Scripts::On, &[]);
    assert_eq!(seen.console, Vec::<String>::new());
    assert!(seen.dom.contains("data-ready=\"1\"") && element(&seen.dom, "selftest").is_some());
    assert!(!seen.dom.contains("<img src=\"x\""), "the name became an element");
}
