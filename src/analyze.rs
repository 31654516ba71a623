//! The one pipeline: mesh, process and options in; report and exhibit out.

use crate::access::{Question, orientations};
use crate::check::registry::{CHECKS, all_known, idle_limits, left_out};
use crate::check::{Acceptance, Check, Context, Measured, Outcome, State, setup_samples};
use crate::error::Result;
pub use crate::geometry::health::Repair;
use crate::geometry::health::repaired;
use crate::geometry::vector::sub;
use crate::geometry::{TriangleMesh, health};
use crate::grid::{Fitting, Grid};
use crate::io::Loaded;
use crate::memory::{Allowance, Demand};
use crate::notice::Notice;
use crate::part::{Part, Up};
use crate::process::{Date, Dimension, Process, rule};
use crate::report::conclusion::{sentence, verdict_of};
use crate::report::mount::{Wanted, mount};
use crate::report::stances::stances as stances_of;
use crate::report::thickness::{thickness, thickness_bytes};
use crate::report::{
    CheckReport, Exhibit, Exhibited, GridReport, LimitReport, PartReport, ProcessReport, RefinedReport, Report, SCHEMA,
    Tool, WorstReport,
};
use crate::units::{Length, report_digits, unit_name};
use sha2::{Digest, Sha256};
use std::time::Instant;

/// Bytes that the default grid may take, whatever memory the machine has: the same part gets the same grid everywhere.
pub const DEFAULT_GRID_BYTES: u128 = 1 << 30;

/// What is asked of a part.
#[derive(Debug, Clone)]
pub struct Options {
    pub process: Process,
    /// Direction of the file that points up; `None` for the best of `amcheck orient`.
    pub up: Option<Up>,
    /// Unit of the file's numbers and its millimetres, where the user says so.
    pub units: Option<(String, f64)>,
    pub repair: Repair,
    /// Spacing, where the user gives one.
    pub voxel: Option<Length>,
    /// Budget for deciding what is open, in samples.
    pub refine: u64,
    /// What judging may take.
    pub memory: Allowance,
    /// Names of the checks to run; empty for all.
    pub only: Vec<String>,
    /// Names of the checks to leave out.
    pub skip: Vec<String>,
    /// What the page and the pictures show.
    pub exhibited: Exhibited,
    /// The widest gap of interest, if local thickness is to be mapped as well.
    pub thickness: Option<Length>,
    /// The day, for acceptances that end; without it those count as ended.
    pub today: Option<Date>,
    /// Shift of the sampling lattice in units of the spacing, for tests.
    pub phase: [f64; 3],
}

impl Options {
    /// The defaults for a process.
    pub fn new(process: Process) -> Self {
        Options {
            process,
            up: Some(Up::PlusZ),
            units: None,
            repair: Repair::Leave,
            voxel: None,
            refine: 64_000_000,
            memory: Allowance { bytes: 4 << 30, ceiling: None },
            only: Vec::new(),
            skip: Vec::new(),
            exhibited: Exhibited::Part,
            thickness: None,
            today: None,
            phase: [0.0; 3],
        }
    }

    /// What judging takes for each triangle and each sample.
    pub fn demand(&self) -> Demand {
        Demand::of(&self.process, &self.only, &self.skip)
    }
}

/// A report, what its pictures need, and how long each stage took.
pub struct Analysis {
    pub report: Report,
    pub exhibit: Exhibit,
    /// The mended mesh, millimetres in the frame of the file; none where nothing was to be mended.
    pub mended: Option<TriangleMesh>,
    /// Stage and seconds; apart from the report, which is the same on every machine.
    pub timings: Vec<(String, f64)>,
}

/// A part that has been read, posed and measured, before any field is made.
pub struct Prepared {
    part: Part,
    fitting: Fitting,
    demand: Demand,
    file: String,
    sha256: String,
    units: (String, &'static str),
    notices: Vec<Notice>,
    mended: Option<TriangleMesh>,
    timings: Vec<(String, f64)>,
}

impl Prepared {
    /// What is said of the file and of the grid.
    pub fn notices(&self) -> &[Notice] {
        &self.notices
    }

    /// What the grid will take.
    pub fn fitting(&self) -> Fitting {
        self.fitting
    }

