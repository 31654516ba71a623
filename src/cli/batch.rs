//! `amcheck batch` and `amcheck merge`: many parts, one table.

use super::args::Batch;
use super::asked::options;
use super::fail_on::FailOn;
use super::judge::{self, FORMATS, print_all};
use super::named::Named;
use super::record::Record;
use super::refusal;
use super::stdout::put;
use super::words::{one_of, usage};
use crate::analyze::{Options, prepare, run};
use crate::batch::{
    Earlier, Entry, Finished, PARTS, Row, Shard, Store, Work, entries, json_lines, line, merge, names_key,
    remove_outdated, worst_code, write_tables,
};
use crate::error::{Error, Result};
use crate::io::{Salvage, read};
use crate::memory::Allowance;
use crate::notice::number_of;
use crate::report::Exhibited;
use crate::report::render::thumbnail;
use crate::units::short;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Columns of the table where the terminal does not say.
const WIDTH: usize = 160;

/// The parts but what runs left beside their reports in the folders that were named: a mended or a turned copy is no part of its own, unless it is
/// named itself.
fn without_products(mut parts: Vec<Entry>, named: &[PathBuf]) -> Result<Vec<Entry>> {
    let folders: Vec<&PathBuf> = named.iter().filter(|o| o.is_dir()).collect();
    let was_found = |p: &Path| !named.iter().any(|o| o == p) && folders.iter().any(|o| p.starts_with(o));
    parts.retain(|p| !was_found(&p.path) || !is_product(&p.path));
    if parts.is_empty() {
        return Err(Error::NoGeometry {
            problem: "there is no part but what runs left beside their reports".into(),
            remedy: "name a folder with STL, OBJ, PLY or 3MF files, or such a file itself".into(),
        });
    }
    Ok(parts)
}

/// Whether a run wrote a file, as it stands.
fn is_product(path: &Path) -> bool {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(|n| n.to_str())) else { return false };
    let (record, is_named) = (Record::of(folder), |of: &Record| of.names().any(|n| n == name));
    // Digests are made of folders that list it alone.
    is_named(&record) && is_named(&record.standing(folder))
}

/// Judges all parts, prints a line for each as soon as it is known, and returns the closing lines and the worst exit code.
pub fn batch(b: &Batch) -> Result<(String, u8)> {
    let start = Instant::now();
    let how = How::of(b)?;
    let shard = b.shard.as_deref().map(Shard::parse).transpose()?;
    judge::threads(&b.how)?;
    let jobs = match b.jobs {
        Some(0) => return Err(usage("--jobs 0", "work on at least one part at a time, or leave the option out")),
        Some(n) => n,
        None => rayon::current_num_threads() / 4,
    };
    let mut parts = without_products(entries(&b.parts)?, &b.parts)?;
    let (all, among) = (parts.len(), shard.map(|_| names_key(&parts)));
    parts.retain(|p| shard.is_none_or(|s| s.takes(&p.name)));
    let store = Store::open(&b.out)?;
    let work = Work {
        content: &|entry| how.options.memory.file(&entry.path),
        judge: &|entry, bytes| how.judge(entry, bytes),
        refused: &|entry, error| refusal::files(&how.formats, &Named::in_batch(entry), error).into_contents(),
        named: &|entry| how.named(entry),
        settings: how.settings(),
        among,
        jobs: jobs.max(1),
        earlier: if b.fresh { Earlier::Replace } else { Earlier::Keep },
    };
    let mut told = Ok(());
    if !b.json && !b.quiet {
        told = put(&format!("{:>4} {:>7} {:>6}  {:<40} result\n", "code", "seconds", "MiB", "part"));
    }
    // What cannot be told does not stop the work: the tables are written all the same.
    let rows = crate::batch::run(&parts, &store, &work, |row| match (b.json, b.quiet) {
        _ if told.is_err() => {}
        (true, _) => told = put(&json_lines(std::slice::from_ref(row))),
        (_, false) => told = put(&(line(row, WIDTH) + "\n")),
        _ => {}
    });
    remove_outdated(store.out(), shard)?;
    let places = write_tables(store.out(), shard, &rows)?;
    told?;
    let code = worst_code(rows.iter().map(|r| r.code));
    if b.json {
        return Ok((String::new(), code));
    }
    let share = shard.map_or(String::new(), |s| format!(" (share {} of {} of {all})", s.index, s.count));
    let head = format!(
        "{}{share} in {:.1} s: {}\n",
        number_of(rows.len() as u64, PARTS),
        start.elapsed().as_secs_f64(),
        counted(&rows)
    );
    Ok((head + &listed(&places), code))
}

