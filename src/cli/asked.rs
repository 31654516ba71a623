//! What is asked of a part: from words to options.

use super::args::Judging;
use super::words::{LOOKS, allowance, length, units, up, usage};
use crate::analyze::{Options, Repair};
use crate::check::registry;
use crate::error::{Error, Result, printable};
use crate::process::{BUILTIN, Date, Process, Waiver, waivers};
use crate::report::Exhibited;
use crate::report::stances::COMPARED;
use std::collections::BTreeMap;
use std::path::Path;

/// The options that the words of a command line ask for.
///
/// # Errors
/// Those of the word that makes no sense.
pub(super) fn options(a: &Judging) -> Result<Options> {
    let mut process = process(&a.process)?;
    limit(&mut process, &a.limits)?;
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
    any_finishing(a, &process)?;
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
    o.refine = u64::try_from(LOOKS.parse(&a.refine)?).unwrap_or(u64::MAX);
    o.memory = memory;
    any_check(a)?;
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

/// Puts limits in place, each key once.
fn limit(process: &mut Process, limits: &[String]) -> Result<()> {
    let mut given: BTreeMap<String, &str> = BTreeMap::new();
    for limit in limits {
        let named = registry::named(limit);
        process.override_limit(&named)?;
        let key = named.split('=').next().unwrap_or_default().trim().to_string();
        if let Some(first) = given.insert(key.clone(), limit) {
            let problem = format!("limit {key} is given twice: {} and {}", printable(first), printable(limit));
            return Err(usage(&problem, "keep one of them; fail and warn stand in one: --limit thin-wall=0.4mm,0.6mm"));
        }
    }
    Ok(())
}

/// Refuses to say how surfaces are finished where nothing finishes them.
fn any_finishing(a: &Judging, process: &Process) -> Result<()> {
    let given =
        [("--tool-from", a.tool_from.first()), ("--tool-tilt", a.tool_tilt.as_ref()), ("--faces", a.faces.first())];
    match given.into_iter().find_map(|(option, value)| Some((option, value?))) {
        Some((option, value)) if process.tools.finishing.is_empty() => {
            let process = printable(&process.name);
            let problem =
                format!("{option} {} is about finishing tools, and the process {process} has none", printable(value));
            Err(usage(&problem, "name a tool: --tool end-mill-3; `amcheck tools` lists them"))
        }
        _ => Ok(()),
    }
}

/// Refuses lists that leave nothing to judge.
fn any_check(a: &Judging) -> Result<()> {
    registry::all_known(&a.only, &a.skip)?;
    if registry::metas().any(|m| registry::left_out(m, &a.only, &a.skip).is_none()) {
        return Ok(());
    }
    let list = |option: &str, names: &[String]| match names.is_empty() {
        true => String::new(),
        false => format!("{option} {} ", printable(&names.join(","))),
    };
    let problem = format!("{}{}leaves no check to run", list("--only", &a.only), list("--skip", &a.skip));
    Err(usage(&problem, "take a name out of --skip, or add one to --only"))
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
