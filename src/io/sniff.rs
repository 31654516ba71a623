//! What bytes are, told from the bytes alone.

use super::stl;
use std::borrow::Cow;

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    Stl,
    Obj,
    Ply,
    /// A zip archive: 3MF, unless it lacks the parts.
    Zip,
    /// UTF-16 text, to be decoded and looked at again.
    Utf16,
    /// Something known that is no mesh for us: its name, and what to do.
    Other(&'static str, &'static str),
    /// Nothing known.
    Unknown,
}

const EXPORT: &str = "open it in the program that made it and export STL or 3MF";
const UNPACK: &str = "unpack it first";
const DOWNLOAD: &str = "download the model file itself, not the page that shows it";

/// Files known by their first bytes.
const MAGIC: &[(&[u8], &str, &str)] = &[
    (b"\x1f\x8b", "a gzip archive", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"Rar!", "a RAR archive", UNPACK),
    (b"BZh", "a bzip2 archive", UNPACK),
    (b"\xfd7zXZ", "an xz archive", UNPACK),
    (b"\x28\xb5\x2f\xfd", "a zstd archive", UNPACK),
    (b"\x89PNG", "a PNG picture", "choose the model, not its preview picture"),
    (b"\xff\xd8\xff", "a JPEG picture", "choose the model, not its preview picture"),
    (b"GIF8", "a GIF picture", "choose the model, not its preview picture"),
    (b"%PDF", "a PDF document", EXPORT),
    (b"ISO-10303-21", "a STEP file (curved surfaces, not triangles)", EXPORT),
    (b"glTF", "a binary glTF scene", "convert it to STL or 3MF; glTF is written but not read here"),
    (b"Kaydara FBX", "an FBX scene", EXPORT),
    (b"BLENDER", "a Blender file", EXPORT),
    (b"\xd0\xcf\x11\xe0", "a CAD or office document", EXPORT),
    (b"AC10", "a DWG drawing", EXPORT),
    (b"#VRML", "a VRML scene", EXPORT),
    (b"\x7fELF", "a program", "choose the model file"),
    (b"MZ\x90", "a program", "choose the model file"),
    (b"GCDE", "binary G-code", "check the model it was sliced from"),
    (b"version https://git-lfs", "a Git LFS pointer", "run `git lfs pull` to fetch the file it points to"),
];

/// What the bytes hold.
pub(super) fn content(bytes: &[u8]) -> Content {
    if stl::fits_binary(bytes) {
        return Content::Stl;
    }
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        return Content::Zip;
    }
    if let Some((_, what, remedy)) = MAGIC.iter().find(|(magic, ..)| bytes.starts_with(magic)) {
        return Content::Other(what, remedy);
    }
    if is_utf16(bytes) {
        return Content::Utf16;
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let starts = |word: &str| text.get(..word.len()).is_some_and(|t| t.eq_ignore_ascii_case(word.as_bytes()));
    if starts("ply") && text.get(3).is_none_or(u8::is_ascii_whitespace) {
        return Content::Ply;
    }
    if stl::looks_like_text(bytes) {
        return Content::Stl;
    }
    if starts("<") {
        return markup(text);
    }
    let head = text.get(..text.len().min(1 << 16)).unwrap_or_default();
    if is_text(head) { text_content(head) } else { binary_content(bytes) }
}

/// Text as UTF-8 without a mark before it, whichever way its writer marked or coded it.
pub fn plain_text(bytes: &[u8]) -> Cow<'_, [u8]> {
    if is_utf16(bytes) {
        return Cow::Owned(decode_utf16(bytes).into_bytes());
    }
    Cow::Borrowed(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

/// Whether the bytes begin with a UTF-16 mark, or their first four are two ASCII letters of 16 bits.
fn is_utf16(bytes: &[u8]) -> bool {
    match *bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => true,
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] => is_plain(a) && is_plain(b),
        _ => false,
    }
}

/// The text of UTF-16 bytes with either byte order.
pub(super) fn decode_utf16(bytes: &[u8]) -> String {
    let big = matches!(*bytes, [0xfe, 0xff, ..] | [0, ..]);
    let unit = |pair: &[u8]| match *pair {
        [a, b] if big => u16::from_be_bytes([a, b]),
        [a, b] => u16::from_le_bytes([a, b]),
        _ => 0xfffd,
    };
    let units = bytes.chunks(2).map(unit);
    let text: String = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    text.trim_start_matches('\u{feff}').to_string()
}

fn is_plain(b: u8) -> bool {
    b.is_ascii_graphic() || b.is_ascii_whitespace()
}

/// Whether nearly all bytes are those of a text: no NUL, few control characters.
fn is_text(head: &[u8]) -> bool {
    let odd = head.iter().filter(|&&b| b < 0x20 && !b.is_ascii_whitespace()).count();
    !head.contains(&0) && odd * 100 <= head.len()
}

