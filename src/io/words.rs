//! Words of a text with the lines they stand on, whatever the line ends.

/// A word and its line, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Word<'a> {
    pub(super) text: &'a [u8],
    pub(super) line: u64,
}

impl Word<'_> {
    /// Whether the word is this keyword, in any case.
    pub(super) fn is(&self, keyword: &str) -> bool {
        self.text.eq_ignore_ascii_case(keyword.as_bytes())
    }

    /// The word for a message, with bytes that are not UTF-8 replaced and control characters escaped.
    pub(super) fn shown(&self) -> String {
        crate::error::printable(&String::from_utf8_lossy(self.text))
    }

    /// The number the word spells in decimal; infinite where it is out of the range of f64.
    ///
    /// `nan`, `inf` and hexadecimal numbers are not numbers here.
    pub(super) fn number(&self) -> Option<f64> {
        let first = self.text.iter().find(|b| !matches!(b, b'+' | b'-'))?;
        if !(first.is_ascii_digit() || *first == b'.') {
            return None;
        }
        std::str::from_utf8(self.text).ok()?.parse().ok()
    }

    /// What is wrong with a word that should have been a number.
    pub(super) fn number_problem(&self) -> (String, &'static str) {
        let comma = self.text.contains(&b',') && self.text.iter().any(u8::is_ascii_digit);
        let remedy = if comma {
            "the decimal sign must be a point: export again with an English number format (locale)"
        } else {
            "export the file again"
        };
        (format!("`{}` is not a number", self.shown()), remedy)
    }
}

/// A cursor over the words of a text; copying it is looking ahead.
///
/// Line ends are LF, CR or CRLF.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words<'a> {
    rest: &'a [u8],
    line: u64,
}

impl<'a> Words<'a> {
    /// The words of a text, from line 1.
    pub(super) fn new(text: &'a [u8]) -> Self {
        Words { rest: text, line: 1 }
    }

    /// The words of a text whose first line has this number.
    pub(super) fn from_line(text: &'a [u8], line: u64) -> Self {
        Words { rest: text, line }
    }

    /// Bytes that are left.
    pub(super) fn bytes_left(&self) -> usize {
        self.rest.len()
    }

    /// The line the cursor stands on.
    pub(super) fn line(&self) -> u64 {
        self.line
    }

    /// The next word, without going there.
    pub(super) fn peek(&self) -> Option<Word<'a>> {
        { *self }.next()
    }

    /// Goes on to the end of the present line.
    pub(super) fn skip_line(&mut self) {
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        self.rest = self.rest.get(end..).unwrap_or_default();
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = Word<'a>;

    fn next(&mut self) -> Option<Word<'a>> {
        let mut start = 0;
        let mut before = 0u8;
        for &b in self.rest {
            match b {
                b'\r' => self.line += 1,
                b'\n' if before != b'\r' => self.line += 1,
                b'\n' | b' ' | b'\t' | 0x0b | 0x0c => {}
                _ => break,
            }
            before = b;
            start += 1;
        }
        let rest = self.rest.get(start..).unwrap_or_default();
        let is_space = |b: &u8| matches!(b, b' ' | b'\t'..=b'\r');
        let (text, rest) = rest.split_at(rest.iter().position(is_space).unwrap_or(rest.len()));
        self.rest = rest;
        (!text.is_empty()).then_some(Word { text, line: self.line })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_for_every_line_end() {
        for text in ["a b\nc\n\n d", "a b\rc\r\r d", "a b\r\nc\r\n\r\n\td"] {
            let found: Vec<_> = Words::new(text.as_bytes()).map(|w| (w.text[0], w.line)).collect();
            assert_eq!(found, [(b'a', 1), (b'b', 1), (b'c', 2), (b'd', 4)], "{text:?}");
        }
        let mut w = Words::new(b"name of part\r\nnext");
        w.next();
        w.skip_line();
        assert_eq!(w.peek().map(|w| w.line), Some(2));
    }

    #[test]
    fn numbers_are_decimal_only() {
        let number = |t: &str| Word { text: t.as_bytes(), line: 1 }.number();
        assert_eq!(number("-1.5e3"), Some(-1500.0));
        assert_eq!(number("+.5"), Some(0.5));
        assert_eq!(number("1e400"), Some(f64::INFINITY));
        for bad in ["nan", "-inf", "infinity", "0x10", "1,5", "blah", "", "-", "1.0f"] {
            assert_eq!(number(bad), None, "{bad}");
        }
    }
}
