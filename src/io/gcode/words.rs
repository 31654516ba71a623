//! The words of a line of G-code: letters with numbers.

use super::damaged;
use crate::error::{Error, Result, printable};
use crate::io::words::Word;

/// The words of one line.
#[derive(Default)]
pub(super) struct Words {
    pub(super) commands: Vec<(u8, f64)>,
    values: [Option<f64>; LETTERS.len()],
    /// A letter that stands on the line with two numbers.
    pub(super) twice: Option<u8>,
    /// What ended the line before its end, and is no word: no motion that is in force goes on with such a line.
    pub(super) stray: Option<u8>,
}

/// M commands of machine tools that a motion may follow on its line; behind the others come messages and names of files.
const BEFORE_MOTION: &[f64] = &[3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 82.0, 83.0];

/// Letters whose numbers count.
const LETTERS: &[u8; 15] = b"XYZEIJRLPABCUVW";

impl Words {
    /// The number behind a letter.
    pub(super) fn get(&self, letter: u8) -> Option<f64> {
        LETTERS.iter().position(|&l| l == letter).and_then(|i| self.values.get(i).copied().flatten())
    }

    /// The numbers behind X, Y and Z.
    pub(super) fn position(&self) -> [Option<f64>; 3] {
        [self.get(b'X'), self.get(b'Y'), self.get(b'Z')]
    }

    /// Whether a line without a G command goes on with the motion that is in force: what it names belongs to one, and nothing else.
    pub(super) fn go_on(&self) -> bool {
        let of_motion = |&letter: &u8| self.get(letter).is_some();
        let by_axes = self.position().iter().any(Option::is_some);
        by_axes || self.commands.iter().all(|c| c.0 == b'G') && b"EIJR".iter().any(of_motion)
    }
}

/// The commands and numbers of a line, without comments, line number and checksum.
///
/// What does not look like letters with numbers (messages) ends the line, unless it belongs to a motion; a line that begins with the name of a macro
/// has no words. Blanks between a letter and its number say nothing (T. Kramer, F. Proctor, E. Messina, *The NIST RS274NGC interpreter*, 2000, section 3.3.1).
pub(super) fn words(line: u64, bytes: &[u8]) -> Result<Words> {
    let mut words = Words::default();
    let mut rest = bytes;
    while let Some((&first, after)) = rest.split_first() {
        let at = bytes.len() - rest.len();
        rest = after;
        let letter = first.to_ascii_uppercase();
        match letter {
            b' ' | b'\t' | b'\r' => continue,
            b';' | b'*' | b'%' | b'/' => break,
            b'(' => {
                let end = rest.iter().position(|&b| b == b')').map_or(rest.len(), |i| i + 1);
                rest = rest.get(end..).unwrap_or_default();
                continue;
            }
            _ => {}
        }
        rest = rest.trim_ascii_start();
        let digits = rest.iter().position(|b| !b"+-.0123456789".contains(b)).unwrap_or(rest.len());
        let (text, after) = rest.split_at(digits);
        let value = Word { text, line }.number();
        let moves = words.commands.iter().any(|&(l, c)| l == b'G' && c < 4.0);
        let homes = words.commands.contains(&(b'G', 28.0));
        let slot = LETTERS.iter().position(|&l| l == letter);
        match (value, slot.and_then(|i| words.values.get_mut(i))) {
            (Some(value), Some(to)) => {
                if to.replace(value).is_some() {
                    words.twice = Some(letter);
                }
            }
            (Some(value), None) if letter == b'G' => words.commands.push((letter, value)),
            (Some(value), None) if letter == b'M' => {
                words.commands.push((letter, value));
                if !BEFORE_MOTION.contains(&value) {
                    break;
                }
            }
            (Some(_), None) if letter.is_ascii_alphabetic() => {}
            (None, Some(to)) if homes => *to = Some(0.0),
            _ if moves => return Err(no_word(line, first, bytes)),
            _ if words.commands.is_empty() && is_in_name(at, bytes) => return Ok(Words::default()),
            _ => {
                words.stray = Some(first);
                break;
            }
        }
        rest = after;
    }
    Ok(words)
}

/// A line of a motion with something on it that is no word.
pub(super) fn no_word(line: u64, stray: u8, bytes: &[u8]) -> Error {
    let shown = |b: &[u8]| printable(&String::from_utf8_lossy(b));
    damaged(line, format!("`{}` in `{}` is no word of G-code", shown(&[stray]), shown(bytes)))
}

/// Whether what is no word stands in the first thing of a line but for its number, and that may be a macro's name: `E3D_PURGE` is neither E3 nor a
/// motion.
fn is_in_name(at: usize, bytes: &[u8]) -> bool {
    let (before, behind) = bytes.split_at(at);
    let ends = |b: &u8| b" \t\r;(*".contains(b);
    let start = before.iter().rposition(ends).map_or(0, |i| i + 1);
    let end = behind.iter().position(ends).map_or(bytes.len(), |i| at + i);
    let is_number = |word: &[u8]| {
        let digits = word.strip_prefix(b"N").or(word.strip_prefix(b"n"));
        word.is_empty() || digits.is_some_and(|digits| digits.iter().all(u8::is_ascii_digit))
    };
    let (earlier, name) = (before.get(..start).unwrap_or_default(), bytes.get(start..end).unwrap_or_default());
    let may_begin = |b: &u8| b.is_ascii_alphabetic() || *b == b'_';
    earlier.split(ends).all(is_number)
        && name.len() > 1
        && name.first().is_some_and(may_begin)
        && name.iter().all(|&b| b.is_ascii_alphanumeric() || b == b'_')
}
