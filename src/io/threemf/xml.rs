//! XML as a flat run of opening and closing tags, with lines for faults.

use super::model::CORE;
use crate::error::{Error, Place, Result, printable};
use crate::io::words::Word;
use quick_xml::NsReader;
use quick_xml::events::{BytesStart, Event};
use quick_xml::name::ResolveResult;
use std::borrow::Cow;
use std::cell::Cell;

/// Deepest nesting of elements; the core specification needs seven.
const DEEPEST: u32 = 32;

/// A cursor over the elements of a part.
pub(super) struct Xml<'a> {
    reader: NsReader<&'a [u8]>,
    bytes: &'a [u8],
    part: &'a str,
    depth: u32,
    /// How far lines have been counted, and how many there were.
    counted: Cell<(usize, u64)>,
}

/// What the cursor met.
pub(super) enum Step<'a> {
    Open(Tag<'a>),
    Close,
    End,
}

/// An opening tag.
pub(super) struct Tag<'a> {
    /// Its namespace, empty for none.
    pub(super) namespace: Cow<'static, str>,
    start: BytesStart<'a>,
}

impl<'a> Xml<'a> {
    pub(super) fn new(bytes: &'a [u8], part: &'a str) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut reader = NsReader::from_reader(bytes);
        reader.config_mut().expand_empty_elements = true;
        Xml { reader, bytes, part, depth: 0, counted: Cell::new((0, 1)) }
    }

    /// The next tag; text, comments and instructions are passed over.
    ///
    /// # Errors
    /// [`Error::Damaged`] for ill-formed XML, a document type (the door of entity attacks), nesting deeper
    /// than 32, and an end inside an element.
    pub(super) fn next(&mut self) -> Result<Step<'a>> {
        loop {
            let before = self.reader.buffer_position();
            let (namespace, event) = match self.reader.read_resolved_event() {
                Ok((ResolveResult::Bound(ns), event @ Event::Start(_))) => {
                    // Nearly all tags are of the core, which needs no copy.
                    let known = (ns.as_ref() == CORE.as_bytes()).then_some(Cow::Borrowed(CORE));
                    (known.unwrap_or_else(|| String::from_utf8_lossy(ns.as_ref()).into_owned().into()), event)
                }
                Ok((_, event)) => (Cow::Borrowed(""), event),
                Err(e) => return Err(self.bad(printable(&e.to_string()))),
            };
            match event {
                Event::Start(start) => {
                    self.depth += 1;
                    if self.depth > DEEPEST {
                        return Err(self.bad(format!("elements nested deeper than {DEEPEST}")));
                    }
                    return Ok(Step::Open(Tag { namespace, start }));
                }
                Event::End(_) => {
                    self.depth = self.depth.saturating_sub(1);
                    return Ok(Step::Close);
                }
                Event::Eof if self.depth > 0 => return Err(self.bad("the part ends inside an element".into())),
                Event::Eof => return Ok(Step::End),
                Event::DocType(_) => return Err(self.bad("a document type (DTD), which 3MF forbids".into())),
                _ if self.reader.buffer_position() == before => {
                    return Err(self.bad("the XML reader stands still".into()));
                }
                _ => {}
            }
        }
    }

    /// The namespace that a prefix stands for where the cursor is.
    pub(super) fn namespace_of(&self, prefix: &str) -> Option<String> {
        let known = self.reader.prefixes().find(|(p, _)| match p {
            quick_xml::name::PrefixDeclaration::Named(name) => *name == prefix.as_bytes(),
            quick_xml::name::PrefixDeclaration::Default => false,
        });
        known.map(|(_, ns)| String::from_utf8_lossy(ns.as_ref()).into_owned())
    }

    /// The line of the cursor, counted from 1; all of them together cost one pass over the part.
    pub(super) fn line(&self) -> u64 {
        let (from, lines) = self.counted.get();
        let at = self.position().max(from);
        let passed = self.bytes.get(from..at).unwrap_or_default();
        let lines = lines + passed.iter().filter(|&&b| b == b'\n').count() as u64;
        self.counted.set((at, lines));
        lines
    }

    /// The text between the tag just met and the next.
    pub(super) fn text_ahead(&self) -> String {
        let rest = self.bytes.get(self.position()..).unwrap_or_default();
        let text = rest.split(|&b| b == b'<').next().unwrap_or_default();
        String::from_utf8_lossy(text).into_owned()
    }

    fn position(&self) -> usize {
        usize::try_from(self.reader.buffer_position()).unwrap_or(usize::MAX).min(self.bytes.len())
    }

    /// A fault at the cursor.
    pub(super) fn bad(&self, problem: String) -> Error {
        self.bad_with(problem, "export the package again")
    }

    /// A fault at the cursor, with what to try.
    pub(super) fn bad_with(&self, problem: String, remedy: &str) -> Error {
        let place = Place::Member { name: self.part.to_string(), line: Some(self.line()) };
        Error::Damaged { format: "3MF", place, problem, remedy: remedy.into() }
    }

    /// Calls `each` with name and raw value of every attribute of a tag.
    pub(super) fn attributes(
        &self,
        tag: &Tag<'_>,
        mut each: impl FnMut(&[u8], &Cow<'_, [u8]>) -> Result<()>,
    ) -> Result<()> {
        for attribute in tag.start.attributes() {
            let attribute = attribute.map_err(|e| self.bad(printable(&e.to_string())))?;
            each(attribute.key.as_ref(), &attribute.value)?;
        }
        Ok(())
    }

    /// The value of an attribute, its entities resolved.
    pub(super) fn text(&self, tag: &Tag<'_>, name: &str) -> Result<Option<String>> {
        let mut found = None;
        for attribute in tag.start.attributes() {
            let attribute = attribute.map_err(|e| self.bad(printable(&e.to_string())))?;
            if attribute.key.as_ref() == name.as_bytes() {
                let value = attribute.unescape_value().map_err(|e| self.bad(printable(&e.to_string())))?;
                found = Some(value.into_owned());
            }
        }
        Ok(found)
    }

    /// The value of an attribute of a namespace, its entities resolved.
    ///
    /// # Errors
    /// [`Error::Damaged`] for one of that name without a declared namespace: nobody knows what it says.
    pub(super) fn text_in(&self, tag: &Tag<'_>, namespace: &str, name: &str) -> Result<Option<String>> {
        let mut found = None;
        for attribute in tag.start.attributes() {
            let attribute = attribute.map_err(|e| self.bad(printable(&e.to_string())))?;
            let (bound, local) = self.reader.resolve_attribute(attribute.key);
            match bound {
                _ if local.as_ref() != name.as_bytes() => {}
                ResolveResult::Bound(ns) if ns.as_ref() != namespace.as_bytes() => {}
                ResolveResult::Bound(_) => {
                    let value = attribute.unescape_value().map_err(|e| self.bad(printable(&e.to_string())))?;
                    found = Some(value.into_owned());
                }
                ResolveResult::Unbound | ResolveResult::Unknown(_) => {
                    let shown = printable(&String::from_utf8_lossy(attribute.key.as_ref()));
                    return Err(self.bad(format!("the attribute `{shown}` is of no declared namespace")));
                }
            }
        }
        Ok(found)
    }

    /// A whole number from 0 to 2³² − 1.
    pub(super) fn whole(&self, name: &[u8], value: &[u8]) -> Result<u32> {
        std::str::from_utf8(value.trim_ascii()).ok().and_then(|t| t.parse().ok()).ok_or_else(|| {
            let shown = |b: &[u8]| printable(&String::from_utf8_lossy(b));
            self.bad(format!("`{}` of `{}` is not a whole number", shown(value), shown(name)))
        })
    }

    /// A decimal number.
    pub(super) fn number(&self, value: &[u8]) -> Result<f64> {
        let word = Word { text: value.trim_ascii(), line: 0 };
        word.number().ok_or_else(|| {
            let (problem, remedy) = word.number_problem();
            self.bad_with(problem, remedy)
        })
    }
}

impl Tag<'_> {
    /// The name without its prefix.
    pub(super) fn name(&self) -> &[u8] {
        self.start.local_name().into_inner()
    }
}
