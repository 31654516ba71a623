//! Binary STL: an 80-byte header, a count, 50 bytes a facet.
//!
//! `stl_io` believes the count (too small: facets vanish without a word), takes a header that starts with
//! `solid` for text, and passes NaN on. So the count is settled here against the length, the header is
//! blanked, and every corner is checked.

use super::decide::{FACET, HEAD, claimed_count};
use crate::error::{Error, Place, Result};
use crate::geometry::TriangleMesh;
use crate::io::{Salvage, accept};
use crate::notice::{Notice, number_of};
use std::io::{Read, Seek, SeekFrom};

/// The mesh and what was noticed.
pub(super) fn read(bytes: &[u8], salvage: Salvage) -> Result<(TriangleMesh, Vec<Notice>)> {
    let mut notices = Vec::new();
    let count = settled_count(bytes, salvage, &mut notices)?;
    accept::facets_fit(u64::from(count))?;
    if count == 0 {
        return Err(accept::no_triangles("STL"));
    }
    let mesh = facets(bytes, count, salvage, &mut notices)?;
    Ok((mesh, notices))
}

/// How many facets to read: the count of the header, held against the length of the file.
fn settled_count(bytes: &[u8], salvage: Salvage, notices: &mut Vec<Notice>) -> Result<u32> {
    let claimed = claimed_count(bytes).unwrap_or(0);
    let body = bytes.get(HEAD..).unwrap_or_default();
    let whole = u32::try_from(body.len() / FACET).unwrap_or(u32::MAX);
    if claimed > whole {
        if salvage == Salvage::Refuse {
            return Err(count_too_large(claimed, whole, bytes));
        }
        let lost = claimed - whole;
        notices.push(
            Notice::new(
                "salvaged",
                format!("the header counts {claimed} triangles, the file holds {whole} whole ones, which were kept"),
            )
            .counted(u64::from(lost)),
        );
        return Ok(whole);
    }
    let extra = body.len() as u64 - FACET as u64 * u64::from(claimed);
    if extra == 0 {
        return Ok(claimed);
    }
    let trailing = body.get(FACET * claimed as usize..).unwrap_or_default();
    if extra.is_multiple_of(FACET as u64) && trailing.chunks_exact(FACET).all(is_plausible_facet) {
        notices.push(
            Notice::new(
                "count-mismatch",
                format!("the header counts {claimed} triangles, the file holds {whole}; all {whole} were read"),
            )
            .counted(u64::from(whole - claimed)),
        );
        return Ok(whole);
    }
    notices.push(
        Notice::new(
            "trailing-bytes",
            format!(
                "after the last of {claimed} triangles {}",
                number_of(extra, ["byte was ignored", "bytes were ignored"])
            ),
        )
        .counted(extra),
    );
    Ok(claimed)
}

/// Whether 50 bytes can be a facet: coordinates in range, and not a run of zeros as padding writes it.
fn is_plausible_facet(bytes: &[u8]) -> bool {
    let corners = bytes.get(12..48).unwrap_or_default();
    corners.iter().any(|&b| b != 0)
        && corners.chunks_exact(4).all(|b| {
            let value = b.try_into().map_or(f32::NAN, f32::from_le_bytes);
            f64::from(value.abs()) <= accept::LARGEST_COORDINATE
        })
}

/// The error of a header that counts more facets than there are bytes for.
fn count_too_large(claimed: u32, whole: u32, bytes: &[u8]) -> Error {
    let need = HEAD as u64 + FACET as u64 * u64::from(claimed);
    let len = bytes.len() as u64;
    let swapped = claimed.swap_bytes();
    let (place, problem, remedy) = if HEAD as u64 + FACET as u64 * u64::from(swapped) == len {
        (
            Place::Byte(80),
            format!("the count is {claimed} as little-endian and {swapped}, which fits the file, as big-endian"),
            "write the file in little-endian byte order, as STL demands",
        )
    } else if (len - HEAD as u64).is_multiple_of(FACET as u64) || u64::from(claimed) > 10 * (u64::from(whole) + 1) {
        (
            Place::Byte(80),
            format!(
                "the header counts {claimed} triangles ({need} bytes) but the file holds {len} bytes ({whole} triangles)"
            ),
            "export or copy the file again; --salvage keeps the whole triangles",
        )
    } else {
        (
            Place::Byte(len),
            format!("the file ends inside triangle {} of {claimed}: {len} of {need} bytes", u64::from(whole) + 1),
            "export or copy the file again; --salvage keeps the whole triangles",
        )
    };
    Error::Damaged { format: "STL", place, problem, remedy: remedy.into() }
}

