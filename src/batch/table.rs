//! All lines of a batch: CSV, JSON lines, and columns for a terminal.

use super::index;
use super::row::Row;
use super::shard::Shard;
use super::store::cannot;
use crate::error::{Result, escaped};
use crate::io::write_atomically;
use std::fmt::Write;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

const HEAD: &str = "part,code,verdict,line,error,place,fails,undecided,warns,warnings,triangles,bodies,size_x_mm,size_y_mm,\
                    size_z_mm,volume_mm3,seconds,peak_mib,reused,sha256,folder";

/// The lines as comma-separated values (RFC 4180), a head before them.
///
/// A text that a spreadsheet would take for a formula gets an apostrophe before it, and control characters are escaped; JSON lines have
/// both unchanged.
pub fn csv(rows: &[Row]) -> String {
    let mut out = format!("{HEAD}\r\n");
    for r in rows {
        let size = r.size_mm.unwrap_or([f64::NAN; 3]).map(number);
        let [fails, undecided, warns] = r.findings;
        let cells = [
            cell(&r.part),
            r.code.to_string(),
            r.verdict.map_or(String::new(), |v| format!("{v:?}").to_lowercase()),
            cell(&r.line),
            r.error.as_ref().map_or(String::new(), |e| e.code.clone()),
            cell(r.error.as_ref().and_then(|e| e.place.as_deref()).unwrap_or_default()),
            fails.to_string(),
            undecided.to_string(),
            warns.to_string(),
            r.warnings.to_string(),
            r.triangles.map_or(String::new(), |n| n.to_string()),
            r.bodies.map_or(String::new(), |n| n.to_string()),
            size[0].clone(),
            size[1].clone(),
            size[2].clone(),
            number(r.volume_mm3.unwrap_or(f64::NAN)),
            number(r.seconds),
            number(r.peak_mib.unwrap_or(f64::NAN)),
            r.reused.to_string(),
            r.sha256.clone().unwrap_or_default(),
            cell(r.folder.as_deref().unwrap_or_default()),
        ];
        out.push_str(&cells.join(","));
        out.push_str("\r\n");
    }
    out
}

fn number(x: f64) -> String {
    if x.is_finite() { x.to_string() } else { String::new() }
}

fn cell(text: &str) -> String {
    let formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']);
    let text = if formula { format!("'{}", escaped(text)) } else { escaped(text) };
    if text.contains(['"', ',']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// The lines as JSON, one object on each line.
pub fn json_lines(rows: &[Row]) -> String {
    rows.iter().filter_map(|r| serde_json::to_string(r).ok()).fold(String::new(), |all, row| all + &row + "\n")
}

/// One line for a terminal: code, seconds, memory, part, what was found.
///
/// Neither name nor sentence can carry an escape sequence there.
pub fn line(row: &Row, width: usize) -> String {
    let mut out = String::new();
    let memory = row.peak_mib.map_or("-".into(), |m| format!("{m:.0}"));
    let seconds = if row.reused { "kept".into() } else { format!("{:.1}", row.seconds) };
    let _ = write!(out, "{:>4} {seconds:>7} {memory:>6}  {:<40} ", row.code, escaped(&row.part));
    let room = width.saturating_sub(out.chars().count()).max(20);
    let text: String = row.line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().count() > room {
        out.extend(text.chars().take(room - 1).chain(['…']));
    } else {
        out.push_str(&text);
    }
    out.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// What the names of tables begin and end with; the tag of a share stands between.
const NAMES: [(&str, &str); 3] = [("table", ".csv"), ("table", ".jsonl"), ("index", ".html")];

/// Writes `table.csv`, `table.jsonl` and `index.html` into a folder, each whole or not at all; those of a share have its tag.
///
/// Returns the three places.
///
/// # Errors
/// [`crate::Error::CannotWrite`] naming the file.
pub fn write_tables(out: &Path, shard: Option<Shard>, rows: &[Row]) -> Result<[PathBuf; 3]> {
    let tag = shard.map_or(String::new(), Shard::tag);
    let places = NAMES.map(|(start, end)| out.join(format!("{start}{tag}{end}")));
    for (place, text) in places.iter().zip([csv(rows), json_lines(rows), index::page(rows)]) {
        write_atomically(place, |w| w.write_all(text.as_bytes()))?;
    }
    Ok(places)
}

/// Removes the tables that a new one makes untrue: those of shares of another number, and of all shares where it is of the whole.
///
/// # Errors
/// [`crate::Error::CannotWrite`] naming the file.
pub fn remove_outdated(out: &Path, shard: Option<Shard>) -> Result<()> {
    let outdated = |name: &str| {
        let tag = |(start, end): &(&str, &str)| name.strip_prefix(*start)?.strip_suffix(*end);
        let other = NAMES.iter().filter_map(tag).find_map(Shard::tagged);
        other.is_some_and(|other| shard.is_none_or(|own| own.count != other.count))
    };
    for member in fs::read_dir(out).into_iter().flatten().flatten() {
        if outdated(&member.file_name().to_string_lossy()) {
            match fs::remove_file(member.path()) {
                // Another task of the same array may have been faster.
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(cannot(&member.path(), &e)),
                _ => {}
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    fn row(part: &str) -> Row {
        let error = Error::NoGeometry { problem: "a \"b\", c".into(), remedy: "d".into() };
        Row::refused(part, &error)
    }

    #[test]
    fn names_break_out_of_no_table() {
        let rows = [row("=1+1,<script>|\"x\".stl"), row("plain.stl")];
        let table = csv(&rows);
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines[0].split(',').count(), 21);
        assert!(lines[1].starts_with("\"'=1+1,<script>|\"\"x\"\".stl\",4,,\"a \"\"b\"\", c\",E013,"), "{}", lines[1]);
        let back: Row = serde_json::from_str(json_lines(&rows).lines().next().unwrap()).unwrap();
        assert_eq!(back, rows[0]);
        let page = index::page(&rows);
        assert!(!page.contains("<script>|") && page.contains("&lt;script&gt;|"), "{page}");
        assert!(!line(&row("\u{1b}[31m.stl"), 100).contains('\u{1b}'));
        assert!(
            line(&row("new\nline.stl"), 100).contains("new\\nline.stl")
                && csv(&[row("new\nline.stl")]).contains("new\\nline.stl")
        );
        assert!(line(&Row { line: "x".repeat(500), ..row("a") }, 100).chars().count() <= 100);
    }
}
