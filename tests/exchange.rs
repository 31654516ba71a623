//! What pipelines read: comparison with a baseline, Markdown, JUnit, SARIF, badge.

mod sample;

use amcheck::check::{Finding, Sense, Spot, State};
use amcheck::report::baseline::{Comparison, Delta, compare, text};
use amcheck::report::terminal::Palette;
use amcheck::report::{BodyReport, Report, badge, json, junit, markdown, sarif};
use std::path::Path;

/// The index of a check of the sample.
fn at(report: &Report, name: &str) -> usize {
    report.checks.iter().position(|c| c.name == name).unwrap()
}

#[test]
fn a_report_is_the_same_as_itself() {
    let report = sample::report("a.stl");
    let c = compare(&report, &report);
    assert_eq!((c.count(Delta::Same), c.changes.len()), (5, 5));
    assert!(c.worst_news() != Some(State::Fail));
}

#[test]
fn a_count_over_the_whole_mesh_is_the_same_wherever_it_is_told() {
    let of = |at: [f64; 3], count: f64| {
        let mut report = sample::report("a.stl");
        let walls = self::at(&report, "thin-wall");
        let mut f = report.checks[walls].findings[0].clone();
        (f.code, f.kind, f.unit, f.sense) = ("AM001".into(), "overlapping-facets".into(), "1".into(), Sense::Max);
        (f.value, f.low, f.high, f.count, f.fingerprint) = (count, count, count, 1, format!("{at:?}"));
        (f.at_mm, f.box_mm, f.area_mm2) = (at, [at; 2], None);
        f.places = vec![Spot { at_mm: at, box_mm: None, value: count, low: count, high: count }];
        report.checks[walls].findings = vec![f];
        report
    };
    let delta = |old: &Report, new: &Report| {
        let changes = compare(old, new).changes;
        changes.into_iter().find(|c| c.check == "thin-wall").map(|c| (c.delta, c.old.is_some() && c.new.is_some()))
    };
    let (here, there) = (of([1.0, 2.0, 3.0], 10.0), of([9.0, 8.0, 7.0], 10.0));
    assert_eq!(delta(&here, &there), Some((Delta::Same, true)));
    assert_eq!(delta(&here, &of([9.0, 8.0, 7.0], 12.0)), Some((Delta::Worse, true)));
}

#[test]
fn a_part_that_was_moved_by_as_much_as_its_features_are_apart_is_the_same() {
    let row = |by: f64| {
        let mut report = sample::report("a.stl");
        let walls = at(&report, "thin-wall");
        let first = report.checks[walls].findings[0].clone();
        let of = |n: usize| {
            let x = 5.0 * n as f64;
            let value = 0.4 + 0.02 * n as f64;
            let mut f = first.moved([x - first.at_mm[0] + by, 0.0, 0.0]);
            (f.value, f.low, f.high, f.fingerprint) = (value, value - 0.001, value + 0.001, format!("{n}"));
            f
        };
        report.checks[walls].findings = (0..4).map(of).collect();
        let lists = report.checks.iter_mut().enumerate().filter(|(n, _)| *n != walls);
        lists.flat_map(|(_, c)| &mut c.findings).for_each(|f| *f = f.moved([by, 0.0, 0.0]));
        report.part.box_mm.iter_mut().for_each(|p| p[0] += by);
        report
    };
    let c = compare(&row(0.0), &row(5.0));
    assert_eq!(c.count(Delta::Same), c.changes.len(), "{:?}", c.words());
    // Where the box has changed as well nobody knows by how much: then it is where it lies.
    let mut longer = row(5.0);
    longer.part.box_mm[1][0] += 1.0;
    assert!(compare(&row(0.0), &longer).count(Delta::Worse) > 0);
}

