//! ASCII STL.
//!
//! `stl_io` reads one solid with LF or CRLF line ends, a name, an `endsolid` and nothing unusual; the second
//! solid of a file is dropped without a word. So the words are checked and counted here, line by line, and
//! handed to `stl_io` in blocks of one form that it reads.

use crate::error::{Error, Place, Result};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::Vec3;
use crate::io::words::{Word, Words};
use crate::io::{Salvage, accept};
use crate::notice::Notice;
use rayon::prelude::*;

/// Longest line that is read; a text of one endless line is no STL that anybody wrote.
const LONGEST_LINE: usize = 16 << 20;
/// Facets in one block for `stl_io`; blocks are parsed in parallel.
const BLOCK: usize = 4096;

/// The mesh and what was noticed.
pub(super) fn read(bytes: &[u8], salvage: Salvage) -> Result<(TriangleMesh, Vec<Notice>)> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    refuse_endless_line(bytes)?;
    let mut reading = Reading { words: Words::new(bytes), blocks: vec![Block::default()], ..Reading::default() };
    reading.solids(salvage)?;
    let soup: Vec<Vec<[Vec3; 3]>> = reading.blocks.par_iter().map(Block::parse).collect::<Result<_>>()?;
    Ok((TriangleMesh::weld(soup.into_iter().flatten()), reading.notices()))
}

fn refuse_endless_line(bytes: &[u8]) -> Result<()> {
    let longest = bytes.split(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::len).max().unwrap_or(0);
    if longest <= LONGEST_LINE {
        return Ok(());
    }
    Err(Error::TooLarge {
        what: "a line of the ASCII STL".into(),
        need_bytes: longest as u128,
        allowed_bytes: LONGEST_LINE as u128,
        remedy: "export the part as binary STL or 3MF".into(),
    })
}

/// Facets in the one form that `stl_io` reads.
#[derive(Default)]
struct Block {
    text: Vec<u8>,
    facets: usize,
    first_line: u64,
}

impl Block {
    fn parse(&self) -> Result<Vec<[Vec3; 3]>> {
        let text = [b"solid \n", self.text.as_slice(), b"endsolid\n"].concat();
        let mut source = std::io::Cursor::new(text);
        let failed = |e: std::io::Error| damaged(self.first_line, format!("facets from here: {e}"), "export again");
        let parsed = stl_io::create_stl_reader(&mut source).map_err(failed)?;
        let facets: Vec<[Vec3; 3]> = parsed
            .map(|f| f.map(|f| f.vertices.map(|v| v.0.map(f64::from))))
            .collect::<std::io::Result<_>>()
            .map_err(failed)?;
        if facets.len() == self.facets {
            Ok(facets)
        } else {
            Err(Error::Internal { problem: format!("{} of {} facets of a block were read", facets.len(), self.facets) })
        }
    }
}

/// The state of reading: where, and what was met.
struct Reading<'a> {
    words: Words<'a>,
    blocks: Vec<Block>,
    unclosed: u64,
    without_normal: u64,
    stray_words: u64,
    dropped: u64,
}

impl Default for Reading<'_> {
    fn default() -> Self {
        Reading {
            words: Words::new(b""),
            blocks: Vec::new(),
            unclosed: 0,
            without_normal: 0,
            stray_words: 0,
            dropped: 0,
        }
    }
}

impl<'a> Reading<'a> {
    /// All solids of the file.
    fn solids(&mut self, salvage: Salvage) -> Result<()> {
        let mut open = false;
        while let Some(word) = self.words.next() {
            if word.is("facet") {
                match (self.facet(word.line), salvage) {
                    (Ok(()), _) => {}
                    (Err(e), Salvage::Refuse) => return Err(e),
                    (Err(_), Salvage::KeepWhole) => self.drop_facet(),
                }
            } else if word.is("endsolid") {
                self.words.skip_line();
                open = false;
            } else if word.is("solid") {
                self.unclosed += u64::from(open);
                self.skip_name(word.line);
                open = true;
            } else if open && salvage == Salvage::Refuse {
                let problem = format!("`{}` where `facet` or `endsolid` should stand", word.shown());
                return Err(damaged(word.line, problem, "export the part again; --salvage keeps the whole facets"));
            } else {
                self.stray_words += 1;
            }
        }
        self.unclosed += u64::from(open);
        Ok(())
    }

