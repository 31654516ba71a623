//! `amcheck PART`: from words to a written report.

use super::args::{Arguments, Judging};
use super::asked::options;
use super::complaint::{Answer, Complaint};
use super::deliver::{Delivery, Files, is_among};
use super::fail_on::FailOn;
use super::leftover;
use super::named::Named;
use super::progress::{Progress, Weights, Wished};
use super::record::{Record, Said};
use super::refusal;
use super::words::{one_of, usage};
use crate::analyze::{Analysis, Options, Prepared, Stage, prepare, run_told};
use crate::error::{Error, Result, printable};
use crate::io::{Loaded, Salvage, read, threemf};
use crate::report::baseline::{Comparison, compare};
use crate::report::terminal::{self, Outputs};
use crate::report::{PartReport, Report, SCHEMA, badge, glb, html, json, junit, markdown, render, sarif};
use std::borrow::Cow;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Formats a report can be written in.
pub(super) const FORMATS: &[&str] = &["json", "html", "png", "glb", "markdown", "junit", "sarif", "badge"];

/// A part that has been judged, its files written.
pub struct Judged {
    pub report: Report,
    comparison: Option<Comparison>,
    outputs: Outputs,
    fail_on: FailOn,
}

/// Judges a part and returns what goes to stdout and the exit code.
pub fn judge(a: &Arguments) -> Answer<(String, u8)> {
    let judged = judged(a)?;
    let code = judged.fail_on.exit_code(&judged.report, judged.comparison.as_ref());
    Ok((said(a, &judged), code))
}

/// Judges a part and writes its files; where the part itself is refused, those that say so.
pub fn judged(a: &Arguments) -> Answer<Judged> {
    let asked = Asked::of(a).map_err(|e| Complaint::about(a.part.as_deref(), e))?;
    asked.answered(a).map_err(|error| {
        let tell = || refusal::tell(&asked.folder, &asked.formats, &asked.part, &error);
        let left = if refusal::is_of_part(&error) { tell() } else { None };
        let note = left.map(|left| format!("{} is of an earlier run and says nothing of this file", left.display()));
        Complaint { note, ..Complaint::about(Some(&asked.part), error) }
    })
}

/// What is asked, understood before the part is looked at.
struct Asked {
    start: Instant,
    part: PathBuf,
    options: Options,
    fail_on: FailOn,
    formats: Vec<&'static str>,
    baseline: Option<Report>,
    folder: PathBuf,
}

impl Asked {
    fn of(a: &Arguments) -> Result<Self> {
        let start = Instant::now();
        let part = a.part.clone().ok_or_else(|| usage("no part was named", "amcheck part.stl"))?;
        if a.watch && part == Path::new("-") {
            return Err(usage("standard input cannot be watched", "name a file"));
        }
        let options = options(&a.how)?;
        let fail_on = FailOn::named(&a.how.fail_on)?;
        threads(&a.how)?;
        let formats = one_of("format", &a.how.format, FORMATS)?;
        let baseline = a.baseline.as_deref().map(read_report).transpose()?;
        if fail_on.is_of_news() && baseline.is_none() {
            let problem = format!("--fail-on {} has nothing to compare with", a.how.fail_on);
            return Err(usage(&problem, "add --baseline OLD.json"));
        }
        let folder = out_dir(a, &part);
        if let Some(old) = a.baseline.as_deref().filter(|_| formats.contains(&"json")) {
            spare_baseline(&folder.join("report.json"), old)?;
        }
        Ok(Asked { start, part, options, fail_on, formats, baseline, folder })
    }

    fn answered(&self, a: &Arguments) -> Result<Judged> {
        let Asked { part, options, fail_on, formats, folder, .. } = self;
        let delivery = Delivery::open(folder)?.saying(Said::Report, part);
        // A folder that was named is meant.
        let notes = match a.out {
            None => Record::of(folder).notes(folder, part, Said::Report),
            Some(_) => Vec::new(),
        };
        let progress = Progress::start(if a.quiet || a.json { Wished::No } else { Wished::Yes });
        let (weights, stages) = (Weights::of_last_run(folder), Stage::of(options));
        let told = |name: &str| stages.iter().filter(|s| s.name == name).for_each(|s| progress.stage(s, &weights));
        told("prepare");
        let (content, mesh) = loaded(a, part, options)?;
        let prepared = prepare(&part.to_string_lossy(), &content, mesh, options)?;
        drop(content);
        progress.note(&super::plan::need(&prepared, options));
        let threads = threads_for(&prepared, options);
        let (analysis, comparison, files) = on_threads(threads, || {
            let mut analysis = run_told(prepared, options, &told)?;
            told("print");
            let comparison = self.baseline.as_ref().map(|old| compare(old, &analysis.report));
            analysis.report.baseline = comparison.as_ref().map(Comparison::told);
            let files = print_all(&mut analysis, formats, comparison.as_ref(), (&Named::alone(part), *fail_on));
            Ok((analysis, comparison, files))
        })??;
        let names = files.names();
        let read: Vec<&Path> = [Some(part.as_path()), a.baseline.as_deref()].into_iter().flatten().collect();
        let mut written = delivery.deliver(files, &read)?;
        written.retain(|(what, _, _)| ["report", "data", "mended"].contains(&what.as_str()));
        let known = if a.how.repair { leftover::of_repairing } else { leftover::of_judging };
        leftover::remove(folder, &names, known, &read)?;
        drop(progress);
        let (part, seconds) = (part.to_string_lossy().into_owned(), Some(self.start.elapsed().as_secs_f64()));
        let outputs = Outputs { part, judged_by: judged_by(&a.how), written, notes, seconds };
        Ok(Judged { report: analysis.report, comparison, outputs, fail_on: *fail_on })
    }
}