#[test]
fn an_area_that_grew_is_worse_at_the_same_value() {
    let of = |area: f64| {
        let mut report = sample::report("a.stl");
        let walls = at(&report, "thin-wall");
        report.checks[walls].findings[0].area_mm2 = Some(area);
        report
    };
    for (old, new, worse, better) in
        [(28.0, 717.0, 1, 0), (28.0, 30.5, 0, 0), (235.0, 258.0, 0, 0), (235.0, 353.0, 1, 0), (717.0, 28.0, 0, 1)]
    {
        let c = compare(&of(old), &of(new));
        assert_eq!((c.count(Delta::Worse), c.count(Delta::Better)), (worse, better), "{old} {new}");
    }
    let told = text(&compare(&of(28.0), &of(717.0)), Palette::Plain);
    assert!(told.contains("over 28 mm² → ") && told.contains("over 717 mm²"), "{told}");
}

#[test]
fn changes_are_matched_by_place_and_need_parted_brackets() {
    let old = sample::report("a.stl");
    let mut new = old.clone();
    let walls = at(&new, "thin-wall");
    let fins = &mut new.checks[walls].findings;
    // Moved by one sample and thinner beyond both brackets; the other overlaps its old bracket.
    fins[0].at_mm[0] += 0.1;
    (fins[0].value, fins[0].low, fins[0].high) = (0.40, 0.39, 0.41);
    (fins[1].value, fins[1].low, fins[1].high) = (0.57, 0.55, 0.59);
    let mut fresh = fins[0].clone();
    fresh.at_mm = [-20.0, 3.0, 1.0];
    fresh.box_mm = [[-20.1, 2.9, 0.9], [-19.9, 3.1, 1.1]];
    fresh.fingerprint = "elsewhere".into();
    fins.push(fresh);
    let void = at(&new, "trapped-volume");
    new.checks[void].findings.clear();
    new.checks[void].state = State::Pass;
    let blend = at(&new, "blend");
    new.checks[blend].findings.clear();
    (new.checks[blend].state, new.checks[blend].why) = (State::NotRun, Some("left out".into()));
    let c = compare(&old, &new);
    let deltas: Vec<(&str, &str)> = c.changes.iter().map(|c| (c.delta.word(), c.check.as_str())).collect();
    assert_eq!(
        deltas,
        [
            ("new", "thin-wall"),
            ("worse", "thin-wall"),
            ("unchecked", "blend"),
            ("same", "overhang"),
            ("same", "thin-wall"),
            ("fixed", "trapped-volume"),
        ]
    );
    assert!(c.worst_news() == Some(State::Fail));
    let back = compare(&new, &old);
    // `blend` was not run in what is the baseline now.
    let counts = [Delta::Better, Delta::Fixed, Delta::New, Delta::Unchecked].map(|delta| back.count(delta));
    assert_eq!(counts, [1, 1, 1, 1]);
    let said = text(&c, Palette::Plain);
    assert!(said.contains("0.45 mm → 0.4 mm") && said.contains("1 new, 1 worse"), "{said}");
    // By another limit nobody knows whether what is gone was mended.
    let limit = new.process.limits.values().next().expect("a limit").clone();
    new.process.limits.insert("trapped-volume.mouths".into(), limit);
    let c = compare(&old, &new);
    assert_eq!((c.count(Delta::Fixed), c.count(Delta::Unchecked)), (0, 2));
    let said = text(&c, Palette::Plain);
    assert!(said.contains("judged otherwise: trapped-volume.mouths: no limit → must"), "{said}");
}

/// The sample with fins of these thicknesses, 10 mm apart along x: what is equally thin is one finding.
fn fins(thicknesses: &[f64]) -> Report {
    let mut report = sample::report("fins.stl");
    let walls = at(&report, "thin-wall");
    let of = report.checks[walls].findings[0].clone();
    let mut found: Vec<Finding> = Vec::new();
    for (n, &thick) in thicknesses.iter().enumerate().filter(|(_, t)| **t < 0.8) {
        let x = 10.0 * n as f64;
        let (at_mm, own) = ([x, 2.0, 3.0], [[x - 0.5, 0.0, 0.0], [x + 0.5, 9.0, 9.0]]);
        let spot = Spot { at_mm, box_mm: Some(own), value: thick, low: thick, high: thick };
        match found.iter_mut().find(|f| f.value == thick) {
            Some(f) => {
                (f.count, f.box_mm) = (f.count + 1, [f.box_mm[0], own[1]]);
                f.places.push(spot);
            }
            None => found.push(Finding {
                fingerprint: format!("AM101/wall/{n}"),
                at_mm,
                box_mm: own,
                places: vec![spot],
                ..of.clone()
            }),
        }
        let last = found.iter_mut().find(|f| f.places.contains(&spot)).expect("it was put there");
        (last.value, last.low, last.high) = (thick, thick, thick);
    }
    report.checks[walls].findings = found;
    report
}

