//! The header of a PLY file: a list of elements with their properties.

use crate::error::{Error, Place, Result, printable};

/// Longest header that is read, in bytes.
const LONGEST: usize = 1 << 16;
/// Most properties of all elements together.
const MOST_PROPERTIES: usize = 1024;

/// How values are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// The type of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Bytes of one number in binary files.
    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }
}

/// What a property holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    One(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The least bytes that one of it can take: lists may be empty; in text a value is a digit and a space.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let least = |kind: Kind| match (encoding, kind) {
            (Encoding::Text, _) => 2,
            (_, Kind::One(scalar) | Kind::List { count: scalar, .. }) => scalar.size() as u64,
        };
        self.properties.iter().map(|p| least(p.kind)).sum()
    }
}

/// The header, and where the values start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) body_at: usize,
    /// Line of the first value, counted from 1.
    pub(super) body_line: u64,
}

/// Reads the header, with line ends of any kind.
pub(super) fn read(bytes: &[u8]) -> Result<Header> {
    let mut lines = Lines { bytes: bytes.get(..bytes.len().min(LONGEST)).unwrap_or_default(), at: 0, line: 0 };
    lines.next_line()?;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut properties = 0;
    loop {
        let text = lines.next_line()?;
        let line = lines.line;
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        match words.as_slice() {
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _version] => encoding = Some(encoding_named(name, line)?),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| bad(line, format!("`{}` is not a count", printable(count))))?;
                elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
            }
            ["property", rest @ ..] => {
                properties += 1;
                let property = property(rest)
                    .ok_or_else(|| bad(line, format!("`{}` is not a property", printable(text.trim()))))?;
                let element = elements.last_mut().ok_or_else(|| bad(line, "a property before any element".into()))?;
                if properties > MOST_PROPERTIES {
                    return Err(bad(line, format!("more than {MOST_PROPERTIES} properties")));
                }
                element.properties.push(property);
            }
            ["end_header"] => break,
            _ => return Err(bad(line, format!("`{}` does not belong in a header", printable(text.trim())))),
        }
    }
    let encoding = encoding.ok_or_else(|| bad(lines.line, "the header states no format".into()))?;
    Ok(Header { encoding, elements, body_at: lines.at, body_line: lines.line + 1 })
}

fn encoding_named(name: &str, line: u64) -> Result<Encoding> {
    match name {
        "ascii" => Ok(Encoding::Text),
        "binary_little_endian" => Ok(Encoding::Little),
        "binary_big_endian" => Ok(Encoding::Big),
        _ => Err(bad(line, format!("unknown format `{}`", printable(name)))),
    }
}

fn property(words: &[&str]) -> Option<Property> {
    match words {
        ["list", count, item, name] => {
            let kind = Kind::List { count: Scalar::named(count)?, item: Scalar::named(item)? };
            Some(Property { name: (*name).into(), kind })
        }
        [kind, name] => Some(Property { name: (*name).into(), kind: Kind::One(Scalar::named(kind)?) }),
        _ => None,
    }
}

/// Lines of the header; a line end is LF, CR or CRLF.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

impl<'a> Lines<'a> {
    fn next_line(&mut self) -> Result<&'a str> {
        self.line += 1;
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some(end) = rest.iter().position(|b| matches!(b, b'\n' | b'\r')) else {
            return Err(bad(self.line, "the header does not end with `end_header`".into()));
        };
        let (line, rest) = rest.split_at(end);
        self.at += end + if rest.starts_with(b"\r\n") { 2 } else { 1 };
        if line.contains(&0) {
            return Err(bad(self.line, "a NUL byte in the header".into()));
        }
        std::str::from_utf8(line).or_else(|_| {
            // Names of authors in comments come in any encoding; keywords are ASCII.
            if line.starts_with(b"comment") || line.starts_with(b"obj_info") {
                Ok("comment")
            } else {
                Err(bad(self.line, "the header is not text".into()))
            }
        })
    }
}

fn bad(line: u64, problem: String) -> Error {
    Error::Damaged { format: "PLY", place: Place::Line(line), problem, remedy: "export the file again".into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_every_line_end_are_read() {
        let text = "ply\nformat binary_big_endian 1.0\ncomment a b\nelement vertex 3\nproperty double x\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";
        for end in ["\n", "\r", "\r\n"] {
            let text = text.replace('\n', end);
            let header = read(text.as_bytes()).unwrap();
            assert_eq!((header.encoding, header.body_at, header.body_line), (Encoding::Big, text.len(), 9), "{end:?}");
            assert_eq!(header.elements[1].least_bytes(Encoding::Big), 1);
        }
    }

    #[test]
    fn bad_headers_name_their_line() {
        for (lines, line) in [
            ("format ascii 1.0\nelement vertex -1\n", 3),
            ("format ascii 1.0\nproperty float x\n", 3),
            ("format middle 1.0\n", 2),
            ("format ascii 1.0\nelement vertex 1\nproperty \0 x\n", 4),
            ("format ascii 1.0\nelement vertex 99999999999999999999\n", 3),
            ("end_header\n", 2),
            ("format ascii 1.0\n", 3),
        ] {
            let e = read(format!("ply\n{lines}").as_bytes()).unwrap_err();
            assert_eq!(e.place(), Some(format!("line {line}")), "{lines:?}: {e}");
        }
    }
}
