//! A Chromium of the system (`AMCHECK_BROWSER` names another); without one the tests say that they were skipped, and fail
//! under `AMCHECK_REQUIRE_BROWSER=1`.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::Command;

/// The browser, if there is one.
pub fn browser() -> Option<PathBuf> {
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
pub struct Seen {
    /// The document after the page is ready.
    pub dom: String,
    /// Lines that the page or the browser's policy wrote to the console as errors.
    pub console: Vec<String>,
}

/// A folder of one test's own, gone with it.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Self {
        static NEXT: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
        let next = NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let name = format!("browser-{}-{next}", std::process::id());
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::create_dir_all(&folder).unwrap();
        Folder(folder)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Opens a page of a folder at an anchor, with more flags, and lets its clock run for so many milliseconds.
pub fn open(browser: &Path, folder: &Folder, page: &Path, anchor: &str, milliseconds: u32, flags: &[&str]) -> Seen {
    let out = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--enable-unsafe-swiftshader", "--enable-logging=stderr"])
        .args(["--window-size=1320,1000", "--dump-dom"])
        .arg(format!("--virtual-time-budget={milliseconds}"))
        .arg(format!("--user-data-dir={}", folder.0.join("profile").display()))
        .args(flags)
        .arg(format!("file://{}{anchor}", page.display()))
        .output()
        .unwrap();
    let console = String::from_utf8_lossy(&out.stderr);
    let wrong =
        |l: &&str| l.contains("CONSOLE") && (l.contains(":ERROR:") || l.contains("Refused") || l.contains("Uncaught"));
    Seen {
        dom: String::from_utf8_lossy(&out.stdout).into_owned(),
        console: console.lines().filter(wrong).map(String::from).collect(),
    }
}

/// The text of the element with an id, with the entities that a serialised text holds undone.
pub fn element(dom: &str, id: &str) -> Option<String> {
    let at = dom.find(&format!("id=\"{id}\""))?;
    let from = at + dom[at..].find('>')? + 1;
    let text = &dom[from..from + dom[from..].find("</")?];
    Some(text.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}").replace("&amp;", "&"))
}