/// Refuses to write a report in the place of the one that it is compared with: run again, it would be compared with itself, and nothing be new.
fn spare_baseline(report: &Path, baseline: &Path) -> Result<()> {
    if !is_among(report, &[baseline]) {
        return Ok(());
    }
    let (report, baseline) = (printable(&report.to_string_lossy()), printable(&baseline.to_string_lossy()));
    let problem = format!("the report would be written to {report}, over its own baseline {baseline}");
    Err(usage(&problem, "name another folder with --out, or keep a copy of the baseline elsewhere and name that"))
}

/// The options that say what a part is judged by, where they are not the usual ones.
fn judged_by(how: &Judging) -> Vec<String> {
    let one = |name: &str, value: &str, usual: &str| match value == usual {
        true => Vec::new(),
        false => vec![name.to_owned(), value.to_owned()],
    };
    let given = |name: &str, value: &Option<String>| value.iter().flat_map(|v| one(name, v, "")).collect();
    let paths = how.accept.iter().flat_map(|file| one("--accept", &file.to_string_lossy(), "")).collect();
    let every = |name: &'static str, all: &[String]| all.iter().flat_map(|v| one(name, v, "")).collect();
    let parts: [Vec<String>; 10] = [
        one("--process", &how.process, "fdm"),
        one("--up", &how.up, "+z"),
        given("--units", &how.units),
        given("--voxel", &how.voxel),
        every("--limit", &how.limits),
        paths,
        every("--tool", &how.tools),
        every("--tool-from", &how.tool_from),
        given("--tool-tilt", &how.tool_tilt),
        every("--faces", &how.faces),
    ];
    parts.concat()
}

/// The bytes of the part, and the mesh they hold.
pub(super) fn loaded(a: &Arguments, part: &Path, options: &Options) -> Result<(Vec<u8>, Loaded)> {
    let salvage = if a.how.salvage { Salvage::KeepWhole } else { Salvage::Refuse };
    let content = options.memory.content(part)?;
    let mesh = read(&part.to_string_lossy(), &content, salvage)?;
    Ok((content, mesh))
}

/// What goes to stdout.
pub fn said(a: &Arguments, judged: &Judged) -> String {
    let palette = super::command::palette(std::io::stdout().is_terminal());
    let report = &judged.report;
    if a.json {
        return json::write(report);
    }
    if a.quiet {
        return terminal::verdict_line(report, palette);
    }
    let text = terminal::summary(report, &judged.outputs, palette);
    match &judged.comparison {
        Some(c) => format!("{text}\n{}", crate::report::baseline::text(c, palette)),
        None => text,
    }
}

/// A report that was written before.
///
/// # Errors
/// [`Error::CannotRead`] or [`Error::Damaged`] naming the file; [`Error::Usage`] for a report of another major version.
pub fn read_report(path: &Path) -> Result<Report> {
    let shown = printable(&path.to_string_lossy());
    let text = std::fs::read_to_string(path).map_err(|e| Error::CannotRead {
        path: shown.clone(),
        reason: e.to_string(),
        remedy: "name the report.json of an earlier run".into(),
    })?;
    #[derive(serde::Deserialize)]
    struct Head {
        schema: String,
    }
    if let Ok(head) = serde_json::from_str::<Head>(&text)
        && head.schema != SCHEMA
    {
        let problem = format!("{shown} is of schema {}; this amcheck reads {SCHEMA}", printable(&head.schema));
        return Err(usage(&problem, "name a report.json that this major version of amcheck wrote"));
    }
    serde_json::from_str(&text).map_err(|e| Error::Damaged {
        format: "report",
        place: crate::error::Place::Line(e.line() as u64),
        problem: format!("{shown}: {e}"),
        remedy: "name a report.json that this major version of amcheck wrote".into(),
    })
}

/// `amcheck compare OLD NEW`: what became new, worse, better or was fixed; exit code 1 for a new or worse failure, 3 where the worst of what is new or
/// worse is undecided.
pub fn compare_reports(old: &Path, new: &Path) -> Result<(String, u8)> {
    let comparison = compare(&read_report(old)?, &read_report(new)?);
    let palette = super::command::palette(std::io::stdout().is_terminal());
    Ok((crate::report::baseline::text(&comparison, palette), FailOn::exit_code_of_comparison(&comparison)))
}

