//! The report as JSON: the same report gives the same bytes.
//!
//! Keys stand in the order of the schema, maps are sorted, numbers are rounded to 1e-6, and a list of numbers
//! keeps to one line, so that a difference between two reports reads well.

use super::schema::Report;
use crate::units::report_digits;
use serde::Serialize;
use serde_json::ser::Formatter;
use std::io::{self, Write};

/// The published JSON Schema of `amcheck-report/1`.
pub const SCHEMA_TEXT: &str = include_str!("schema.json");

/// The report as indented JSON with a line feed at its end.
///
/// A number that is not finite is written as `null`, which the schema refuses: no check may hand one over.
///
/// # Cost
/// O(length of the text).
pub fn write(report: &Report) -> String {
    let mut out = Vec::with_capacity(1 << 14);
    let mut to = serde_json::Serializer::with_formatter(&mut out, Layout::default());
    // Writing plain data to memory cannot fail; an empty text would be refused by every reader.
    if report.serialize(&mut to).is_err() {
        out.clear();
    }
    out.push(b'\n');
    String::from_utf8_lossy(&out).into_owned()
}

/// JSON that may stand inside an HTML element: `<`, `>`, `&` and the two line separators are written as `\u…`.
///
/// The result is the same JSON value, and holds no `</script`, no comment and no entity.
///
/// ```
/// assert_eq!(amcheck::report::json::inside_html(r#"{"file":"</script>"}"#), r#"{"file":"\u003c/script\u003e"}"#);
/// ```
pub fn inside_html(json: &str) -> String {
    let mut out = String::with_capacity(json.len() + json.len() / 16);
    for c in json.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => out.push_str(&format!("\\u{:04x}", c as u32)),
            c => out.push(c),
        }
    }
    out
}

/// Layout of the text: two spaces a level; a list breaks its line only where it holds objects or lists.
#[derive(Default)]
struct Layout {
    levels: Vec<Level>,
}

/// One open list or object.
struct Level {
    broken: bool,
    first: bool,
    list: bool,
}

impl Layout {
    fn indent<W: ?Sized + Write>(&self, w: &mut W, depth: usize) -> io::Result<()> {
        w.write_all(b"\n")?;
        (0..depth).try_for_each(|_| w.write_all(b"  "))
    }

    /// Before a list or object opens: as a member of a list of such it starts a line of its own.
    fn open<W: ?Sized + Write>(&mut self, w: &mut W, list: bool) -> io::Result<()> {
        let depth = self.levels.len();
        if let Some(parent) = self.levels.last_mut().filter(|p| p.list) {
            parent.broken = true;
            self.indent(w, depth)?;
        }
        self.levels.push(Level { broken: !list, first: true, list });
        Ok(())
    }

    fn close<W: ?Sized + Write>(&mut self, w: &mut W, end: &[u8]) -> io::Result<()> {
        if self.levels.pop().is_some_and(|l| l.broken && !l.first) {
            self.indent(w, self.levels.len())?;
        }
        w.write_all(end)
    }

    /// Whether the next member is the first; marks it as seen.
    fn first(&mut self) -> bool {
        self.levels.last_mut().is_some_and(|l| std::mem::replace(&mut l.first, false))
    }
}

impl Formatter for Layout {
    fn write_f64<W: ?Sized + Write>(&mut self, w: &mut W, value: f64) -> io::Result<()> {
        serde_json::to_writer(w, &report_digits(value)).map_err(io::Error::from)
    }

    fn begin_array<W: ?Sized + Write>(&mut self, w: &mut W) -> io::Result<()> {
        self.open(w, true)?;
        w.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, w: &mut W) -> io::Result<()> {
        self.close(w, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, w: &mut W, _first: bool) -> io::Result<()> {
        let broken = self.levels.last().is_some_and(|l| l.broken);
        match (self.first(), broken) {
            (true, _) => Ok(()),
            (false, true) => w.write_all(b","),
            (false, false) => w.write_all(b", "),
        }
    }

    fn begin_object<W: ?Sized + Write>(&mut self, w: &mut W) -> io::Result<()> {
        self.open(w, false)?;
        w.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, w: &mut W) -> io::Result<()> {
        self.close(w, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, w: &mut W, _first: bool) -> io::Result<()> {
        if !self.first() {
            w.write_all(b",")?;
        }
        self.indent(w, self.levels.len())
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, w: &mut W) -> io::Result<()> {
        w.write_all(b": ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laid_out(value: &serde_json::Value) -> String {
        let mut out = Vec::new();
        value.serialize(&mut serde_json::Serializer::with_formatter(&mut out, Layout::default())).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn lists_of_numbers_keep_to_one_line_and_digits_are_cut() {
        let value = serde_json::json!({"a": [1.00000049, -1e-9], "b": [{"c": 1}, {"c": []}], "d": {}, "e": [[1], [2]]});
        let text = laid_out(&value);
        assert_eq!(
            text,
            "{\n  \"a\": [1.0, 0.0],\n  \"b\": [\n    {\n      \"c\": 1\n    },\n    {\n      \"c\": []\n    }\n  ],\n  \
             \"d\": {},\n  \"e\": [\n    [1],\n    [2]\n  ]\n}"
        );
        let back: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(back["b"], value["b"]);
    }
}
