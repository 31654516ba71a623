//! `amcheck PART --plan`: what judging would take, before it is spent.

use super::args::Arguments;
use super::judge::{loaded, options, threads};
use super::words::usage;
use crate::analyze::prepare;
use crate::error::{Result, printable};
use crate::report::phrase::bytes;
use crate::units::{report_digits, short};

/// Reads the part and chooses its grid; the lines that say what the rest would take. Nothing is judged and nothing written.
pub fn plan(a: &Arguments) -> Result<(String, u8)> {
    let part = a.part.clone().ok_or_else(|| usage("no part was named", "amcheck part.stl --plan"))?;
    let options = options(&a.how)?;
    threads(&a.how)?;
    let (content, mesh) = loaded(a, &part, &options)?;
    let prepared = prepare(&part.to_string_lossy(), &content, mesh, &options)?;
    drop(content);
    let (fitting, triangles) = (prepared.fitting(), prepared.part().mesh().triangles.len() as u64);
    let [x, y, z] = prepared.part().extent().map(|c| short((c * 1e3).round() / 1e3));
    let spacing = report_digits(fitting.spacing.as_mm());
    let seconds = short((options.demand().seconds(triangles, fitting.samples) * 10.0).round() / 10.0);
    let name = printable(&part.to_string_lossy());
    let need = u64::try_from(fitting.bytes).unwrap_or(u64::MAX);
    let allowed = u64::try_from(options.memory.bytes).unwrap_or(u64::MAX);
    let text = format!(
        "part    {name}: {triangles} triangles, {x} × {y} × {z} mm\n\
         grid    {spacing} mm, {} samples\n\
         memory  at most {} of {} allowed\n\
         time    about {seconds} s of one processor, within a factor of two for nine parts in ten\n",
        fitting.samples,
        bytes(need),
        bytes(allowed),
    );
    Ok((text, 0))
}
