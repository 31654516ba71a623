//! Binary or ASCII: decided by length and content, never by the word `solid` alone.
//!
//! 3 % of binary files in the wild start with `solid`, and many loaders take them for text.

use crate::error::{Error, Place, Result};

/// Bytes before the first facet of a binary file: 80 of header and the count.
pub(in crate::io) const HEAD: usize = 84;
/// Bytes of a binary facet: normal, three corners, two attribute bytes.
pub(in crate::io) const FACET: usize = 50;

/// The two kinds of STL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Kind {
    Text,
    Binary,
}

/// The count a binary file claims, if it is long enough to claim one.
pub(in crate::io) fn claimed_count(bytes: &[u8]) -> Option<u32> {
    bytes.get(80..HEAD).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes)
}

/// Whether the length is that of a binary file with the count it claims.
pub(in crate::io) fn fits_binary(bytes: &[u8]) -> bool {
    claimed_count(bytes).is_some_and(|n| bytes.len() as u64 == HEAD as u64 + FACET as u64 * u64::from(n))
}

/// Whether the bytes start with `solid` (any case, after a mark and white space) and go on like ASCII STL.
pub(in crate::io) fn looks_like_text(bytes: &[u8]) -> bool {
    let body = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let Some(rest) = strip_word(body, b"solid") else { return false };
    // A short file cannot be binary; a long one must show a keyword at the start of its name line or just after it.
    if bytes.len() < HEAD {
        return true;
    }
    let line = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
    let near = |window: &[u8]| ["facet", "endsolid"].iter().any(|w| holds_word(window, w.as_bytes()));
    let after = rest.get(line..).unwrap_or_default();
    let upto = |part: &'_ [u8]| part.len().min(4096);
    near(after.get(..upto(after)).unwrap_or_default()) || near(rest.get(..upto(rest)).unwrap_or_default())
}

/// Whether bytes that fit nothing else can be a damaged binary file: the first facet is whole, its corners
/// are ordinary numbers, and its normal is a unit vector or zero.
pub(in crate::io) fn may_be_binary(bytes: &[u8]) -> bool {
    let Some(facet) = bytes.get(HEAD..HEAD + FACET) else { return false };
    let numbers: Vec<f32> =
        facet.chunks_exact(4).filter_map(|b| b.try_into().ok()).map(f32::from_le_bytes).take(12).collect();
    let (normal, corners) = numbers.split_at_checked(3).unwrap_or_default();
    let length: f32 = normal.iter().map(|x| x * x).sum();
    let ordinary = |x: &f32| *x == 0.0 || (1e-9..1e9).contains(&x.abs());
    (length == 0.0 || (length - 1.0).abs() < 1e-2) && corners.len() == 9 && corners.iter().all(ordinary)
}

/// What kind of STL the bytes are.
///
/// # Errors
/// [`Error::Damaged`] for bytes that are neither.
pub(in crate::io) fn kind(bytes: &[u8]) -> Result<Kind> {
    if fits_binary(bytes) {
        return Ok(Kind::Binary);
    }
    if looks_like_text(bytes) {
        return Ok(Kind::Text);
    }
    let head = bytes.get(..bytes.len().min(1024)).unwrap_or_default();
    if holds_word(head, b"facet") && !head.contains(&0) {
        return Err(Error::Damaged {
            format: "STL",
            place: Place::Line(1),
            problem: "ASCII text with facets whose first line does not start with `solid`".into(),
            remedy: "repair the first line, or export again as binary STL or 3MF".into(),
        });
    }
    if bytes.len() < HEAD {
        return Err(Error::Damaged {
            format: "STL",
            place: Place::Byte(bytes.len() as u64),
            problem: format!("{} bytes are less than the 84 of the shortest binary STL", bytes.len()),
            remedy: "export the part again".into(),
        });
    }
    Ok(Kind::Binary)
}

/// The rest after a word, if the text starts with it, in any case and followed by white space or the end.
fn strip_word<'a>(text: &'a [u8], word: &[u8]) -> Option<&'a [u8]> {
    let (start, rest) = text.split_at_checked(word.len())?;
    let ends = rest.first().is_none_or(u8::is_ascii_whitespace);
    (start.eq_ignore_ascii_case(word) && ends).then_some(rest)
}

/// Whether a word stands in the text, in any case, between white space.
fn holds_word(text: &[u8], word: &[u8]) -> bool {
    text.split(u8::is_ascii_whitespace).any(|t| t.eq_ignore_ascii_case(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(header: &[u8], count: u32, extra: usize) -> Vec<u8> {
        let mut out = vec![0; 80];
        out[..header.len()].copy_from_slice(header);
        out.extend(count.to_le_bytes());
        out.resize(HEAD + FACET * count.min(100) as usize + extra, 0);
        out
    }

    #[test]
    fn the_length_decides_before_the_word() {
        assert_eq!(kind(&binary(b"solid facet endsolid ", 3, 0)), Ok(Kind::Binary));
        assert_eq!(kind(&binary(b"solid part ", 3, 1)), Ok(Kind::Binary));
        assert_eq!(kind(b"\xef\xbb\xbf \r\nSOLID\nendsolid"), Ok(Kind::Text));
        assert_eq!(kind(b"solid"), Ok(Kind::Text));
        let long_name = format!("solid {}\nfacet normal 0 0 1", "n".repeat(9000));
        assert_eq!(kind(long_name.as_bytes()), Ok(Kind::Text));
        assert!(kind(b"too short").is_err());
        assert!(kind(b"sol1d part\n facet normal 0 0 1\n").is_err_and(|e| e.place().as_deref() == Some("line 1")));
    }
}