#[test]
fn equal_places_are_compared_one_by_one() {
    let told = |old: &[f64], new: &[f64]| {
        let c = compare(&fins(old), &fins(new));
        let walls: Vec<&str> = c.changes.iter().filter(|c| c.check == "thin-wall").map(|c| c.delta.word()).collect();
        (walls.join(" "), c.worst_news() == Some(State::Fail), text(&c, Palette::Plain))
    };
    // As many as before, and another one.
    let (words, fails, said) = told(&[0.6, 2.0, 0.6], &[0.6, 0.6, 2.0]);
    assert_eq!((words.as_str(), fails), ("worse", true));
    assert!(said.contains("1 of 2 places new, at 10, 2, 3"), "{said}");
    // What was thinner is as thin as its neighbour now.
    assert_eq!(told(&[0.45, 0.6, 0.9], &[0.6, 0.6, 0.9]).0, "same better");
    assert!(!told(&[0.45, 0.6, 0.9], &[0.6, 0.6, 0.9]).1);
    // One of three is thinner than before: it left the others.
    let (words, fails, _) = told(&[0.6, 0.6, 0.6], &[0.6, 0.5, 0.6]);
    assert_eq!((words.as_str(), fails), ("worse same", true));
    assert_eq!(told(&[0.6, 0.6, 0.6], &[0.6, 1.5, 0.6]).0, "better");
    assert_eq!(told(&[0.6, 0.6, 1.5], &[0.6, 0.6, 0.6]).0, "worse");
    assert_eq!(told(&[0.6, 0.6, 0.6], &[0.6, 0.6, 0.6]).0, "same");
}

#[test]
fn more_places_are_worse_and_what_leaves_or_joins_a_finding_is_not_new() {
    let old = sample::report("part.stl");
    let mut new = old.clone();
    let fins = &mut new.checks[at(&old, "thin-wall")].findings;
    fins[0].count += 4;
    let c = compare(&old, &new);
    assert!(c.count(Delta::Worse) == 1 && c.count(Delta::New) == 0 && c.worst_news() == Some(State::Fail));
    assert!(text(&c, Palette::Plain).contains("→ 5 places"), "{}", text(&c, Palette::Plain));
    assert_eq!(compare(&new, &old).count(Delta::Better), 1);
    // One of its places has a value of its own now, elsewhere.
    let fins = &mut new.checks[at(&old, "thin-wall")].findings;
    let mut left = fins[0].clone();
    left.at_mm = [-20.0, 3.0, 1.0];
    left.box_mm = [[-20.1, 2.9, 0.9], [-19.9, 3.1, 1.1]];
    left.fingerprint = "elsewhere".into();
    fins[0].places = fins[0].spots();
    let (at_mm, box_mm) = (left.at_mm, Some(left.box_mm));
    fins[0].places.push(Spot { at_mm, box_mm, value: left.value, low: left.low, high: left.high });
    let grouped = new.clone();
    let rest = &mut new.checks[at(&old, "thin-wall")].findings[0];
    rest.count -= 1;
    rest.places.pop();
    left.count = 1;
    // Beside all that there were it is another one, though one of them lies in its box.
    let mut beside = grouped.clone();
    beside.checks[at(&old, "thin-wall")].findings.push(left.clone());
    assert!(
        compare(&grouped, &beside).count(Delta::New) == 1
            && compare(&grouped, &beside).worst_news() == Some(State::Fail)
    );
    new.checks[at(&old, "thin-wall")].findings.push(left);
    assert_eq!(compare(&grouped, &new).count(Delta::New), 0);
    assert_eq!(compare(&new, &grouped).count(Delta::Fixed), 0);
}

