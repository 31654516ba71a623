//! Lists of rows of numbers, where an empty line parts what hangs together.

use super::sniff::plain_text;
use super::words::{Word, Words};
use crate::error::{Error, Place, Result};
use crate::notice::number_of;

/// Most rows that are read; the path of a print of a week has fewer.
pub(super) const MOST_ROWS: usize = 1 << 26;

/// Strokes of rows of N numbers each, every row made into something; an empty line begins a new stroke, `#` a comment. A first line of names alone,
/// as tables have it, is passed over.
///
/// Numbers may be parted by spaces, tabs, semicolons or, without a space or semicolon between them, commas; the decimal sign is a point. `what`
/// says what a row is, for the remedy.
///
/// # Errors
/// [`Error::Damaged`] naming the line, with what `make` says of a row; [`Error::TooLarge`] beyond [`MOST_ROWS`].
pub(super) fn strokes<const N: usize, T>(
    bytes: &[u8],
    what: &str,
    make: impl Fn([f64; N]) -> std::result::Result<T, String>,
) -> Result<Vec<Stroke<T>>> {
    let text = plain::<N>(bytes);
    let mut words = Words::new(&text);
    let mut strokes: Vec<Stroke<T>> = Vec::new();
    // The first row begins a stroke wherever it stands.
    let (mut last_line, mut rows) = (None, 0);
    while let Some(first) = words.peek() {
        let line = first.line;
        if first.text.starts_with(b"#") {
            words.next();
            words.skip_line();
            last_line = last_line.map(|_| line);
            continue;
        }
        let row = row::<N>(&mut words, line, what)?;
        let made = make(row).map_err(|problem| damaged(line, problem, what))?;
        if last_line.is_none_or(|last| line > last + 1) {
            strokes.push(Stroke { line, rows: Vec::new() });
        }
        last_line = Some(line);
        rows += 1;
        rows_fit(rows, 8 * N)?;
        if let Some(stroke) = strokes.last_mut() {
            stroke.rows.push(made);
        }
    }
    Ok(strokes)
}

/// Rows that hang together, and the line of the first.
pub(super) struct Stroke<T> {
    pub line: u64,
    pub rows: Vec<T>,
}

/// The rows of strokes of two or more each; none where there is a single row in all.
///
/// # Errors
/// [`Error::Damaged`] naming the line of a row that stands alone: a path does not lead there.
pub(super) fn led<T>(strokes: Vec<Stroke<T>>, what: &str) -> Result<Vec<Vec<T>>> {
    if let [Stroke { rows, .. }] = strokes.as_slice()
        && rows.len() < 2
    {
        return Ok(Vec::new());
    }
    let led = |s: Stroke<T>| match s.rows.len() {
        1 => {
            let problem =
                "the line stands alone: an empty line ends a stroke, and a stroke takes two lines or more".to_owned();
            Err(damaged(s.line, problem, what))
        }
        _ => Ok(s.rows),
    };
    strokes.into_iter().map(led).collect()
}

/// How many numbers the first row has, N to be tried first for rows parted by commas.
pub(super) fn first_row<const N: usize>(bytes: &[u8]) -> usize {
    let text = plain::<N>(bytes);
    let mut words = Words::new(&text);
    while let Some(first) = words.next() {
        if !first.text.starts_with(b"#") {
            let others = words.take_while(|w| w.line == first.line && !w.text.starts_with(b"#"));
            return 1 + others.filter(|w| w.text != b",").count();
        }
        words.skip_line();
    }
    0
}

