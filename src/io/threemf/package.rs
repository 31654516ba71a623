//! The zip archive of a 3MF file, with its traps closed.

use crate::error::{Error, Place, Result, printable};
use std::collections::{HashMap, HashSet};
use std::io::{Cursor, Read};
use zip::ZipArchive;
use zip::result::ZipError;

/// Most parts of a package.
const MOST_PARTS: usize = 10_000;
/// Most bytes of all parts that are inflated.
const MOST_BYTES: u64 = 2 << 30;
/// What inflates to less than this may do so by any ratio.
const SMALL: u64 = 10 << 20;
/// Largest ratio of inflating more; the XML of real meshes stays below 20.
const MOST_RATIO: u64 = 200;

/// The parts of a package.
pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    parts: Vec<Part>,
    /// The parts by their names in lower case, without the first stroke.
    by_name: HashMap<String, usize>,
    /// Bytes of the parts read so far, inflated and packed.
    inflated: u64,
    packed: u64,
}

struct Part {
    name: String,
    size: u64,
    packed: u64,
    encrypted: bool,
    data: std::ops::Range<u64>,
}

impl<'a> Package<'a> {
    /// Opens the archive and looks at its directory; nothing is inflated.
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self> {
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| refused("the archive", &e))?;
        if archive.len() > MOST_PARTS {
            return Err(too_large("a package of so many parts", archive.len() as u64, MOST_PARTS as u64));
        }
        let parts = (0..archive.len()).map(|i| part(&mut archive, i)).collect::<Result<Vec<Part>>>()?;
        check_names(&parts, directory_records(bytes, archive.central_directory_start()))?;
        let by_name = parts.iter().enumerate().rev().map(|(i, p)| (key(&p.name), i)).collect();
        let package = Package { archive, parts, by_name, inflated: 0, packed: 0 };
        package.check_overlaps()?;
        Ok(package)
    }

    /// No two parts share bytes: the trick by which small archives inflate without end.
    fn check_overlaps(&self) -> Result<()> {
        let mut ranges: Vec<_> = self.parts.iter().filter(|p| p.packed > 0).map(|p| p.data.clone()).collect();
        ranges.sort_by_key(|r| r.start);
        match ranges.windows(2).find(|w| matches!(w, [a, b] if b.start < a.end)) {
            None => Ok(()),
            Some(_) => Err(too_large("a package whose parts overlap", MOST_BYTES + 1, MOST_BYTES)),
        }
    }

    /// The names of all parts.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().map(|p| p.name.as_str())
    }

    /// The part of a name, `/3D/3dmodel.model` or without the first stroke; upper and lower case are one.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.by_name.get(&key(name)).copied()
    }

    /// How many bytes a part says that it inflates to.
    pub(super) fn size(&self, index: usize) -> u64 {
        self.parts.get(index).map_or(0, |p| p.size)
    }

    /// The bytes of a part, inflated within the caps that hold for all parts together, its checksum verified.
    pub(super) fn read(&mut self, index: usize) -> Result<Vec<u8>> {
        let Some(part) = self.parts.get(index) else { return Ok(Vec::new()) };
        if part.encrypted {
            return Err(Error::Unsupported {
                what: "an encrypted part".into(),
                place: Place::Member { name: part.name.clone(), line: None },
                remedy: "export the package without encryption".into(),
            });
        }
        let inflated = self.inflated.saturating_add(part.size);
        let packed = self.packed.saturating_add(part.packed);
        // Each by itself as well, so that none hides behind another that hardly shrinks.
        let bomb = is_bomb(part.size, part.packed) || is_bomb(inflated, packed);
        if inflated > MOST_BYTES || bomb {
            let allowed = if bomb { SMALL } else { MOST_BYTES };
            return Err(too_large(&format!("inflating {}", printable(&part.name)), inflated, allowed));
        }
        (self.inflated, self.packed) = (inflated, packed);
        let name = part.name.clone();
        let declared = part.size;
        let mut bytes = Vec::new();
        let room = usize::try_from(declared).unwrap_or(usize::MAX);
        bytes.try_reserve_exact(room).map_err(|_| too_large("a part of the package", declared, MOST_BYTES))?;
        let file = self.archive.by_index(index).map_err(|e| refused(&name, &e))?;
        // Reading to the end verifies the checksum; one byte more shows a part that is larger than it says.
        file.take(declared + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| damaged(&name, format!("the part cannot be inflated: {}", printable(&e.to_string()))))?;
        if bytes.len() as u64 != declared {
            return Err(damaged(
                &name,
                format!("the part inflates to another size than the {declared} bytes it states"),
            ));
        }
        Ok(bytes)
    }
}

