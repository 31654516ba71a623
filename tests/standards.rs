//! SARIF and JUnit files against the schemas that others publish (`tests/data/README.md`).

mod sample;

use amcheck::check::State;
use amcheck::error::{Error, Place};
use amcheck::report::baseline::{Comparison, compare};
use amcheck::report::{Report, junit, sarif};
use flate2::read::GzDecoder;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::Path;

/// The reports that are looked at: all states, a hostile name, a crowd with accepted findings, nothing at all; and those of all committed
/// parts.
fn reports() -> Vec<Report> {
    let mut empty = sample::report("bracket.stl");
    empty.checks.clear();
    let invented =
        [sample::report("bracket.stl"), sample::report(sample::HOSTILE), sample::crowded("a&b \"c\".stl").0, empty];
    let kept = sample::kept()
        .into_iter()
        .map(|(name, text)| serde_json::from_str(&text).unwrap_or_else(|e| panic!("{name}: {e}")));
    invented.into_iter().chain(kept).collect()
}

/// A report beside one that had the first finding of each check alone.
fn news(report: &Report) -> Comparison {
    let mut old = report.clone();
    old.checks.iter_mut().for_each(|c| c.findings.truncate(1));
    compare(&old, report)
}

/// Reasons to refuse a part, one with a place and names from outside, one without.
fn refusals() -> [Error; 2] {
    let (problem, remedy) = (format!("{} & <b>", sample::HOSTILE), "export \"it\" again".to_string());
    [
        Error::Damaged { format: "STL", place: Place::Byte(300), problem: problem.clone(), remedy: remedy.clone() },
        Error::NoGeometry { problem, remedy },
    ]
}

#[test]
fn sarif_keeps_to_the_schema_of_oasis() {
    let mut text = String::new();
    GzDecoder::new(&include_bytes!("data/sarif-2.1.0.schema.json.gz")[..]).read_to_string(&mut text).unwrap();
    let schema: serde_json::Value = serde_json::from_str(&text).unwrap();
    let validator = jsonschema::validator_for(&schema).expect("the published schema is one");
    for (report, since) in reports().into_iter().flat_map(|r| [(r.clone(), None), (r.clone(), Some(news(&r)))]) {
        let text = sarif::write(&report, Path::new("-"), since.as_ref());
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let faults: Vec<String> =
            validator.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path)).take(5).collect();
        assert!(faults.is_empty(), "{}: {faults:#?}", report.part.file);
        // The schema sees what is wrong.
        let mut spoilt = value.clone();
        spoilt["runs"][0]["tool"]["driver"]["name"] = serde_json::Value::Null;
        assert!(!validator.is_valid(&spoilt));
    }
    for error in refusals() {
        let value: serde_json::Value = serde_json::from_str(&sarif::refused(Path::new("a/b.stl"), &error)).unwrap();
        let faults: Vec<String> = validator.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path)).collect();
        assert!(faults.is_empty(), "{error}: {faults:#?}");
    }
    let (crowded, _) = sample::crowded("a.stl");
    let value: serde_json::Value = serde_json::from_str(&sarif::write(&crowded, Path::new("-"), None)).unwrap();
    let results = value["runs"][0]["results"].as_array().unwrap();
    let suppressed: Vec<_> = results.iter().filter(|r| r["suppressions"].is_array()).collect();
    assert_eq!(suppressed.len(), 1);
    assert_eq!(suppressed[0]["suppressions"][0]["status"], "accepted");
}

#[test]
fn junit_keeps_to_the_schema_of_the_xunit_plugin() {
    let schema = Schema::read(include_str!("data/junit-10.xsd"));
    assert!(schema.elements.len() == 10, "{:?}", schema.elements.keys());
    for report in reports() {
        for since in [None, Some(news(&report))] {
            let text = junit::write(&report, &[State::Fail, State::Warn, State::Undecided], since.as_ref());
            schema.check(&text).unwrap_or_else(|fault| panic!("{}: {fault}\n{text}", report.part.file));
        }
    }
    for error in refusals() {
        let text = junit::refused(sample::HOSTILE, &error);
        schema.check(&text).unwrap_or_else(|fault| panic!("{error}: {fault}\n{text}"));
    }
    let text = junit::write(&sample::report("bracket.stl"), &[State::Fail], None);
    for (good, bad) in [("<testcase ", "<testcas "), (" tests=", " test="), ("<skipped ", "<skipped when=\"x\" ")] {
        assert!(schema.check(&text.replace(good, bad)).is_err(), "{bad} is not noticed");
    }
}

