//! What is asked of a part: from words to options.

use super::args::Judging;
use super::words::{allowance, count, length, units, up};
use crate::analyze::{Options, Repair};
use crate::check::registry;
use crate::error::{Error, Result, printable};
use crate::process::{BUILTIN, Date, Process, Waiver, waivers};
use crate::report::Exhibited;
use crate::report::stances::COMPARED;
use std::path::Path;

/// The options that the words of a command line ask for.
///
/// # Errors
/// Those of the word that makes no sense.
pub(super) fn options(a: &Judging) -> Result<Options> {
    let mut process = process(&a.process)?;
    for limit in &a.limits {
        process.override_limit(&registry::named(limit))?;
    }
    for file in &a.accept {
        process.accept.extend(accepted(file)?);
    }
    for waiver in &process.accept {
        registry::find(&waiver.check).map_err(|e| waiver.refused(&e))?;
    }
    let today = today(a, &process)?;
    let memory = allowance(&a.memory)?;
    if !a.tools.is_empty() {
        process.tools = process.tools.replaced(super::tools::chosen(&a.tools, &memory)?);
    }
    for (key, given) in [("from", &a.tool_from), ("faces", &a.faces)] {
        if !given.is_empty() {
            process.tools.finish.set(key, &given.iter().map(String::as_str).collect::<Vec<_>>())?;
        }
    }
    if let Some(angle) = &a.tool_tilt {
        process.tools.finish.set("tilt", &[angle])?;
    }
    let mut o = Options::new(process);
    o.today = today;
    o.up = up(&a.up)?;
    o.units = a.units.as_deref().map(units).transpose()?;
    o.voxel = a.voxel.as_deref().map(|text| length("--voxel", text)).transpose()?;
    o.thickness = a.thickness.as_deref().map(|text| length("--thickness", text)).transpose()?;
    o.refine =
        u64::try_from(count(&a.refine, &[("k", 1_000), ("M", 1_000_000), ("G", 1_000_000_000)])?).unwrap_or(u64::MAX);
    o.memory = memory;
    registry::all_known(&a.only, &a.skip)?;
    let asked = |formats: &[&str]| a.format.iter().any(|f| formats.contains(&f.as_str()));
    o.exhibited = match (asked(&["html"]), asked(&["png", "glb"])) {
        (true, _) => Exhibited::Stances(COMPARED),
        (false, true) => Exhibited::Part,
        (false, false) => Exhibited::Nothing,
    };
    o.repair = if a.repair { Repair::Mend } else { Repair::Leave };
    o.only = a.only.clone();
    o.skip = a.skip.clone();
    Ok(o)
}

pub(super) fn process(name: &str) -> Result<Process> {
    if BUILTIN.iter().any(|(n, _)| *n == name) || !(name.ends_with(".toml") || Path::new(name).exists()) {
        return Process::named(name);
    }
    let text = std::fs::read_to_string(name).map_err(|e| Error::Profile {
        file: printable(name),
        place: Default::default(),
        problem: e.to_string(),
        remedy: "name a readable TOML file, or a built-in process: see `amcheck processes`".into(),
    })?;
    Process::from_toml(name, &text)
}

/// The entries of a file of acceptances.
fn accepted(file: &Path) -> Result<Vec<Waiver>> {
    let shown = file.to_string_lossy();
    let text = std::fs::read_to_string(file).map_err(|e| Error::Profile {
        file: printable(&shown),
        place: Default::default(),
        problem: e.to_string(),
        remedy: "name a readable TOML file of [[accept]] entries".into(),
    })?;
    waivers(&shown, &text)
}

/// The day, as given or by the clock; the clock is asked only where an acceptance ends.
fn today(a: &Judging, process: &Process) -> Result<Option<Date>> {
    if let Some(day) = &a.today {
        return Date::parse(day).map(Some);
    }
    let asked = process.accept.iter().any(|w| w.until.is_some());
    let clock = || std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).ok();
    Ok(asked.then(clock).flatten().map(|since| Date::of_unix_seconds(since.as_secs())))
}