/// No name leaves the package, and none occurs twice: readers would disagree about which is meant.
fn check_names(parts: &[Part], records: usize) -> Result<()> {
    let mut known = HashSet::new();
    for part in parts {
        if part.name.split(['/', '\\']).any(|step| step == "..") {
            return Err(damaged(&part.name, "a part whose name leads out of the package".into()));
        }
        if !known.insert(part.name.to_lowercase()) {
            return Err(damaged(&part.name, "two parts of one name, but for upper and lower case".into()));
        }
    }
    // The directory of the `zip` crate keeps the last of equal names.
    if records > parts.len() {
        let problem = format!("{} parts under {} names: some occur twice", records, parts.len());
        return Err(damaged("the archive", problem));
    }
    Ok(())
}

/// Whether so few bytes inflate to so many that somebody means harm.
fn is_bomb(inflated: u64, packed: u64) -> bool {
    inflated > SMALL && inflated / MOST_RATIO > packed
}

/// A name as it is looked up.
fn key(name: &str) -> String {
    name.trim_start_matches('/').to_lowercase()
}

/// One line of the directory.
fn part(archive: &mut ZipArchive<Cursor<&[u8]>>, index: usize) -> Result<Part> {
    let file = archive.by_index_raw(index).map_err(|e| refused("the archive", &e))?;
    let start = file.data_start();
    Ok(Part {
        name: file.name().to_string(),
        size: file.size(),
        packed: file.compressed_size(),
        encrypted: file.encrypted(),
        data: start..start.saturating_add(file.compressed_size()),
    })
}

/// How many records the central directory really holds.
fn directory_records(bytes: &[u8], start: u64) -> usize {
    let mut at = usize::try_from(start).unwrap_or(usize::MAX);
    let mut records = 0;
    while let Some(record) = bytes.get(at..).filter(|r| r.starts_with(b"PK\x01\x02")) {
        let length = |i: usize| record.get(i..i + 2).map_or(0, |b| b.iter().rev().fold(0, |n, &b| n << 8 | b as usize));
        records += 1;
        at = at.saturating_add(46 + length(28) + length(30) + length(32));
    }
    records
}

const EXPORT: &str = "export or copy the package again";

fn damaged(part: &str, problem: String) -> Error {
    let place = Place::Member { name: part.to_string(), line: None };
    Error::Damaged { format: "3MF", place, problem, remedy: EXPORT.into() }
}

fn refused(part: &str, reason: &ZipError) -> Error {
    match reason {
        ZipError::UnsupportedArchive(what) => Error::Unsupported {
            what: format!("this zip archive ({what})"),
            place: Place::Member { name: part.to_string(), line: None },
            remedy: "export the package without encryption, deflated".into(),
        },
        other => damaged(part, printable(&other.to_string())),
    }
}

fn too_large(what: &str, need: u64, allowed: u64) -> Error {
    Error::TooLarge {
        what: what.into(),
        need_bytes: u128::from(need),
        allowed_bytes: u128::from(allowed),
        remedy: "export the part again; a package like this is made to exhaust its reader".into(),
    }
}