/// The numbers of a row.
fn row<const N: usize>(words: &mut Words<'_>, line: u64, what: &str) -> Result<[f64; N]> {
    let mut row = [0.0; N];
    let here = |word: Option<Word<'_>>| word.is_some_and(|w| w.line == line && !w.text.starts_with(b"#"));
    for (at, value) in row.iter_mut().enumerate() {
        if !here(words.peek()) {
            let found = number_of(at as u64, ["number", "numbers"]);
            return Err(damaged(line, format!("{found} on the line, where {N} are needed"), what));
        }
        let Some(word) = words.next() else { break };
        *value = word.number().ok_or_else(|| {
            let (problem, remedy) = word.number_problem();
            damaged(line, problem, remedy)
        })?;
    }
    if words.peek().is_some_and(|w| w.line == line && w.text == b",") {
        return Err(damaged(line, format!("a comma stands behind the {N} numbers of the line"), LAST_COMMA));
    }
    if here(words.peek()) {
        return Err(damaged(line, format!("more than {N} numbers on the line"), what));
    }
    Ok(row)
}

const LAST_COMMA: &str = "take the comma at the end of the line away";

/// The text with its separators as spaces, without a byte order mark and with a line of names at its head as a comment.
fn plain<const N: usize>(bytes: &[u8]) -> Vec<u8> {
    let bytes = plain_text(bytes);
    let mut text: Vec<u8> = bytes.split_inclusive(|&b| b == b'\n').flat_map(separated::<N>).collect();
    if let Some(first) = head(&text).and_then(|at| text.get_mut(at)) {
        *first = b'#';
    }
    text
}

/// Where a line of names at the head of a text starts: the first line that is not empty and no comment, if no field of it begins like a number.
fn head(text: &[u8]) -> Option<usize> {
    let mut words = Words::new(text);
    let mut first = words.next()?;
    while first.text.starts_with(b"#") {
        words.skip_line();
        first = words.next()?;
    }
    let left = words.bytes_left() + first.text.len();
    let row = std::iter::once(first).chain(words.take_while(|w| w.line == first.line && !w.text.starts_with(b"#")));
    let mut fields = row.flat_map(|w| w.text.split(|b| *b == b','));
    let numeric = |f: &[u8]| {
        let no_number = ["nan", "inf", "infinity"].iter().any(|word| f.eq_ignore_ascii_case(word.as_bytes()));
        no_number || f.first().is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b))
    };
    fields.all(|f| !numeric(f)).then(|| text.len() - left)
}

/// A line with its separators as spaces: semicolons always; commas where they part N fields, or numbers, without a space in them, because
/// elsewhere they are decimal signs. One that stands behind the last of N fields stays, with a space before it.
fn separated<const N: usize>(line: &[u8]) -> impl Iterator<Item = u8> + '_ {
    let values = line.split(|&b| b == b'#').next().unwrap_or_default().trim_ascii_end();
    let inner = values.strip_suffix(b",").unwrap_or(values);
    let whole = |field: &[u8]| {
        let field = field.trim_ascii();
        !field.is_empty() && !field.iter().any(|b| b.is_ascii_whitespace() || *b == b';')
    };
    let number = |field: &[u8]| Word { text: field.trim_ascii(), line: 0 }.number().is_some();
    let fields = inner.split(|&b| b == b',');
    let are_all = fields.clone().count() == N;
    let commas = if are_all { fields.into_iter().all(whole) } else { fields.into_iter().all(number) };
    let last = if commas && are_all && inner.len() < values.len() { inner.len() } else { usize::MAX };
    line.iter().enumerate().flat_map(move |(at, &b)| {
        let b = if b == b';' || (commas && b == b',' && at != last) { b' ' } else { b };
        (at == last).then_some(b' ').into_iter().chain([b])
    })
}

/// Refuses more rows than are read.
///
/// # Errors
/// [`Error::TooLarge`].
pub(super) fn rows_fit(rows: usize, bytes: usize) -> Result<()> {
    if rows <= MOST_ROWS {
        return Ok(());
    }
    Err(Error::TooLarge {
        what: format!("a path of {rows} corners"),
        need_bytes: rows as u128 * bytes as u128,
        allowed_bytes: MOST_ROWS as u128 * bytes as u128,
        remedy: "take a part of the path".into(),
    })
}

fn damaged(line: u64, problem: String, remedy: &str) -> Error {
    Error::Damaged { format: "path", place: Place::Line(line), problem, remedy: remedy.into() }
}
