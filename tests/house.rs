//! The house rules that a compiler does not know: imports go down, names say what is inside, one idea is one file.

use std::path::{Path, PathBuf};

/// Every room with its floor; a room uses itself and lower floors only.
const FLOORS: &[(usize, &[&str])] = &[
    (0, &["error", "notice", "once", "random"]),
    (1, &["units"]),
    (2, &["grid"]),
    (3, &["field"]),
    (4, &["geometry", "distance", "convolution"]),
    (5, &["io", "morphology", "medial", "topology", "layer", "process"]),
    (6, &["access"]),
    (7, &["part"]),
    (8, &["check"]),
    (9, &["memory", "report"]),
    (10, &["analyze", "batch", "operate"]),
    (11, &["cli"]),
    (12, &["main"]),
];

/// The library's root declares every room and re-exports the error type; it stands outside the floors.
const ROOT: &str = "lib";

/// Names that the root re-exports, with the room they come from.
const REEXPORTED: &[(&str, &str)] = &[("Error", "error"), ("Result", "error")];

/// Lines a file may have before its tests.
const LINES: usize = 400;

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().find(|(_, rooms)| rooms.contains(&room)).map(|(floor, _)| *floor)
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every file below a folder, sorted; hidden folders, build outputs and installed packages are left out.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the repository").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let kind = entry.file_type().expect("a kind of entry");
            if kind.is_dir() && !["target", "node_modules", ".git", "reports"].contains(&name.as_str()) {
                open.push(entry.path());
            } else if kind.is_file() {
                found.push(entry.path());
            }
        }
    }
    found.sort();
    found
}

/// What may stand at the top of the repository, beside what begins with a dot.
const TOP: &[&str] = &[
    "Cargo.toml",
    "Cargo.lock",
    "CHANGELOG.md",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
    "benches",
    "fixtures",
    "reports",
    "rustfmt.toml",
    "src",
    "tests",
];

#[test]
fn the_top_level_holds_what_was_agreed() {
    let listed = std::process::Command::new("git").args(["ls-files", "-z"]).current_dir(root()).output();
    let Some(listed) = listed.ok().filter(|l| l.status.success()) else {
        println!("skipped: what is kept in the repository is known to git alone");
        return;
    };
    let listed = String::from_utf8_lossy(&listed.stdout);
    let top = listed.split('\0').filter_map(|path| path.split('/').next()).filter(|name| !name.is_empty());
    let strays: Vec<&str> = top.filter(|name| !name.starts_with('.') && !TOP.contains(name)).collect();
    assert!(strays.is_empty(), "{strays:?}");
}

#[test]
fn what_the_readme_shows_or_links_to_is_there() {
    let readme = std::fs::read_to_string(root().join("README.md")).expect("a README");
    let targets = readme.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let own: Vec<&str> = targets.filter(|t| !t.contains("://") && !t.starts_with('#')).collect();
    let missing: Vec<&&str> = own.iter().filter(|t| !root().join(t).exists()).collect();
    assert!(own.len() > 3 && missing.is_empty(), "{missing:?} of {own:?}");
}

/// A source file of the library: its place below `src`, and its code before the tests.
struct Source {
    place: String,
    code: String,
}

impl Source {
    /// The names of the modules down to this one: `["geometry", "voxelize", "cast"]`.
    fn path(&self) -> Vec<&str> {
        let stem = self.place.trim_end_matches(".rs");
        stem.trim_end_matches("/mod").split('/').collect()
    }

    fn room(&self) -> &str {
        self.path()[0]
    }

    /// Lines with their numbers, without comments.
    fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        self.code.lines().enumerate().map(|(i, l)| (i + 1, uncommented(l)))
    }
}

/// A line up to its comment; `//` behind a colon belongs to an address.
fn uncommented(line: &str) -> &str {
    let at = line.match_indices("//").find(|(i, _)| !line[..*i].ends_with(':')).map_or(line.len(), |(i, _)| i);
    &line[..at]
}

/// All sources; files that are only tests (`tests.rs`) are left out.
fn sources() -> Vec<Source> {
    let src = root().join("src");
    let found: Vec<Source> = files(&src)
        .into_iter()
        .filter(|p| p.extension().is_some_and(|e| e == "rs") && p.file_name().is_some_and(|n| n != "tests.rs"))
        .map(|p| {
            let place = p.strip_prefix(&src).expect("below src").to_string_lossy().replace('\\', "/");
            let text = std::fs::read_to_string(&p).expect("a source is UTF-8");
            Source { place, code: before_tests(&text).to_string() }
        })
        .collect();
    assert!(found.len() > 50, "only {} sources were found", found.len());
    found
}

