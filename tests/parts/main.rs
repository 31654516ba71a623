//! Parts with known truths, judged by the whole pipeline.

mod as_printed;
mod exhibit;
mod false_alarms;
mod fixtures;
mod golden;
mod holes;
mod judged;
mod judged_fields;
mod ledges;
mod lost;
mod metamorphic;
mod models;
mod same_answer;
mod shapes;
mod sheets;
mod table;
mod tools;
mod voids;

use amcheck::analyze::{Options, prepare, run};
use amcheck::check::Finding;
use amcheck::geometry::TriangleMesh;
use amcheck::io::{Loaded, Salvage, read};
use amcheck::process::Process;
use amcheck::report::Report;

/// A process with limits as on the command line.
fn process(name: &str, limits: &[&str]) -> Process {
    let mut process = Process::named(name).expect("built in");
    limits.iter().for_each(|l| process.override_limit(l).expect("a limit"));
    process
}

/// The report of a file's bytes.
fn judge_bytes(name: &str, bytes: &[u8], options: &Options) -> amcheck::Result<Report> {
    let loaded = read(name, bytes, Salvage::Refuse)?;
    Ok(run(prepare(name, bytes, loaded, options)?, options)?.report)
}

/// The report of a mesh, through the same door as a file of double precision.
fn judge_mesh(mesh: TriangleMesh, options: &Options) -> Report {
    let loaded = Loaded { mesh, format: "mesh", unit_mm: Some(1.0), notices: Vec::new(), relative_step: f64::EPSILON };
    let prepared = prepare("mesh", b"", loaded, options).expect("a part");
    run(prepared, options).expect("a report").report
}

/// Findings of one check, by its code.
fn findings<'r>(report: &'r Report, code: &str) -> &'r [Finding] {
    &report.checks.iter().find(|c| c.code == code).expect("in the registry").findings
}