/// XML and HTML by their first elements.
fn markup(text: &[u8]) -> Content {
    let head = text.get(..text.len().min(4096)).unwrap_or_default().to_ascii_lowercase();
    let holds = |word: &str| head.windows(word.len()).any(|w| w == word.as_bytes());
    if holds("<!doctype html") || holds("<html") || holds("<head") || holds("<body") {
        Content::Other("an HTML page", DOWNLOAD)
    } else if holds("<svg") {
        Content::Other("an SVG drawing", EXPORT)
    } else if holds("<amf") {
        Content::Other("an AMF file", "convert it to 3MF, its successor")
    } else if holds("<collada") {
        Content::Other("a COLLADA scene", EXPORT)
    } else if holds("<model") {
        Content::Other("the XML of a 3MF model without its package", "zip it as a 3MF package, or export 3MF again")
    } else {
        Content::Other("an XML document", EXPORT)
    }
}

/// OBJ, G-code and other text by the first words of its lines.
fn text_content(head: &[u8]) -> Content {
    let (mut obj, mut gcode, mut lines) = (0u32, 0u32, 0u32);
    for line in head.split(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::trim_ascii).filter(|l| !l.is_empty()).take(2000)
    {
        let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        lines += 1;
        match word {
            b"v" | b"vn" | b"vt" | b"f" | b"l" | b"p" | b"o" | b"g" | b"s" | b"usemtl" | b"mtllib" => obj += 1,
            [b'G' | b'M' | b'g' | b'm', digits @ ..] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) => {
                gcode += 1;
            }
            _ => {}
        }
    }
    let starts = |word: &str| head.get(..word.len()).is_some_and(|t| t.eq_ignore_ascii_case(word.as_bytes()));
    if 2 * gcode > lines || (gcode > 3 && gcode > obj) {
        Content::Other("G-code", "check the model it was sliced from")
    } else if obj > 0 {
        Content::Obj
    } else if starts("off") || starts("coff") {
        Content::Other("an OFF mesh", "convert it to STL, OBJ or PLY")
    } else if starts("{") || starts("[") {
        Content::Other("a JSON document", "choose the model file")
    } else if starts("0\n") || starts("0\r") || starts("  0") {
        Content::Other("a DXF drawing", EXPORT)
    } else if stl_words(head) {
        Content::Stl
    } else {
        Content::Other("plain text that is no mesh", "choose an STL, 3MF, OBJ or PLY file")
    }
}

/// Whether the text speaks of facets: an ASCII STL whose first line is damaged.
fn stl_words(head: &[u8]) -> bool {
    head.split(u8::is_ascii_whitespace).any(|w| w.eq_ignore_ascii_case(b"facet"))
}

/// Bytes that are no text: a damaged binary STL, or nothing known.
fn binary_content(bytes: &[u8]) -> Content {
    let named = bytes.get(..5).is_some_and(|h| h.eq_ignore_ascii_case(b"solid"));
    if named || stl::may_be_binary(bytes) { Content::Stl } else { Content::Unknown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_content() {
        for (bytes, expected) in [
            (&b"PK\x03\x04...."[..], "Zip"),
            (b"ply\r\nformat ascii 1.0\r\n", "Ply"),
            (b"\xef\xbb\xbfsolid a\nfacet", "Stl"),
            (b"# cube\nv 0 0 0\nf 1 2 3\n", "Obj"),
            (b"f 1 2 3\n", "Obj"),
            (b"\xfe\xff\0v\0 ", "Utf16"),
            (b"v\0 \x001\0", "Utf16"),
            (b"ISO-10303-21;\nHEADER;", "STEP"),
            (b"; generated by a slicer\nG28\nG1 X1\nG1 X2\nM104 S200\n", "G-code"),
            (b"\x89PNG\r\n\x1a\n", "PNG"),
            (b"<!DOCTYPE html><html>", "HTML"),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "LFS"),
            (b"\x1f\x8b\x08", "gzip"),
            (b"<?xml version=\"1.0\"?><model unit=\"mm\">", "3MF model"),
            (b"hello world\n", "plain text"),
            (b"\x00\x01\x02\x03", "Unknown"),
        ] {
            let found = format!("{:?}", content(bytes));
            assert!(found.contains(expected), "{expected}: {found}");
        }
    }

    #[test]
    fn utf16_of_either_order_is_decoded() {
        assert_eq!(decode_utf16(b"\xfe\xff\0v\0 "), "v ");
        assert_eq!(decode_utf16(b"v\0 \0"), "v ");
        assert_eq!(decode_utf16(b"\xff\xfev\0x"), "v\u{fffd}");
    }
}