    /// What judging takes for each triangle and each sample.
    pub fn demand(&self) -> Demand {
        self.demand
    }

    /// The part.
    pub fn part(&self) -> &Part {
        &self.part
    }
}

/// Reads units, poses the part and chooses the grid; nothing large is allocated.
///
/// # Errors
/// [`crate::Error::TooLarge`] if the triangles or an explicit spacing need more memory than allowed, with the spacing that
/// fits; as [`all_known`] for the names of `only` and `skip`, [`Allowance::admit_spacing`] and [`Part::new`].
pub fn prepare(file: &str, bytes: &[u8], loaded: Loaded, options: &Options) -> Result<Prepared> {
    let start = Instant::now();
    all_known(&options.only, &options.skip)?;
    let (units, scale) = match (&options.units, loaded.unit_mm) {
        (Some((name, mm)), _) => ((name.clone(), "option"), *mm),
        (None, Some(mm)) => ((unit_name(mm), "file"), mm),
        (None, None) => (("mm".to_string(), "assumed"), 1.0),
    };
    admit_mesh(&loaded.mesh, scale, options)?;
    let overruled = loaded.overruled_by(options.units.as_ref().map(|(_, mm)| *mm));
    let mesh = if scale == 1.0 { loaded.mesh } else { loaded.mesh.scaled(scale) };
    let repaired = (options.repair == Repair::Mend).then(|| repaired(&mesh, health::repair_tolerance(&mesh)));
    let mut notices = repaired.as_ref().map_or(Vec::new(), |r| r.said());
    let mended = repaired.map(|r| r.mesh).filter(|m| *m != mesh);
    let mesh = mended.clone().unwrap_or(mesh);
    let largest = mesh.bounds().map_or(0.0, |(lo, hi)| lo.iter().chain(&hi).fold(0.0f64, |m, x| m.max(x.abs())));
    let step = largest * loaded.relative_step;
    let up = options.up.map_or_else(|| best_up(mesh.clone(), step, &options.process), Ok)?;
    let part = Part::new(mesh, up, step, 1.25 * options.process.widest_gap_mm())?;
    let (fitting, demand, coarsened) = choose_spacing(&part, options)?;
    notices.extend(coarsened);
    notices.extend(loaded.notices.into_iter().chain(overruled));
    notices.extend(idle_limits(&options.process, &options.only, &options.skip));
    if units.1 == "assumed" {
        notices.push(Notice::units_assumed(loaded.format));
    }
    let is_said = options.units.is_some() || scale != 1.0;
    notices.extend(part.health_as_read().units_guess().filter(|_| !is_said));
    let mut prepared = Prepared {
        part,
        fitting,
        demand,
        file: std::path::Path::new(file).file_name().map_or_else(|| file.into(), |n| n.to_string_lossy().into_owned()),
        sha256: Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect(),
        units,
        notices,
        mended,
        timings: Vec::new(),
    };
    prepared.timings.push(("prepare".into(), start.elapsed().as_secs_f64()));
    Ok(prepared)
}

/// Refuses a mesh with more triangles than there is memory for. What is told to fit counts what the tools' setups take of its box, too.
fn admit_mesh(mesh: &TriangleMesh, scale: f64, options: &Options) -> Result<()> {
    let (demand, triangles) = (options.demand(), mesh.triangles.len() as u64);
    let Err(refused) = options.memory.admit_triangles(&demand, triangles) else { return Ok(()) };
    let extent = mesh.bounds().map_or([0.0; 3], |(lo, hi)| sub(hi, lo).map(|c| c * scale));
    let whole = demand.with_setups(setup_samples(&options.process, extent)?);
    options.memory.admit_triangles(&whole, triangles)?;
    Err(refused)
}

/// A stage of a run that begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stage {
    /// What it does: `cast`, the name of a check, `thickness`, `mount`; `prepare` and `print` stand before and after.
    pub name: String,
    /// Its number from 0, and the names of all.
    pub at: usize,
    pub names: Vec<String>,
}