#[test]
fn markdown_has_the_findings_and_escapes_names() {
    let report = sample::report("a|b_<i>`@x`.stl");
    let text = markdown::write(&report, Some(&compare(&report, &report)));
    println!("{text}");
    assert!(text.starts_with("### ✖ Not printable as is: a\\|b\\_&lt;i&gt;\\`&#64;x\\`.stl\n"));
    assert!(text.contains("| ✖ | thin-wall | 0.45 mm (0.4499–0.4501) | must ≥ 0.5 mm | 21.6, 0, 11 |"));
    assert!(text.contains("**Against the baseline:** 5 same") && text.len() < 64_000);
}

#[test]
fn junit_is_well_formed_and_counts_what_it_holds() {
    let text = junit::write(&sample::report(sample::HOSTILE), &[State::Fail], None);
    let mut reader = quick_xml::Reader::from_str(&text);
    let (mut seen, mut file) = (std::collections::BTreeMap::<String, usize>::new(), String::new());
    loop {
        use quick_xml::events::Event;
        match reader.read_event().unwrap() {
            Event::Eof => break,
            Event::Start(e) | Event::Empty(e) => {
                let name = String::from_utf8(e.name().as_ref().to_vec()).unwrap();
                if name == "testsuite" {
                    file = e.try_get_attribute("name").unwrap().unwrap().unescape_value().unwrap().into_owned();
                }
                *seen.entry(name).or_default() += 1;
            }
            _ => {}
        }
    }
    assert_eq!(file, sample::HOSTILE);
    let counts = ["testcase", "failure", "skipped", "error"].map(|n| seen.get(n).copied().unwrap_or(0));
    assert_eq!(counts, [9, 2, 3, 0]);
    assert!(text.contains("tests=\"9\" failures=\"2\" errors=\"0\" skipped=\"3\""));
}

#[test]
fn junit_fails_what_is_to_fail() {
    let report = sample::report("a.stl");
    let said = |failing: &[State]| {
        let text = junit::write(&report, failing, None);
        let failures = text.matches("<failure ").count();
        assert!(text.contains(&format!("failures=\"{failures}\"")), "{text}");
        failures
    };
    let fail = report.count(State::Fail);
    assert!(report.count(State::Warn) > 0 && report.count(State::Undecided) > 0);
    assert_eq!(said(&[]), 0);
    let told = junit::write(&report, &[], None);
    assert!(told.contains("<system-out>✖ thin-wall[1]"), "{told}");
    assert_eq!(said(&[State::Fail]), fail);
    assert_eq!(said(&[State::Fail, State::Undecided]), fail + report.undecided());
    let all = fail + report.count(State::Warn) + report.count(State::Undecided);
    assert_eq!(said(&[State::Fail, State::Warn, State::Undecided]), all);
}

/// The alerts on the part at a path.
fn alerts(report: &Report, part: &str, since: Option<&Comparison>) -> serde_json::Value {
    serde_json::from_str(&sarif::write(report, Path::new(part), since)).unwrap()
}

/// What each alert was in the baseline.
fn baseline_states(report: &Report, since: &Comparison) -> Vec<String> {
    let results = alerts(report, "a.stl", Some(since))["runs"][0]["results"].as_array().unwrap().clone();
    results.iter().map(|r| r["baselineState"].as_str().unwrap_or("none").to_string()).collect()
}