/// Every file of the report on a part of these names that is judged by what turns the exit code to 1.
pub(super) fn print_all(
    analysis: &mut Analysis,
    formats: &[&str],
    comparison: Option<&Comparison>,
    (named, fail_on): (&Named, FailOn),
) -> Files {
    let clock = Instant::now();
    let report = &analysis.report;
    let mut files = Files::default();
    let pictures = if formats.iter().any(|f| ["html", "png"].contains(f)) {
        render::pictures(report, &analysis.exhibit)
    } else {
        Vec::new()
    };
    if formats.contains(&"html") {
        files.push("report", "report.html", html::page(report, &analysis.exhibit, &pictures).into_bytes());
    }
    if formats.contains(&"json") {
        files.push("data", "report.json", json::write(report).into_bytes());
    }
    if formats.contains(&"png") {
        for p in pictures {
            files.push("picture", &format!("{}.png", p.name), p.png);
        }
    }
    if formats.contains(&"glb") {
        files.push("model", "report.glb", glb::write(&analysis.exhibit));
    }
    if let Some(mesh) = &analysis.mended {
        let mut bytes = Vec::new();
        // Writing to memory cannot fail.
        let _ = threemf::write(mesh, &mut bytes);
        files.push("mended", "repaired.3mf", bytes);
    }
    let told = report_as(report, &named.name);
    let since = comparison.filter(|_| fail_on.is_of_news());
    let texts: [(&str, &str, &dyn Fn() -> String); 4] = [
        ("markdown", "report.md", &|| markdown::write(&told, comparison)),
        ("junit", "report.junit.xml", &|| junit::write(&told, fail_on.failing(), since)),
        ("sarif", "report.sarif", &|| sarif::write(report, &named.file, comparison)),
        ("badge", "badge.svg", &|| badge::write(report)),
    ];
    for (format, name, write) in texts {
        if formats.contains(&format) {
            files.push(format, name, write().into_bytes());
        }
    }
    analysis.timings.push(("print".into(), clock.elapsed().as_secs_f64()));
    if formats.contains(&"json") {
        let laps: serde_json::Map<String, serde_json::Value> =
            analysis.timings.iter().map(|(k, v)| (k.clone(), serde_json::json!((v * 1e4).round() / 1e4))).collect();
        files.push("timings", "timings.json", format!("{:#}\n", serde_json::Value::Object(laps)).into_bytes());
    }
    files
}

/// The report, with its part under a name.
fn report_as<'r>(report: &'r Report, name: &str) -> Cow<'r, Report> {
    if report.part.file == name {
        return Cow::Borrowed(report);
    }
    let part = PartReport { file: name.into(), ..report.part.clone() };
    Cow::Owned(Report { part, ..report.clone() })
}

/// Threads at most: each takes memory of its own before it does anything.
const MOST_THREADS: usize = 1024;

/// Starts the pool, so that threads that cannot be had are refused in a sentence.
pub(super) fn threads(a: &Judging) -> Result<()> {
    let by_setting = || std::env::var("RAYON_NUM_THREADS").ok()?.parse().ok();
    let wanted = match a.threads {
        Some(0) => return Err(usage("--threads 0", "give at least one thread, or leave the option out")),
        Some(n) => n,
        None => by_setting().unwrap_or(0),
    };
    let remedy = "give about as many as the machine has processors with --threads";
    if wanted > MOST_THREADS {
        return Err(usage(&format!("{wanted} threads are more than {MOST_THREADS}"), remedy));
    }
    // A pool that exists already keeps its size; the answer is the same.
    match rayon::ThreadPoolBuilder::new().num_threads(wanted).build_global() {
        Err(e) if std::error::Error::source(&e).is_some() => {
            Err(usage(&format!("the threads cannot be started: {e}"), remedy))
        }
        _ => Ok(()),
    }
}

/// On how many threads a part can be judged with the memory that is allowed.
pub(super) fn threads_for(prepared: &Prepared, options: &Options) -> usize {
    options.memory.threads(prepared.fitting().bytes, prepared.part().mesh().triangles.len() as u64)
}

/// Does something on no more than so many threads.
///
/// # Errors
/// [`Error::Usage`] where they cannot be started.
pub(super) fn on_threads<T: Send>(most: usize, work: impl FnOnce() -> T + Send) -> Result<T> {
    if rayon::current_num_threads() <= most {
        return Ok(work());
    }
    let refused = |e| usage(&format!("{most} threads cannot be started: {e}"), "allow more memory");
    Ok(rayon::ThreadPoolBuilder::new().num_threads(most).build().map_err(refused)?.install(work))
}

fn out_dir(a: &Arguments, part: &Path) -> PathBuf {
    a.out.clone().unwrap_or_else(|| {
        let stem = part.file_stem().map_or_else(|| "part".into(), |s| s.to_os_string());
        let stem = if part == Path::new("-") { "stdin".into() } else { stem };
        Path::new("reports").join(stem)
    })
}