/// The facets, parsed by `stl_io`, checked and welded one by one.
fn facets(bytes: &[u8], count: u32, salvage: Salvage, notices: &mut Vec<Notice>) -> Result<TriangleMesh> {
    let mut source = Reheaded::new(bytes.get(HEAD..).unwrap_or_default(), count);
    let mut parsed = stl_io::create_stl_reader(&mut source).map_err(|e| unreadable(0, &e))?;
    let (mut number, mut dropped, mut failure) = (0u64, 0u64, None);
    let mesh = TriangleMesh::weld(std::iter::from_fn(|| {
        loop {
            number += 1;
            // The iterator of `stl_io` may yield errors for ever: the first one ends the reading.
            let corners = match parsed.next()? {
                Ok(facet) => facet.vertices.map(|v| v.0.map(f64::from)),
                Err(e) => {
                    failure = Some(unreadable(number, &e));
                    return None;
                }
            };
            match corners.into_iter().find_map(accept::point_problem) {
                None => return Some(corners),
                Some(_) if salvage == Salvage::KeepWhole => dropped += 1,
                Some(problem) => {
                    failure = Some(bad_facet(number, problem));
                    return None;
                }
            }
        }
    }));
    if dropped > 0 {
        let words = [
            "triangle with a coordinate out of range was dropped",
            "triangles with coordinates out of range were dropped",
        ];
        notices.push(Notice::new("salvaged", number_of(dropped, words)).counted(dropped));
    }
    failure.map_or(Ok(mesh), Err)
}

fn bad_facet(number: u64, problem: String) -> Error {
    Error::Damaged {
        format: "STL",
        place: Place::Facet(number),
        problem,
        remedy: "export the part again; --salvage drops such triangles".into(),
    }
}

fn unreadable(number: u64, reason: &std::io::Error) -> Error {
    Error::Damaged {
        format: "STL",
        place: Place::Facet(number),
        problem: format!("the facet cannot be read: {reason}"),
        remedy: "export or copy the file again".into(),
    }
}

/// A file with a new header: line ends, so that the search of `stl_io` for a first line ends at its first
/// byte, then the settled count, then the facets as they came.
struct Reheaded<'a> {
    head: [u8; HEAD],
    body: &'a [u8],
    at: u64,
}

impl<'a> Reheaded<'a> {
    fn new(body: &'a [u8], count: u32) -> Self {
        let mut head = [b'\n'; HEAD];
        head[80..].copy_from_slice(&count.to_le_bytes());
        Reheaded { head, body, at: 0 }
    }
}

impl Read for Reheaded<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let at = usize::try_from(self.at).unwrap_or(usize::MAX);
        let part = match self.head.get(at..) {
            Some(rest) if !rest.is_empty() => rest,
            _ => self.body.get(at.saturating_sub(HEAD)..).unwrap_or_default(),
        };
        let n = part.len().min(out.len());
        if let (Some(to), Some(from)) = (out.get_mut(..n), part.get(..n)) {
            to.copy_from_slice(from);
        }
        self.at += n as u64;
        Ok(n)
    }
}