    /// Goes over the name of a solid: to the end of its line, or to a facet that follows on the same line.
    fn skip_name(&mut self, line: u64) {
        while let Some(word) = self.words.peek().filter(|w| w.line == line) {
            let mut ahead = self.words;
            ahead.next();
            if word.is("facet") && ahead.peek().is_some_and(|w| w.is("normal")) {
                return;
            }
            self.words = ahead;
        }
    }

    /// One facet after its first word, appended to the last block.
    fn facet(&mut self, line: u64) -> Result<()> {
        self.normal()?;
        self.require("outer")?;
        self.require("loop")?;
        let mut corners = [[Word { text: b"", line: 0 }; 3]; 3];
        for (n, corner) in corners.iter_mut().enumerate() {
            let word = self.word()?;
            if !word.is("vertex") {
                let problem = format!("`{}` after {n} of the three corners of a facet", word.shown());
                return Err(damaged(word.line, problem, "export the part again; --salvage drops such facets"));
            }
            *corner = self.point()?;
        }
        if let Some(word) = self.words.peek().filter(|w| w.is("vertex")) {
            return Err(damaged(
                word.line,
                "a facet with more than three corners".into(),
                "export the part as triangles; --salvage drops such facets",
            ));
        }
        self.require("endloop")?;
        self.skip_to(&["endfacet"]);
        self.require("endfacet")?;
        self.skip_to(&["facet", "endsolid", "solid"]);
        self.append(line, &corners);
        Ok(())
    }

    /// `normal` and its three words, which are not looked at; missing in some files.
    fn normal(&mut self) -> Result<()> {
        if !self.words.peek().is_some_and(|w| w.is("normal")) {
            self.without_normal += 1;
            return Ok(());
        }
        self.words.next();
        for _ in 0..3 {
            if self.words.peek().is_some_and(|w| w.is("outer")) {
                break;
            }
            self.word()?;
        }
        Ok(())
    }

    /// The three numbers of a corner, checked.
    fn point(&mut self) -> Result<[Word<'a>; 3]> {
        let mut words = [Word { text: b"", line: 0 }; 3];
        let mut values = [0.0; 3];
        let line = self.words.line();
        for (at, (word, value)) in words.iter_mut().zip(&mut values).enumerate() {
            *word = self.word()?;
            *value = word.number().ok_or_else(|| {
                if ["vertex", "endloop"].iter().any(|next| word.is(next)) {
                    let problem = format!("a corner with {at} of three coordinates");
                    return damaged(line, problem, "export the part again; --salvage drops such facets");
                }
                let (problem, remedy) = word.number_problem();
                damaged(word.line, problem, remedy)
            })?;
        }
        if let Some(problem) = accept::point_problem(values) {
            return Err(damaged(words[0].line, problem, "export the part again; --salvage drops such facets"));
        }
        Ok(words)
    }