/// Joins tables; a missing share counts as a part that could not be read.
pub fn merge_tables(folders: &[PathBuf], out: Option<&Path>) -> Result<(String, u8)> {
    let out = out.or(folders.first().map(PathBuf::as_path)).unwrap_or(Path::new("."));
    let merged = merge(folders, out)?;
    let store = Store::open(out)?;
    let places = write_tables(store.out(), None, &merged.rows)?;
    let mut text = format!("{}: {}\n", number_of(merged.rows.len() as u64, PARTS), counted(&merged.rows));
    for (index, count) in &merged.missing {
        text.push_str(&format!("note: share {index} of {count} has no table; its parts are missing\n"));
    }
    for note in &merged.notes {
        text.push_str(&format!("note: {note}\n"));
    }
    let missing = merged.missing.first().map(|_| 4);
    let code = worst_code(merged.rows.iter().map(|r| r.code).chain(missing));
    Ok((text + &listed(&places), code))
}

/// How each part is judged.
struct How<'a> {
    options: Options,
    formats: Vec<&'a str>,
    fail_on: FailOn,
    salvage: Salvage,
}

impl How<'_> {
    fn of(b: &Batch) -> Result<How<'static>> {
        let fail_on = FailOn::named(&b.how.fail_on)?;
        if fail_on.is_of_news() {
            let problem = format!("--fail-on {} needs a baseline for each part", b.how.fail_on);
            return Err(usage(&problem, "compare parts one by one, or use fail, warn"));
        }
        let mut options = options(&b.how)?;
        if options.exhibited == Exhibited::Nothing {
            // The index shows a thumbnail of each part.
            options.exhibited = Exhibited::Part;
        }
        Ok(How {
            options,
            formats: one_of("format", &b.how.format, FORMATS)?,
            fail_on,
            salvage: if b.how.salvage { Salvage::KeepWhole } else { Salvage::Refuse },
        })
    }

    /// Everything that a result depends on; what the machine allows decides only whether there is one.
    fn settings(&self) -> String {
        let memory = Allowance { ceiling: None, ..self.options.memory.clone() };
        let options = Options { memory, ..self.options.clone() };
        format!("{options:?} {:?} {:?} {:?}", self.formats, self.fail_on, self.salvage)
    }

    /// What of a part's place its result names: alerts are found from the folder that the batch ran in, lists of tests and tables tell parts by their
    /// places in the batch, all else knows the file's name.
    fn named(&self, entry: &Entry) -> String {
        let named = Named::in_batch(entry);
        let asked = |formats: &[&str]| formats.iter().any(|f| self.formats.contains(f));
        let file = entry.path.file_name().unwrap_or_default().to_string_lossy();
        let name = if asked(&["junit", "markdown"]) { named.name.as_str() } else { "" };
        let place = if asked(&["sarif"]) { named.file.to_string_lossy() } else { "".into() };
        [&file, name, &place].join("\0")
    }

    fn judge(&self, entry: &Entry, bytes: &[u8]) -> Result<Finished> {
        let name = entry.path.to_string_lossy();
        self.options.memory.admit_content(bytes)?;
        let loaded = read(&name, bytes, self.salvage)?;
        let prepared = prepare(&name, bytes, loaded, &self.options)?;
        let (analysis, files) = judge::on_threads(judge::threads_for(&prepared, &self.options), || {
            let mut analysis = run(prepared, &self.options)?;
            let mut files = print_all(&mut analysis, &self.formats, None, (&Named::in_batch(entry), self.fail_on));
            files.push("picture", "thumbnail.png", thumbnail(&analysis.report, &analysis.exhibit).png);
            Ok((analysis, files))
        })??;
        let code = self.fail_on.exit_code(&analysis.report, None);
        Ok(Finished { report: analysis.report, code, files: files.into_contents() })
    }
}

/// How many parts ended with each code, worst first, and what they took together.
fn counted(rows: &[Row]) -> String {
    let words = [
        (70, ["broke down"; 2]),
        (6, ["not written"; 2]),
        (5, ["too large"; 2]),
        (4, ["refused"; 2]),
        (1, ["fails", "fail"]),
        (3, ["undecided"; 2]),
        (0, ["does not fail", "do not fail"]),
    ];
    let mut parts: Vec<String> = words
        .iter()
        .map(|(code, words)| (rows.iter().filter(|r| r.code == *code).count() as u64, *words))
        .filter(|(n, _)| *n > 0)
        .map(|(n, words)| number_of(n, words))
        .collect();
    let kept = rows.iter().filter(|r| r.reused).count();
    if kept > 0 {
        parts.push(format!("{kept} kept from earlier runs"));
    }
    let peak = rows.iter().filter_map(|r| r.peak_mib).fold(0.0, f64::max);
    if peak > 0.0 {
        parts.push(format!("at most {} MiB", short(peak.round())));
    }
    parts.join(", ")
}

fn listed(places: &[PathBuf]) -> String {
    let shown = |p: &PathBuf| format!("table   {}\n", crate::error::printable(&p.to_string_lossy()));
    places.iter().map(shown).collect()
}
