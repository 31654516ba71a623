//! Rendering the fixtures again with an installed OpenSCAD, refusing its silent failures.

use super::fixture::*;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// The version line of the installed program, or `None` where there is none.
pub fn version() -> Option<String> {
    let out = Command::new("openscad").arg("--version").output().ok()?;
    let text = [out.stdout, out.stderr].concat();
    Some(String::from_utf8_lossy(&text).trim().to_string())
}

/// What one rendering gave.
pub enum Rendered {
    Solid,
    Empty,
}

/// Renders one part of one source into a folder.
///
/// OpenSCAD reports a failed Minkowski sum on stderr, returns the first operand and exits with 0: any error or
/// warning is therefore a failure here, but for the two that are expected.
pub fn render(name: &str, part: &str, into: &Path) -> Result<Rendered, String> {
    let target = stl(into, name, part);
    let mut child = Command::new("openscad")
        .args(["--export-format", "binstl", "-D", &format!("part=\"{part}\""), "-o"])
        .arg(&target)
        .arg(source(name))
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::null())
        .spawn()
        .map_err(|e| format!("{name} {part}: {e}"))?;
    let started = Instant::now();
    while child.try_wait().map_err(|e| e.to_string())?.is_none() {
        if started.elapsed() > Duration::from_secs(600) {
            child.kill().map_err(|e| e.to_string())?;
            return Err(format!("{name} {part}: no answer after 600 s"));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let out = child.wait_with_output().map_err(|e| e.to_string())?;
    judge(name, part, out.status.success(), &String::from_utf8_lossy(&out.stderr))
}

/// Decides from the exit status and stderr whether a rendering can be believed.
pub fn judge(name: &str, part: &str, success: bool, stderr: &str) -> Result<Rendered, String> {
    let empty = stderr.contains("Current top level object is empty");
    if name == "f17_erode_empty" && part == "R" {
        return if empty && !success { Ok(Rendered::Empty) } else { Err(format!("{name} {part} should be empty")) };
    }
    let expected =
        |line: &&str| name == "f16_edge_touch" && part == "A" && line.contains("may not be a valid 2-manifold");
    let complaints: Vec<&str> = stderr
        .lines()
        .filter(|line| ["ERROR", "WARNING", "CGAL error"].iter().any(|word| line.contains(word)))
        .filter(|line| !expected(line))
        .collect();
    if success && complaints.is_empty() && !empty {
        Ok(Rendered::Solid)
    } else {
        Err(format!("{name} {part}: exit ok {success}, said {complaints:?}"))
    }
}

/// Renders a whole fixture and measures it; a sum with the volume of its first operand is a failure too.
pub fn render_all(fixture: &Fixture, into: &Path) -> Result<Entry, String> {
    let name = fixture.name;
    let mut measured = Vec::new();
    let mut seconds = 0.0;
    for part in PARTS {
        let before = processor_seconds()[1];
        let rendered = render(name, part, into)?;
        seconds = processor_seconds()[1] - before;
        measured.push(match rendered {
            Rendered::Empty => None,
            Rendered::Solid => {
                let mesh = load(&stl(into, name, part));
                if part == "R" && open_edges(&mesh) > 0 {
                    return Err(format!("{name} {part} is not closed"));
                }
                Some(Measured::of(&mesh))
            }
        });
    }
    let [Some(a), Some(b), r] = &measured[..] else { return Err(format!("{name}: an operand is empty")) };
    if r.as_ref().is_some_and(|r| r.volume_mm3 == a.volume_mm3) {
        return Err(format!("{name}: the result is its first operand unchanged"));
    }
    Ok(Entry {
        name: name.into(),
        operation: fixture.operation,
        source_sha256: sha256(&source(name)),
        a: a.clone(),
        b: b.clone(),
        r: r.clone(),
        seconds: (seconds * 100.0).round() / 100.0,
    })
}

/// User seconds of this process, all threads, and of its children that have ended; zeros where there is no `/proc`.
pub fn processor_seconds() -> [f64; 2] {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Fields 14 and 16, counted from the first; the second holds a name in brackets. A tick is a hundredth of a second.
    let fields: Vec<f64> =
        text.rsplit(')').next().unwrap_or("").split_whitespace().map(|w| w.parse().unwrap_or(0.0)).collect();
    [11, 13].map(|at| fields.get(at).copied().unwrap_or(0.0) / 100.0)
}