/// What stands before the tests of a file: a `#[cfg(test)]` followed by a module with a body.
fn before_tests(text: &str) -> &str {
    let is_body = |at: usize| {
        let declared = text[at..].lines().nth(1).unwrap_or_default();
        declared.contains("mod ") && declared.ends_with('{')
    };
    let at = text.match_indices("#[cfg(test)]").map(|(at, _)| at).find(|at| is_body(*at));
    &text[..at.unwrap_or(text.len())]
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The first names behind `crate::` or `amcheck::` in a text, groups in braces opened.
fn used(text: &str) -> Vec<String> {
    let mut names = Vec::new();
    for prefix in ["crate::", "amcheck::"] {
        for (at, _) in text.match_indices(prefix) {
            if text[..at].ends_with(|c: char| is_word(c) || c == '$') {
                continue;
            }
            let rest = &text[at + prefix.len()..];
            match rest.strip_prefix('{') {
                Some(group) => names.extend(heads(group)),
                None => names.push(rest.chars().take_while(|c| is_word(*c)).collect()),
            }
        }
    }
    names
}

/// The names that stand first in each member of a group, up to the group's end.
fn heads(group: &str) -> Vec<String> {
    let (mut depth, mut names, mut fresh) = (1, vec![String::new()], true);
    for c in group.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 1 => break,
            '}' => depth -= 1,
            ',' if depth == 1 => {
                names.push(String::new());
                fresh = true;
            }
            c if c.is_whitespace() => fresh &= names.last().is_some_and(String::is_empty),
            c if depth == 1 && fresh && is_word(c) => names.last_mut().expect("one at least").push(c),
            _ => fresh = false,
        }
    }
    names.retain(|n| !n.is_empty());
    names
}

/// The longest chain of `super::` in a line.
fn climbs(line: &str) -> usize {
    let (mut most, mut rest) = (0, line);
    while let Some(at) = rest.find("super::") {
        rest = &rest[at..];
        let mut chain = 0;
        while let Some(next) = rest.strip_prefix("super::") {
            rest = next;
            chain += 1;
        }
        most = most.max(chain);
    }
    most
}

fn assert_none(broken: Vec<String>, rule: &str) {
    assert!(broken.is_empty(), "{rule}:\n  {}", broken.join("\n  "));
}

#[test]
fn every_room_has_a_floor() {
    let unknown = |s: &Source| (s.place != "lib.rs" && floor(s.room()).is_none()).then(|| s.place.clone());
    assert_none(sources().iter().filter_map(unknown).collect(), "no floor is known for");
}

#[test]
fn imports_only_go_down() {
    let mut broken = Vec::new();
    for s in sources().iter().filter(|s| s.room() != ROOT) {
        let own = floor(s.room()).expect("every room has a floor");
        let code: String = s.lines().flat_map(|(_, l)| [l, "\n"]).collect();
        for name in used(&code) {
            let name = REEXPORTED.iter().find(|(n, _)| *n == name).map_or(name.as_str(), |(_, room)| room);
            let below = floor(name).is_some_and(|f| f < own);
            if name != s.room() && !below {
                broken.push(format!("{} (floor {own}) uses {name} (floor {:?})", s.place, floor(name)));
            }
        }
        for (number, line) in s.lines() {
            if climbs(line) >= s.path().len() {
                broken.push(format!("{}:{number} leaves its room by `super::`: {}", s.place, line.trim()));
            }
        }
    }
    broken.dedup();
    assert_none(broken, "an import goes up or sideways");
}

#[test]
fn the_reader_of_imports_sees_them() {
    assert_eq!(used("use crate::check::State;"), ["check"]);
    assert_eq!(used("use crate::{check::{A, B}, grid, units as u};"), ["check", "grid", "units"]);
    assert_eq!(used("x(crate::io::read(y), $crate::z, mycrate::w)"), ["io"]);
    assert_eq!((climbs("use super::super::x;"), climbs("super::a(super::b)"), climbs("x")), (2, 1, 0));
    assert_eq!(uncommented("a; // b"), "a; ");
    assert_eq!(
        before_tests("a\n#[cfg(test)]\nmod tests;\nb\n#[cfg(test)]\nmod tests {\n"),
        "a\n#[cfg(test)]\nmod tests;\nb\n"
    );
}

#[test]
fn names_say_what_is_inside() {
    const EMPTY: &[&str] = &["util", "utils", "common", "helper", "helpers", "misc", "types"];
    let broken = ["src", "tests", "benches"].iter().flat_map(|f| files(&root().join(f))).filter_map(|p| {
        let p = p.strip_prefix(root()).expect("below the root").to_path_buf();
        let empty = p.iter().any(|part| {
            let part = part.to_string_lossy();
            EMPTY.contains(&part.split('.').next().unwrap_or_default())
        });
        empty.then(|| p.display().to_string())
    });
    assert_none(broken.collect(), "a name that says nothing");
}