/// What the published schema says of an element; it uses no more of XML Schema than this.
#[derive(Debug, Default)]
struct Element {
    children: BTreeSet<String>,
    attributes: BTreeSet<String>,
    required: BTreeSet<String>,
    /// Whether text may stand in it.
    text: bool,
}

/// An XML Schema of named elements whose children are all references, in any order and number.
#[derive(Debug, Default)]
struct Schema {
    elements: BTreeMap<String, Element>,
}

fn attributes(tag: &BytesStart) -> BTreeMap<String, String> {
    let pair = |a: quick_xml::events::attributes::Attribute| {
        (String::from_utf8_lossy(a.key.as_ref()).into_owned(), a.unescape_value().unwrap().into_owned())
    };
    tag.attributes().map(|a| pair(a.expect("attributes are well-formed"))).collect()
}

fn name(tag: &BytesStart) -> String {
    String::from_utf8_lossy(tag.name().as_ref()).into_owned()
}

impl Schema {
    fn read(text: &str) -> Self {
        let mut schema = Schema::default();
        let mut reader = Reader::from_str(text);
        let mut open: Option<String> = None;
        loop {
            let event = reader.read_event().expect("the schema is well-formed");
            let (Event::Start(tag) | Event::Empty(tag)) = &event else {
                match event {
                    Event::Eof => return schema,
                    _ => continue,
                }
            };
            let given = attributes(tag);
            match (name(tag).as_str(), given.get("name"), given.get("ref")) {
                ("xs:element", Some(element), _) => {
                    let text = given.get("type").is_some_and(|t| t == "xs:string");
                    schema.elements.insert(element.clone(), Element { text, ..Element::default() });
                    open = Some(element.clone());
                }
                (tag, named, child) => {
                    let Some(of) = open.as_ref().and_then(|o| schema.elements.get_mut(o)) else { continue };
                    match (tag, named, child) {
                        ("xs:element", _, Some(child)) => drop(of.children.insert(child.clone())),
                        ("xs:attribute", Some(attribute), _) => {
                            of.attributes.insert(attribute.clone());
                            if given.get("use").is_some_and(|u| u == "required") {
                                of.required.insert(attribute.clone());
                            }
                        }
                        ("xs:complexType", ..) => of.text |= given.get("mixed").is_some_and(|m| m == "true"),
                        ("xs:sequence" | "xs:choice", ..) => {}
                        other => panic!("the schema uses {other:?}, which this reader does not know"),
                    }
                }
            }
        }
    }

    /// Whether a document keeps to the schema; the first fault otherwise.
    fn check(&self, text: &str) -> Result<(), String> {
        let mut reader = Reader::from_str(text);
        let mut open: Vec<String> = Vec::new();
        loop {
            let event = reader.read_event().map_err(|e| e.to_string())?;
            match &event {
                Event::Start(tag) | Event::Empty(tag) => {
                    let own = name(tag);
                    let element = self.elements.get(&own).ok_or(format!("no element {own} is known"))?;
                    if let Some(parent) = open.last()
                        && !self.elements[parent].children.contains(&own)
                    {
                        return Err(format!("{own} stands in {parent}"));
                    }
                    let given: BTreeSet<String> = attributes(tag).into_keys().collect();
                    if let Some(unknown) = given.difference(&element.attributes).next() {
                        return Err(format!("{own} has no attribute {unknown}"));
                    }
                    if let Some(missing) = element.required.difference(&given).next() {
                        return Err(format!("{own} lacks {missing}"));
                    }
                    if matches!(event, Event::Start(_)) {
                        open.push(own);
                    }
                }
                Event::End(_) => drop(open.pop()),
                Event::Text(t) if !t.iter().all(u8::is_ascii_whitespace) => {
                    let parent = open.last().ok_or("text stands outside")?;
                    if !self.elements[parent].text {
                        return Err(format!("text stands in {parent}"));
                    }
                }
                Event::Eof if open.is_empty() => return Ok(()),
                Event::Eof => return Err("the document ends early".into()),
                _ => {}
            }
        }
    }
}