    fn append(&mut self, line: u64, corners: &[[Word<'_>; 3]; 3]) {
        if self.blocks.last().is_none_or(|b| b.facets >= BLOCK) {
            self.blocks.push(Block::default());
        }
        let Some(block) = self.blocks.last_mut() else { return };
        if block.facets == 0 {
            block.first_line = line;
        }
        block.facets += 1;
        let text = &mut block.text;
        text.extend_from_slice(b"facet normal 0 0 0\nouter loop\n");
        for corner in corners {
            text.extend_from_slice(b"vertex");
            for word in corner {
                text.push(b' ');
                text.extend_from_slice(word.text);
            }
            text.push(b'\n');
        }
        text.extend_from_slice(b"endloop\nendfacet\n");
    }

    /// Forgets a facet that could not be read and goes on to the next keyword between facets.
    fn drop_facet(&mut self) {
        self.dropped += 1;
        while self.words.peek().is_some_and(|w| !["facet", "endsolid", "solid"].iter().any(|k| w.is(k))) {
            self.words.next();
        }
    }

    /// Goes over words that do not belong here, on the present line only.
    fn skip_to(&mut self, keywords: &[&str]) {
        let line = self.words.line();
        while self.words.peek().is_some_and(|w| w.line == line && !keywords.iter().any(|k| w.is(k))) {
            self.words.next();
            self.stray_words += 1;
        }
    }

    fn require(&mut self, keyword: &str) -> Result<()> {
        let word = self.word()?;
        if word.is(keyword) {
            return Ok(());
        }
        let problem = format!("`{}` where `{keyword}` should stand", word.shown());
        Err(damaged(word.line, problem, "export the part again; --salvage drops such facets"))
    }

    fn word(&mut self) -> Result<Word<'a>> {
        let line = self.words.line();
        self.words.next().ok_or_else(|| {
            damaged(
                line,
                "the file ends inside a facet".into(),
                "export or copy the file again; --salvage keeps the whole facets",
            )
        })
    }

    fn notices(&self) -> Vec<Notice> {
        [
            ("no-endsolid", self.unclosed, "a solid is not closed by `endsolid`: the file may have been cut"),
            ("no-normal", self.without_normal, "facets without a normal; the order of corners decides"),
            ("stray-text", self.stray_words, "words that do not belong to STL were ignored"),
            ("salvaged", self.dropped, "damaged facets were dropped"),
        ]
        .into_iter()
        .filter(|(_, count, _)| *count > 0)
        .map(|(code, count, message)| Notice::new(code, format!("{message} ({count})")).counted(count))
        .collect()
    }
}

fn damaged(line: u64, problem: String, remedy: &str) -> Error {
    Error::Damaged { format: "STL", place: Place::Line(line), problem, remedy: remedy.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::stl;

    const FACET: &str =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 -0.0\nendloop\nendfacet\n";

    fn load(text: &str) -> Result<crate::io::Loaded> {
        stl::read(text.as_bytes(), Salvage::Refuse)
    }

    #[test]
    fn every_way_of_writing_it_is_read() {
        let plain = format!("solid a\n{FACET}endsolid a\n");
        for text in [
            plain.clone(),
            plain.replace('\n', "\r"),
            plain.replace('\n', "\r\n"),
            plain.replace(' ', "\t"),
            plain.to_uppercase(),
            plain.replace('\n', " "),
            plain.replacen("solid a", "solid", 1),
            format!("\u{feff}\n\n{plain}"),
            plain.replace("0 0 1\n", "nan nan nan\n"),
        ] {
            let l = load(&text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            assert_eq!((l.mesh.triangles.len(), l.mesh.vertices.len(), l.notices), (1, 3, vec![]), "{text:?}");
        }
    }

    #[test]
    fn all_solids_are_read_and_names_may_hold_any_bytes() {
        let two = format!("solid a\n{FACET}endsolid a\nsolid facet\n{}endsolid\n", FACET.replace("1 0 0", "9 0 0"));
        assert_eq!(load(&two).unwrap().mesh.triangles.len(), 2);
        let bytes = [&b"solid \xff\x1b[2J\n"[..], FACET.as_bytes(), b"endsolid"].concat();
        assert_eq!(stl::read(&bytes, Salvage::Refuse).unwrap().mesh.triangles.len(), 1);
        let many = format!("solid\n{}endsolid", FACET.repeat(2 * BLOCK + 1));
        assert_eq!(load(&many).unwrap().mesh.triangles.len(), 2 * BLOCK + 1);
    }

    #[test]
    fn oddities_are_noticed() {
        for (text, code) in [
            (format!("solid a\n{FACET}"), "no-endsolid"),
            (format!("solid a\n{}endsolid", FACET.replace(" normal 0 0 1", "")), "no-normal"),
            (format!("solid a\n{}endsolid", FACET.replace("endfacet", "endfacet bar")), "stray-text"),
            (format!("solid a\n{FACET}endsolid\nmore\n"), "stray-text"),
        ] {
            let l = load(&text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            assert_eq!((l.mesh.triangles.len(), l.notices[0].code.as_str()), (1, code), "{text:?}");
        }
    }

    #[test]
    fn faults_name_their_line() {
        let text = |from: &str, to: &str| format!("solid a\n{}endsolid\n", FACET.replacen(from, to, 1));
        for (from, to, line, words) in [
            ("vertex 1 0 0", "vertex 1 0 blah", 5, "`blah`"),
            ("vertex 1 0 0", "vertex 1,5 0 0", 5, "`1,5`"),
            ("vertex 1 0 0", "vertex 1e400 0 0", 5, "range"),
            ("vertex 1 0 0", "vertex 3.4e38 0 0", 5, "range"),
            ("vertex 1 0 0", "vertex 0x10 0 0", 5, "0x10"),
            ("vertex 1 0 0", "vertex nan 0 0", 5, "nan"),
            ("vertex 1 0 0\n", "", 6, "after 2"),
            ("vertex 1 0 0", "vertex 1 0", 5, "a corner with 2 of three coordinates"),
            ("vertex 0 1 -0.0", "vertex 0", 6, "a corner with 1 of three coordinates"),
            ("vertex 1 0 0", "vertex 1 0 0\nvertex 1 1 0", 7, "more than three"),
            ("outer", "inner", 3, "inner"),
            ("facet", "fac\u{1b}et", 2, "\\u{1b}"),
        ] {
            let e = load(&text(from, to)).unwrap_err();
            assert_eq!(e.place(), Some(format!("line {line}")), "{to}: {e}");
            assert!(e.to_string().contains(words), "{to}: {e}");
        }
        assert!(load(&text("1 0 0", "1,5 0 0")).unwrap_err().remedy().contains("locale"));
        let whole = format!("solid a\n{FACET}");
        for cut in 10..whole.len() - 11 {
            let e = load(&whole[..cut]).unwrap_err();
            assert!(matches!(e, Error::Damaged { .. } | Error::NoGeometry { .. }), "{cut}");
        }
    }

    #[test]
    fn salvaging_keeps_the_whole_facets() {
        let text = format!("solid\n{FACET}{}{FACET}facet normal 0 0", FACET.replace("1 0 0", "1 0 x"));
        let l = stl::read(text.as_bytes(), Salvage::KeepWhole).unwrap();
        assert_eq!(l.mesh.triangles.len(), 2);
        assert_eq!(l.notices.iter().find(|n| n.code == "salvaged").unwrap().count, Some(2));
    }

    #[test]
    #[ignore = "a measurement, not a test"]
    fn triangles_a_second() {
        let n = 400_000;
        let facet = FACET.replace("1 0 0", "1.234567e+01 -2.345678e+00 3.456789e-01");
        let text = format!("solid\n{}endsolid", facet.repeat(n));
        let rate = |start: std::time::Instant| n as f64 / start.elapsed().as_secs_f64() / 1e6;
        let start = std::time::Instant::now();
        refuse_endless_line(text.as_bytes()).unwrap();
        println!("lines {:.2} M/s", rate(start));
        let start = std::time::Instant::now();
        let mut r =
            Reading { words: Words::new(text.as_bytes()), blocks: vec![Block::default()], ..Reading::default() };
        r.solids(Salvage::Refuse).unwrap();
        println!("checked {:.2} M/s", rate(start));
        let start = std::time::Instant::now();
        let soup: Vec<_> = r.blocks.par_iter().map(|b| b.parse().unwrap()).collect();
        println!("parsed {:.2} M/s {}", rate(start), soup.len());
        let start = std::time::Instant::now();
        load(&text).unwrap();
        println!("whole {:.2} M/s", rate(start));
    }
}