#[test]
fn test_cases_and_alerts_know_what_was_there_before() {
    let old = sample::report("a.stl");
    let same = compare(&old, &old);
    let text = junit::write(&old, &[State::Fail], Some(&same));
    assert!(text.contains("failures=\"0\"") && text.contains("was there before: ✖ thin-wall[1]"), "{text}");
    assert_eq!(baseline_states(&old, &same), ["unchanged"; 5]);
    assert!(alerts(&old, "a.stl", None)["runs"][0]["results"][0]["baselineState"].is_null());
    // One fin is thinner, another is new, and a warning as well.
    let mut new = old.clone();
    let (walls, slopes) = (at(&new, "thin-wall"), at(&new, "overhang"));
    let fins = &mut new.checks[walls].findings;
    (fins[0].value, fins[0].low, fins[0].high) = (0.3, 0.29, 0.31);
    let mut fresh = fins[1].moved([-40.0, 3.0, 1.0]);
    fresh.fingerprint = "elsewhere".into();
    fins.push(fresh);
    let mut slope = new.checks[slopes].findings[0].moved([-40.0, 3.0, 1.0]);
    slope.fingerprint = "elsewhere too".into();
    new.checks[slopes].findings.push(slope);
    let changed = compare(&old, &new);
    let text = junit::write(&new, &[State::Fail], Some(&changed));
    assert!(text.contains("failures=\"1\"") && text.contains("<failure message=\"worse: ✖ thin-wall[1]"), "{text}");
    let warned = junit::write(&new, &[State::Fail, State::Warn, State::Undecided], Some(&changed));
    assert!(warned.contains("failures=\"2\""), "{warned}");
    let mut states = baseline_states(&new, &changed);
    states.sort();
    assert_eq!(states, ["new", "new", "unchanged", "unchanged", "unchanged", "unchanged", "updated"]);
}

#[test]
fn what_a_baseline_did_not_look_for_is_no_news() {
    let new = sample::report("a.stl");
    let mut old = new.clone();
    let walls = at(&old, "thin-wall");
    for (state, kept) in
        [(State::NotRun, true), (State::Error, true), (State::NotApplicable, true), (State::Pass, false)]
    {
        old.checks[walls].state = state;
        old.checks[walls].findings.clear();
        if !kept {
            old.checks.remove(walls);
        }
        let compared = compare(&old, &new);
        let news = compared.worst_news();
        if state == State::NotApplicable {
            // That is an answer, too: what is found since came since.
            assert_eq!((news, compared.not_compared.len()), (Some(State::Fail), 0));
            continue;
        }
        assert_eq!((news, compared.count(Delta::New)), (None, 0), "{state:?}");
        assert_eq!(compared.not_compared, ["AM101 thin-wall"]);
        let said = "not compared: the baseline did not run AM101 thin-wall";
        assert!(text(&compared, Palette::Plain).contains(said));
        assert!(
            markdown::write(&new, Some(&compared))
                .contains("Not compared&#58; the baseline did not run AM101 thin-wall")
        );
        let cases = junit::write(&new, &[State::Fail], Some(&compared));
        assert!(
            cases.contains("failures=\"0\"") && cases.contains("not compared, the baseline did not run"),
            "{cases}"
        );
        let count = new.checks[walls].findings.len();
        let states = baseline_states(&new, &compared);
        assert_eq!(states.iter().filter(|s| *s == "none").count(), count, "{states:?}");
        let schema = jsonschema::validator_for(&serde_json::from_str(json::SCHEMA_TEXT).unwrap()).unwrap();
        let told = Report { baseline: Some(compared.told()), ..new.clone() };
        let value: serde_json::Value = serde_json::from_str(&json::write(&told)).unwrap();
        assert!(schema.is_valid(&value) && value["baseline"]["not_compared"][0] == "AM101 thin-wall", "{value}");
    }
}

/// The sample as two bodies with a gap between them that fails, and what has become of them.
fn jointed(bodies: &[BodyReport]) -> Report {
    let mut report = sample::report("joint.stl");
    let walls = at(&report, "thin-wall");
    let own = &mut report.checks[walls].findings;
    let gap = Finding { kind: "gap-between-bodies".into(), bodies: Some(vec![1, 2]), ..own[0].clone() };
    *own = if bodies.len() == 2 { vec![gap] } else { Vec::new() };
    (report.part.bodies, report.part.each_body) = (bodies.len() as u64, bodies.to_vec());
    if let [one] = bodies {
        report.part.volume_mm3.value = one.volume_mm3;
        report.part.each_body.clear();
    }
    report
}