#[test]
fn a_mod_file_documents_declares_and_reexports() {
    const WORDS: &[&str] =
        &["fn", "impl", "struct", "enum", "union", "trait", "type", "const", "static", "macro_rules!"];
    let mut broken = Vec::new();
    for s in sources().iter().filter(|s| s.place.ends_with("/mod.rs")) {
        for (number, line) in s.lines() {
            let defines =
                line.split_whitespace().any(|word| WORDS.contains(&word.split('<').next().unwrap_or_default()));
            if defines {
                broken.push(format!("src/{}:{number} {}", s.place, line.trim()));
            }
        }
        if !s.code.starts_with("//! ") {
            broken.push(format!("src/{} does not say what the folder holds", s.place));
        }
    }
    assert_none(broken, "a mod.rs does more than document, declare and re-export");
}

#[test]
fn one_idea_is_one_file() {
    let long = |s: &Source| {
        let lines = s.code.lines().count();
        (lines > LINES).then(|| format!("src/{} has {lines} lines before its tests", s.place))
    };
    assert_none(sources().iter().filter_map(long).collect(), "more than 400 lines");
}

#[test]
fn nothing_is_left_for_later() {
    // Put together here, so that this file does not name what it looks for.
    let marks = ["to\u{64}o!", "unimplemente\u{64}!", "FIX\u{4d}E", "XX\u{58}", "HAC\u{4b}", "db\u{67}!"];
    let mut broken = Vec::new();
    for p in ["src", "tests", "benches"].iter().flat_map(|f| files(&root().join(f))) {
        if p.extension().is_none_or(|e| e != "rs") || p.ends_with("tests/house.rs") {
            continue;
        }
        let text = std::fs::read_to_string(&p).expect("a source is UTF-8");
        for (i, line) in text.lines().enumerate() {
            if marks.iter().any(|m| line.contains(m)) {
                broken.push(format!("{}:{} {}", p.display(), i + 1, line.trim()));
            }
        }
    }
    assert_none(broken, "a mark of unfinished work");
}

#[test]
fn readers_never_unwrap_what_came_from_outside() {
    let mut broken = Vec::new();
    for s in sources().iter().filter(|s| s.room() == "io") {
        for (number, line) in s.lines() {
            // A parser may have a method of its own named `expect`; it is called on `self`.
            let own = line.replace("self.expect(", "");
            if [".unwrap()", ".expect(", "unwrap_unchecked"].iter().any(|w| own.contains(w)) {
                broken.push(format!("src/{}:{number} {}", s.place, line.trim()));
            }
        }
    }
    assert_none(broken, "a reader unwraps");
}

#[test]
fn no_reader_takes_a_rule_back() {
    // The compiler and clippy hold these for the whole room; here is held that nobody takes them back.
    let rooms = std::fs::read_to_string(root().join("src/io/mod.rs")).expect("the reading room");
    for rule in
        ["unsafe_code", "clippy::unwrap_used", "clippy::expect_used", "clippy::indexing_slicing", "clippy::panic"]
    {
        assert!(rooms.contains(rule), "src/io/mod.rs does not ask for {rule}");
    }
    let mut broken = Vec::new();
    for s in sources().iter().filter(|s| s.room() == "io") {
        for (number, line) in s.lines() {
            if line.contains("allow(") || line.contains("expect(clippy") || line.contains("unsafe ") {
                broken.push(format!("src/{}:{number} {}", s.place, line.trim()));
            }
        }
    }
    assert_none(broken, "a reader takes a rule back");
}

/// The files that git tracks; without git, those below the folders that are always tracked.
fn tracked() -> Vec<PathBuf> {
    let listed = std::process::Command::new("git").args(["ls-files", "-z"]).current_dir(root()).output();
    match listed {
        Ok(out) if out.status.success() && !out.stdout.is_empty() => {
            let names = String::from_utf8_lossy(&out.stdout).into_owned();
            names.split('\0').filter(|n| !n.is_empty()).map(|n| root().join(n)).filter(|p| p.is_file()).collect()
        }
        _ => ["src", "tests", "benches", "fixtures"].iter().flat_map(|f| files(&root().join(f))).collect(),
    }
}

#[test]
fn no_file_names_a_place_of_one_machine() {
    let places = ["work", "tmp", "home", "Users"].map(|name| format!("/{name}/"));
    let mut broken = Vec::new();
    for p in tracked() {
        let Ok(text) = std::fs::read_to_string(&p) else { continue };
        for (i, line) in text.lines().enumerate() {
            // A place starts behind a blank, a quote or a bracket; in `a/home/b` and in addresses it is a name like others.
            let starts = |at: usize| !line[..at].ends_with(|c: char| is_word(c) || "./-:}".contains(c));
            if places.iter().any(|place| line.match_indices(place).any(|(at, _)| starts(at))) {
                broken.push(format!("{}:{}", p.display(), i + 1));
            }
        }
    }
    assert_none(broken, "a path of one machine");
}