impl Stage {
    /// All stages of a run with these options, in order.
    pub fn of(options: &Options) -> Vec<Stage> {
        let checks = CHECKS.iter().map(|c| c.meta().name);
        let mapped = options.thickness.map(|_| "thickness");
        let names = ["prepare", "cast"].into_iter().chain(checks).chain(mapped).chain(["mount", "print"]);
        let names: Vec<String> = names.map(String::from).collect();
        names.iter().enumerate().map(|(at, name)| Stage { name: name.clone(), at, names: names.clone() }).collect()
    }
}

/// Runs the checks and mounts the exhibit.
///
/// # Errors
/// What keeps the part from being cast at all; a check that breaks down is reported as such and does not stop the others.
pub fn run(prepared: Prepared, options: &Options) -> Result<Analysis> {
    run_told(prepared, options, &|_| ())
}

/// As [`run`]; `told` hears the name of each stage as it begins.
///
/// # Errors
/// As [`run`].
pub fn run_told(mut prepared: Prepared, options: &Options, told: &dyn Fn(&str)) -> Result<Analysis> {
    let mut timings = std::mem::take(&mut prepared.timings);
    let mut clock = Instant::now();
    let mut lap = |name: &str| {
        timings.push((name.to_string(), clock.elapsed().as_secs_f64()));
        clock = Instant::now();
    };
    told("cast");
    let grid = Grid::covering([0.0; 3], prepared.part.extent(), prepared.fitting.spacing, 1, options.phase)?;
    prepared.part.cast_on(grid);
    prepared.part.solid()?;
    lap("cast");
    let part = &prepared.part;
    let context = Context { refine: options.refine, spacing_mm: grid.h() };
    let mut checks = Vec::new();
    let mut wanted: Vec<Wanted> = Vec::new();
    let mut shapes = Vec::new();
    let mut notices = prepared.notices.clone();
    notices.extend(part.notices());
    let mut spent = 0;
    let mut acceptance = Acceptance::new(&options.process.accept, options.today)?;
    let mut stances = None;
    // Ways to stand rest on the mesh alone: they are compared where a check leaves a core idle.
    rayon::in_place_scope(|beside| {
        if let Exhibited::Stances(count) = &options.exhibited {
            beside.spawn(|_| stances = stances_of(part, &options.process, *count));
        }
        CHECKS.iter().try_for_each(|check| {
            told(check.meta().name);
            let (report, measured) = judge(*check, part, options, &context, &mut acceptance)?;
            if let Some(m) = measured {
                spent += m.budget.map_or(0, |b| b.spent);
                notices.extend(m.notices);
                shapes.extend(m.shapes);
                wanted.extend(m.map.map(|map| (report.name.clone(), map)));
            }
            lap(&report.name);
            checks.push(report);
            Ok(())
        })
    })?;
    let mapped = options.thickness.map(|widest| {
        told("thickness");
        let maps = thickness(part, &options.process, finest(options, Length::mm(grid.h())), widest);
        lap("thickness");
        maps
    });
    let (thickness, maps) = mapped.transpose()?.unzip();
    wanted.extend(maps.into_iter().flatten());
    notices.extend(part.doubt());
    notices.extend(acceptance.notices());
    let verdict = verdict_of(&checks);
    let mut report = Report {
        schema: SCHEMA.into(),
        tool: Tool { name: "amcheck".into(), version: env!("CARGO_PKG_VERSION").into() },
        verdict,
        summary: String::new(),
        part: PartReport::of(part, (&prepared.file, &prepared.sha256), (&prepared.units.0, prepared.units.1))?,
        process: ProcessReport::of(&options.process),
        grid: GridReport {
            spacing_mm: report_digits(grid.h()),
            dims: grid.dims().map(|n| n as u64),
            samples: grid.samples() as u64,
            memory_bytes: u64::try_from(prepared.fitting.bytes).unwrap_or(u64::MAX),
            refined: spent,
            refine_budget: options.refine,
        },
        checks,
        thickness,
        warnings: notices,
        baseline: None,
    };
    report.summary = sentence(&report);
    lap("judge");
    told("mount");
    let exhibit = Exhibit { stances, ..mount(options.exhibited, part, &report, (&wanted, shapes)) };
    lap("mount");
    Ok(Analysis { report, exhibit, mended: prepared.mended, timings })
}

