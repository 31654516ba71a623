//! The page in a real browser: ready, without a console error, every control doing what it says.
//!
//! Uses a Chromium of the system (`AMCHECK_BROWSER` names another); without one the tests say that they were skipped,
//! and fail under `AMCHECK_REQUIRE_BROWSER=1`.

mod sample;

use amcheck::report::{html, render};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The browser, if there is one.
fn browser() -> Option<PathBuf> {
    let named = std::env::var_os("AMCHECK_BROWSER").map(PathBuf::from);
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let found =
        named.or_else(|| std::env::split_paths(&folders).flat_map(|f| names.map(|n| f.join(n))).find(|p| p.is_file()));
    if found.is_none() {
        assert!(std::env::var_os("AMCHECK_REQUIRE_BROWSER").is_none(), "a browser is required and none is installed");
        println!("skipped: no Chromium on PATH (AMCHECK_BROWSER names one)");
    }
    found
}

/// What a browser makes of a page.
struct Seen {
    /// The document after the page is ready.
    dom: String,
    /// Lines that the page or the browser's policy wrote to the console as errors.
    console: Vec<String>,
}

/// Whether the page's scripts may run.
#[derive(PartialEq)]
enum Scripts {
    On,
    /// Forbidden by the page's own policy, because switching them off in the browser also ends `--dump-dom`.
    Off,
}

/// Opens the sample's page in the browser, at an anchor and with more flags.
fn open(browser: &Path, file: &str, anchor: &str, scripts: Scripts, flags: &[&str]) -> Seen {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("browser-{}-{}", std::process::id(), fresh()));
    std::fs::create_dir_all(&folder).unwrap();
    let (report, exhibit) = (sample::report(file), sample::exhibit(3.0));
    let mut page = html::page(&report, &exhibit, &render::pictures(&report, &exhibit));
    if scripts == Scripts::Off {
        page = page.replace("script-src 'unsafe-inline' blob:", "script-src 'none'");
    }
    let path = folder.join("report.html");
    std::fs::write(&path, page).unwrap();
    let out = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--enable-unsafe-swiftshader", "--enable-logging=stderr"])
        .args(["--virtual-time-budget=20000", "--window-size=1320,1000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .args(flags)
        .arg(format!("file://{}{anchor}", path.display()))
        .output()
        .unwrap();
    let console = String::from_utf8_lossy(&out.stderr);
    let wrong =
        |l: &&str| l.contains("CONSOLE") && (l.contains(":ERROR:") || l.contains("Refused") || l.contains("Uncaught"));
    let seen = Seen {
        dom: String::from_utf8_lossy(&out.stdout).into_owned(),
        console: console.lines().filter(wrong).map(String::from).collect(),
    };
    let _ = std::fs::remove_dir_all(&folder);
    seen
}

/// A number that no other call in this process gets.
fn fresh() -> usize {
    static NEXT: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
    NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed)
}

/// The text of the element with an id.
fn element<'a>(dom: &'a str, id: &str) -> Option<&'a str> {
    let at = dom.find(&format!("id=\"{id}\""))?;
    let from = at + dom[at..].find('>')? + 1;
    Some(&dom[from..from + dom[from..].find("</")?])
}

#[test]
fn the_page_is_ready_and_every_control_works() {
    let Some(browser) = browser() else { return };
    let seen = open(&browser, "bracket.stl", "#selftest", Scripts::On, &[]);
    assert_eq!(seen.console, Vec::<String>::new());
    assert!(seen.dom.contains("data-ready=\"1\""), "not ready: {:?}", element(&seen.dom, "viewer-note"));
    let said = element(&seen.dom, "selftest").expect("the page says nothing of itself").replace("&gt;", ">");
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
