//! `amcheck PART --plan`: what judging would take, before it is spent.

use super::args::Arguments;
use super::asked::options;
use super::judge::{loaded, threads, threads_for};
use super::words::usage;
use crate::analyze::{Options, Prepared, prepare};
use crate::error::{Result, byte_count, printable};
use crate::memory::on_threads;
use crate::units::{report_digits, short};

/// Reads the part and chooses its grid; the lines that say what the rest would take. Nothing is judged and nothing written.
pub fn plan(a: &Arguments) -> Result<(String, u8)> {
    let part = a.part.clone().ok_or_else(|| usage("no part was named", "amcheck part.stl --plan"))?;
    let options = options(&a.how)?;
    threads(&a.how)?;
    let (content, mesh) = loaded(a, &part, &options)?;
    let prepared = prepare(&part.to_string_lossy(), &content, mesh, &options)?;
    drop(content);
    // Facets as the file has them, as in the report; what is judged may be divided otherwise, or united.
    let as_read = prepared.part().health_as_read().facet_body.len();
    let triangles = prepared.part().mesh().triangles.len() as u64;
    let [x, y, z] = prepared.part().extent().map(|c| short((c * 1e3).round() / 1e3));
    let seconds = short((prepared.demand().seconds(triangles, prepared.fitting().samples) * 10.0).round() / 10.0);
    let name = printable(&part.to_string_lossy());
    let need = need(&prepared, &options);
    let of_the_grid = prepared.notices().iter().filter(|notice| notice.code == "grid-coarsened");
    let coarsened: String = of_the_grid.map(|notice| format!("note    {}\n", notice.message)).collect();
    let text = format!(
        "part    {name}: {as_read} triangles, {x} × {y} × {z} mm\n\
         {need}\n\
         time    about {seconds} s of one processor, within a factor of two for nine parts in ten\n{coarsened}",
    );
    Ok((text, 0))
}

/// What the part's fields take, in two lines: nothing of it is taken yet.
pub(super) fn need(prepared: &Prepared, options: &Options) -> String {
    let fitting = prepared.fitting();
    let threads = threads_for(prepared, options).min(rayon::current_num_threads());
    let taken = on_threads(fitting.bytes, prepared.part().mesh().triangles.len() as u64, threads);
    format!(
        "grid    {} mm, {} samples\nmemory  at most {} of {} allowed",
        report_digits(fitting.spacing.as_mm()),
        fitting.samples,
        byte_count(taken),
        byte_count(options.memory.bytes)
    )
}