/// The least spacing at which local thickness is mapped beside a grid: the user's, else a quarter of the grid's.
fn finest(options: &Options, grid: Length) -> Length {
    options.voxel.unwrap_or(grid * 0.25)
}

/// The best orientation of a mesh for a process.
fn best_up(mesh: TriangleMesh, step: f64, process: &Process) -> Result<Up> {
    let part = Part::new(mesh, Up::PlusZ, step, 0.0)?;
    let question = Question::of(process, part.step());
    let best = orientations(part.mesh(), &part, &question)?;
    Ok(best.list.first().map_or(Up::PlusZ, |o| Up::Along(o.up)))
}

/// The grid, what judging on it takes, and what is to be said of its spacing.
fn choose_spacing(part: &Part, options: &Options) -> Result<(Fitting, Demand, Option<Notice>)> {
    let smallest = options
        .process
        .limits
        .iter()
        .filter(|(key, _)| rule(key).is_ok_and(|r| r.dimension == Dimension::Length))
        .flat_map(|(_, l)| [l.fail, l.warn].into_iter().flatten())
        .filter(|x| *x > 0.0 && x.is_finite())
        .min_by(f64::total_cmp)
        .map(Length::mm);
    let triangles = part.mesh().triangles.len() as u64;
    let default = Fitting::default_for(part.extent(), smallest, DEFAULT_GRID_BYTES)?.spacing;
    let mapped =
        options.thickness.map(|widest| thickness_bytes(part.extent(), finest(options, default), widest)).transpose()?;
    let demand = options.demand().with_setups(setup_samples(&options.process, part.extent())?);
    let demand = demand.with_maps(mapped.unwrap_or(0));
    options.memory.admit_triangles(&demand, triangles)?;
    let (spacing, coarsened) = match options.voxel {
        Some(spacing) => (spacing, None),
        None => options.memory.spacing(&demand, part.extent(), default, triangles)?,
    };
    Ok((options.memory.admit_spacing(&demand, part.extent(), spacing, triangles)?, demand, coarsened))
}

/// One check's line of the report, and what it measured; an error if what the user asked of it cannot be.
fn judge(
    check: &dyn Check,
    part: &Part,
    options: &Options,
    context: &Context,
    acceptance: &mut Acceptance,
) -> Result<(CheckReport, Option<Measured>)> {
    let meta = check.meta();
    let mut report = CheckReport {
        code: meta.code.into(),
        name: meta.name.into(),
        title: meta.title.into(),
        state: State::NotRun,
        why: None,
        worst: None,
        limit: None,
        cover: None,
        refined: None,
        findings: Vec::new(),
    };
    if let Some(why) = left_out(meta, &options.only, &options.skip) {
        report.why = Some(why.into());
        return Ok((report, None));
    }
    Ok(match check.run(part, &options.process, context) {
        // What the user asked for cannot be: that is no matter of one check.
        Err(e) if e.exit_code() == 2 => return Err(e),
        Err(e) => {
            report.state = State::Error;
            report.why = Some(e.to_string());
            (report, None)
        }
        Ok(Outcome::NotApplicable(why)) => {
            report.state = State::NotApplicable;
            report.why = Some(why);
            (report, None)
        }
        Ok(Outcome::Measured(mut m)) => {
            crate::check::name_apart(&mut m.findings);
            acceptance.apply(meta, &mut m.findings);
            let counting = m.findings.iter().filter(|f| f.counts());
            report.state = counting.map(|f| f.state).max().unwrap_or(State::Pass);
            report.worst = m.worst.as_ref().map(|w| {
                let b = w.bracket.rounded();
                let at_mm = w.at.map(|p| part.to_file(p).map(report_digits));
                WorstReport { value: b.value, low: b.low, high: b.high, unit: w.unit.into(), at_mm }
            });
            report.limit = m.rule.and_then(|key| LimitReport::of(&options.process, key));
            report.cover = Some(std::mem::take(&mut m.cover));
            report.refined = m.budget.map(RefinedReport::from);
            report.findings = std::mem::take(&mut m.findings);
            report.findings.sort_by(crate::check::Finding::worst_first);
            report.told_by_worst(&options.process);
            (report, Some(*m))
        }
    })
}