#[test]
fn a_gap_between_bodies_that_are_one_now_is_worse_and_one_beside_a_body_that_is_gone_is_fixed() {
    let [block, pin] = [(11_000.0, -28.0), (900.0, 10.0)]
        .map(|(volume_mm3, x)| BodyReport { box_mm: [[x, -18.0, 0.0], [28.0, 18.0, 26.0]], volume_mm3 });
    let old = jointed(&[block, pin]);
    let became = |volume_mm3: f64| compare(&old, &jointed(&[BodyReport { volume_mm3, ..block }]));
    let welded = became(11_950.0);
    assert!(
        welded.worst_news() == Some(State::Fail) && welded.count(Delta::Worse) == 1 && welded.count(Delta::Fixed) == 0
    );
    let said = text(&welded, Palette::Plain);
    assert!(said.contains("bodies 1 and 2 are one body now") && said.contains("bodies 2 → 1\n"), "{said}");
    let told = welded.told();
    assert_eq!((told.bodies, told.changes[0].delta.as_str()), ([2, 1], "worse"));
    assert!(told.words.ends_with("; bodies 2 → 1"), "{}", told.words);
    let schema = jsonschema::validator_for(&serde_json::from_str(json::SCHEMA_TEXT).unwrap()).unwrap();
    let mut value: serde_json::Value =
        serde_json::from_str(&json::write(&Report { baseline: Some(told), ..old.clone() })).unwrap();
    let faults: Vec<String> = schema.iter_errors(&value).map(|e| format!("{}: {e}", e.instance_path)).collect();
    assert!(faults.is_empty() && value["part"]["each_body"][1]["volume_mm3"] == 900.0, "{faults:?}");
    value["baseline"]["changes"][0]["delta"] = "perhaps".into();
    assert!(!schema.is_valid(&value));
    let new = jointed(&[block]);
    assert!(markdown::write(&new, Some(&welded)).contains("Bodies 2 → 1"));
    let cases = junit::write(&new, &[State::Fail], Some(&welded));
    assert!(cases.contains("failures=\"1\"") && cases.contains("<failure message=\"worse: 0.45 mm"), "{cases}");
    let results = alerts(&new, "a.stl", Some(&welded))["runs"][0]["results"].as_array().unwrap().clone();
    assert_eq!((&results[0]["level"], &results[0]["baselineState"]), (&"error".into(), &"updated".into()));
    let removed = became(11_000.0);
    assert_eq!(
        (removed.count(Delta::Fixed), removed.worst_news() == Some(State::Fail), removed.bodies),
        (1, false, [2, 1])
    );
    // A report that lists no bodies does not tell which it was.
    let mut unlisted = old.clone();
    unlisted.part.each_body.clear();
    assert_eq!(compare(&unlisted, &jointed(&[block])).count(Delta::Unchecked), 1);
}

#[test]
fn sarif_has_what_lists_of_alerts_ask_for() {
    let document = alerts(&sample::report("my part.stl"), "models/my part.stl", None);
    let run = &document["runs"][0];
    assert_eq!((&document["version"], &run["tool"]["driver"]["name"]), (&"2.1.0".into(), &"amcheck".into()));
    let results = run["results"].as_array().unwrap();
    assert_eq!(results.len(), 5);
    for r in results {
        let rule = r["ruleIndex"].as_u64().unwrap() as usize;
        assert_eq!(run["tool"]["driver"]["rules"][rule]["id"], r["ruleId"]);
        assert_eq!(r["locations"][0]["physicalLocation"]["region"]["startLine"], 1);
        assert_eq!(r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"], "models/my%20part.stl");
        assert!(r["partialFingerprints"]["amcheck/v1"].as_str().is_some_and(|f| !f.is_empty()));
        assert!(["error", "warning", "note"].contains(&r["level"].as_str().unwrap()));
    }
}

#[test]
fn the_badge_says_the_verdict() {
    let text = badge::write(&sample::report("a.stl"));
    assert!(text.contains("2 fail") && text.contains("#a40e3a"));
    assert!(badge::not_judged().contains("amcheck: not judged"));
}
