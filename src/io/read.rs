//! Any mesh from bytes.

use super::sniff::{self, Content};
use super::{Loaded, Salvage, obj, ply, stl, threemf};
use crate::error::{Error, Place, Result, printable};
use crate::notice::Notice;

/// Suffixes that promise a format; any other suffix promises nothing.
const SUFFIXES: [&str; 12] = ["stl", "obj", "ply", "3mf", "amf", "step", "stp", "iges", "gcode", "off", "glb", "zip"];

/// The mesh that the bytes hold, whatever their name says.
///
/// The format is told from the content; a suffix that promises another one is a notice. The name serves
/// only for that and for messages. Coordinates stay in file units: [`Loaded::unit_mm`] says how long one is.
///
/// # Errors
/// [`Error::NoGeometry`] for zero bytes and for files without facets; [`Error::Damaged`] with the place of
/// the fault; [`Error::Unsupported`] naming what the file is if it is no STL, 3MF, OBJ or PLY;
/// [`Error::TooLarge`] beyond what can be indexed.
///
/// ```
/// use amcheck::io::{Salvage, read};
/// let page = read("part.stl", b"<!DOCTYPE html><html>please log in</html>", Salvage::Refuse);
/// assert!(page.unwrap_err().to_string().contains("HTML"));
/// ```
pub fn read(name: &str, bytes: &[u8], salvage: Salvage) -> Result<Loaded> {
    if bytes.is_empty() {
        return Err(Error::NoGeometry {
            problem: "the file is empty (0 bytes)".into(),
            remedy: "copy or export the file again".into(),
        });
    }
    let suffix = suffix(name);
    let mut content = sniff::content(bytes);
    let decoded;
    let mut bytes = bytes;
    if content == Content::Utf16 {
        decoded = sniff::decode_utf16(bytes).into_bytes();
        bytes = &decoded;
        content = sniff::content(bytes);
    }
    let (mut loaded, own) = match content {
        Content::Stl => (stl::read(bytes, salvage)?, "stl"),
        Content::Unknown if suffix == "stl" => (stl::read(bytes, salvage)?, "stl"),
        Content::Other(what, remedy) => return Err(unsupported(what, remedy)),
        Content::Obj => (obj::read(bytes)?, "obj"),
        Content::Ply => (ply::read(bytes)?, "ply"),
        Content::Zip => (threemf::read(bytes)?, "3mf"),
        Content::Unknown | Content::Utf16 => {
            return Err(unsupported("a file that is neither STL, 3MF, OBJ nor PLY", "export the part in one of these"));
        }
    };
    if suffix != own && SUFFIXES.contains(&suffix.as_str()) {
        let message = format!("the name ends in .{suffix}, the content is {}: read as that", loaded.format);
        loaded.notices.insert(0, Notice::new("wrong-suffix", message));
    }
    Ok(loaded)
}

/// Bytes that reading takes at its peak, the file itself included, told from its format; measured on a million triangles with room to spare.
///
/// Text is short for what it becomes: a corner of a cube is six characters and twenty-four bytes.
pub fn reading_bytes(bytes: &[u8]) -> u128 {
    let times = match sniff::content(bytes) {
        Content::Obj | Content::Ply | Content::Zip => 12,
        Content::Utf16 => 16,
        Content::Stl | Content::Other(..) | Content::Unknown => 4,
    };
    times * bytes.len() as u128
}

/// What stands after the last point of a name, in lower case, printable; empty without one.
fn suffix(name: &str) -> String {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    file.rsplit_once('.').map_or_else(String::new, |(_, s)| printable(&s.to_lowercase()))
}

fn unsupported(what: &str, remedy: &str) -> Error {
    Error::Unsupported { what: format!("the file is {what}, which"), place: Place::Whole, remedy: remedy.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STL: &[u8] =
        b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid";

    #[test]
    fn the_content_decides_and_a_wrong_suffix_is_noticed() {
        for (name, notices) in [("a.stl", 0), ("A.STL", 0), ("-", 0), ("part.v2", 0), ("a.3mf", 1), ("dir.3mf/a", 0)] {
            let l = read(name, STL, Salvage::Refuse).unwrap();
            assert_eq!((l.mesh.triangles.len(), l.notices.len()), (1, notices), "{name}");
        }
    }

    #[test]
    fn what_is_no_mesh_is_named() {
        for (bytes, word) in [
            (&b""[..], "empty"),
            (b"ISO-10303-21;", "STEP"),
            (b"\x1f\x8b\x08\0", "gzip"),
            (b"version https://git-lfs.github.com/spec/v1\n", "LFS"),
            (b"\0\x01\x02", "shorter than|less than"),
        ] {
            let e = read("a.stl", bytes, Salvage::Refuse).unwrap_err();
            assert!(word.split('|').any(|w| e.to_string().contains(w)), "{e}");
            assert_eq!(e.exit_code(), 4);
        }
    }
}