impl Seek for Reheaded<'_> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::Current(by) => self.at.saturating_add_signed(by),
            SeekFrom::End(by) => (HEAD as u64 + self.body.len() as u64).saturating_add_signed(by),
        };
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &[u8], count: u32, facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut out = vec![b' '; 80];
        out[..header.len()].copy_from_slice(header);
        out.extend(count.to_le_bytes());
        for f in facets {
            out.extend([0xff; 12]);
            out.extend(f.iter().flatten().flat_map(|x| x.to_le_bytes()));
            out.extend([0x12, 0x34]);
        }
        out
    }

    const A: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]];
    const B: [[f32; 3]; 3] = [[0.0, 0.0, -0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 0.1]];

    fn refuse(bytes: &[u8]) -> Error {
        crate::io::stl::read(bytes, Salvage::Refuse).unwrap_err()
    }

    #[test]
    fn headers_and_normals_do_not_matter() {
        for header in [&b"solid part facet"[..], b"\0\xff\xff", b"solid \xff\0"] {
            let l = crate::io::stl::read(&file(header, 2, &[A, B]), Salvage::Refuse).unwrap();
            assert_eq!((l.mesh.triangles.len(), l.mesh.vertices.len(), l.notices.len()), (2, 4, 0));
            assert_eq!(l.mesh.vertices[3][2], f64::from(0.1f32));
        }
    }

    #[test]
    fn counts_are_held_against_the_length() {
        let good = file(b"", 2, &[A, B]);
        let big = file(b"", u32::MAX, &[A, B]);
        assert_eq!(refuse(&big).place().as_deref(), Some("byte 80"));
        assert!(refuse(&file(b"", 3, &[A, B])).to_string().contains("counts 3"));
        assert!(refuse(&file(b"", 2u32.swap_bytes(), &[A, B])).to_string().contains("big-endian"));
        assert_eq!(refuse(&good[..good.len() - 7]).place().as_deref(), Some("byte 177"));
        assert!(matches!(refuse(&file(b"", 0, &[])), Error::NoGeometry { .. }));
        for (bytes, code, triangles) in [
            (file(b"", 1, &[A, B]), "count-mismatch", 2),
            (file(b"", 0, &[A, B]), "count-mismatch", 2),
            ([good.clone(), vec![0]].concat(), "trailing-bytes", 2),
            ([good.clone(), vec![0; 50]].concat(), "trailing-bytes", 2),
        ] {
            let l = crate::io::stl::read(&bytes, Salvage::Refuse).unwrap();
            assert_eq!((l.notices[0].code.as_str(), l.mesh.triangles.len()), (code, triangles));
        }
        let kept = crate::io::stl::read(&good[..good.len() - 7], Salvage::KeepWhole).unwrap();
        assert_eq!((kept.mesh.triangles.len(), kept.notices[0].code.as_str()), (1, "salvaged"));
    }

    #[test]
    fn bad_coordinates_name_their_facet() {
        for (bad, word) in [(f32::NAN, "NaN"), (f32::INFINITY, "range"), (f32::MAX, "range"), (-3.4e38, "range")] {
            let bytes = file(b"", 2, &[A, [[0.0; 3], [bad, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
            let e = refuse(&bytes);
            assert_eq!(e.place().as_deref(), Some("facet 2"));
            assert!(e.to_string().contains(word), "{e}");
            assert_eq!(crate::io::stl::read(&bytes, Salvage::KeepWhole).unwrap().mesh.triangles.len(), 1);
        }
        let tiny = [[0.0; 3], [1e-30, 0.0, 0.0], [0.0, 1e-40, 0.0]];
        assert!(refuse(&file(b"", 1, &[tiny])).to_string().contains("no extent"));
    }

    #[test]
    #[ignore = "a measurement, not a test"]
    fn triangles_a_second_before_welding() {
        let n = 4_000_000u32;
        let bytes = file(b"", n, &vec![A; n as usize]);
        let start = std::time::Instant::now();
        let mut source = Reheaded::new(&bytes[HEAD..], n);
        let sum: f64 = stl_io::create_stl_reader(&mut source)
            .unwrap()
            .map(|f| f.unwrap().vertices.map(|v| v.0.map(f64::from)))
            .filter(|c| c.iter().all(|&p| accept::point_problem(p).is_none()))
            .map(|c| c[1][0])
            .sum();
        println!("{:.1} M/s ({sum})", f64::from(n) / start.elapsed().as_secs_f64() / 1e6);
        let start = std::time::Instant::now();
        let l = crate::io::stl::read(&bytes, Salvage::Refuse).unwrap();
        println!("welded: {:.1} M/s ({})", f64::from(n) / start.elapsed().as_secs_f64() / 1e6, l.mesh.vertices.len());
    }
}
