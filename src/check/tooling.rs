//! The tools of a process and the directions they come from, as the checks of access use them.

use super::contract::Context;
use crate::access::{Setup, Tool};
use crate::error::Result;
use crate::geometry::vector::Vec3;
use crate::part::Part;
use crate::process::{Process, ToolChoice};
use crate::units::{Length, short};

/// Spacing at least, millimetres: hand tools are known to a few tenths, and a fine lattice of a long tool costs minutes.
const LEAST_SPACING_MM: f64 = 0.4;
/// Samples along the longest side: access needs no finer grid than the tools are wide.
const SAMPLES: f64 = 100.0;
/// The same where the user names the tools.
const SAMPLES_NAMED: f64 = 192.0;

/// A part before the tools of a list.
pub struct Tooling<'p> {
    pub tools: Vec<Tool>,
    pub setups: Vec<&'p Setup>,
    pub spacing: f64,
    /// How near a cutter has to come to count as touching: what a contact needs on a lattice, 2·√3 spacings.
    pub stand_off: f64,
}

impl<'p> Tooling<'p> {
    /// The tools of a list in all setups of the part; all checks share the setups.
    ///
    /// # Errors
    /// As [`Tool::chosen`], [`Tool::fits`] and [`Part::setups`].
    pub fn new(part: &'p Part, process: &Process, context: &Context, list: &[ToolChoice]) -> Result<Self> {
        let Lattice { spacing, stand_off, margin } = Lattice::of(process, part.extent(), context.spacing_mm)?;
        let tools = read(list)?;
        if process.tools.named {
            tools.iter().try_for_each(|t| t.fits(part.extent()))?;
        }
        let setups = part.setups(Length::mm(spacing), Length::mm(margin))?.iter().collect();
        Ok(Tooling { tools, setups, spacing, stand_off })
    }

    /// The tools, the directions and the spacing, in words.
    pub fn described(&self) -> String {
        let names: Vec<&str> = self.tools.iter().map(|t| t.name.as_str()).collect();
        format!("{} from {} directions at {} mm", names.join(", "), self.setups.len(), short(round(self.spacing)))
    }
}

fn read(list: &[ToolChoice]) -> Result<Vec<Tool>> {
    list.iter().map(Tool::chosen).collect()
}

/// The lattice of the setups of a part, millimetres.
struct Lattice {
    spacing: f64,
    stand_off: f64,
    margin: f64,
}

impl Lattice {
    fn of(process: &Process, extent: Vec3, grid_spacing: f64) -> Result<Self> {
        let longest = extent.into_iter().fold(0.0, f64::max);
        let samples = if process.tools.named { SAMPLES_NAMED } else { SAMPLES };
        let spacing = (longest / samples).max(grid_spacing).max(LEAST_SPACING_MM);
        let stand_off = 2.0 * 3f64.sqrt() * spacing;
        let all = [read(&process.tools.removal)?, read(&process.tools.finishing)?];
        let widest = all.iter().flatten().map(Tool::cutter_width).fold(0.0, f64::max);
        Ok(Lattice { spacing, stand_off, margin: 0.5 * widest.min(longest) + stand_off })
    }
}

/// Samples of all setups of a part together, on a grid however fine: what they take is known before any is cast.
///
/// # Errors
/// As [`Tool::chosen`].
pub fn setup_samples(process: &Process, extent: Vec3) -> Result<u128> {
    let Lattice { spacing, margin, .. } = Lattice::of(process, extent, 0.0)?;
    Ok(Setup::samples(extent, Length::mm(spacing), Length::mm(margin)))
}

/// A length as texts give it: three decimals.
pub fn round(mm: f64) -> f64 {
    (mm * 1e3).round() / 1e3
}

/// A direction of the build's frame in words, in the frame of the file: `+z`, or its three parts.
pub fn direction_in_file(part: &Part, direction: Vec3) -> String {
    let (from, to) = (part.to_file([0.0; 3]), part.to_file(direction));
    let d = [0, 1, 2].map(|a| to[a] - from[a]);
    let axis = (0..3).find(|&a| d[a].abs() > 1.0 - 1e-9);
    match axis {
        Some(a) => format!("{}{}", if d[a] > 0.0 { "+" } else { "-" }, ["x", "y", "z"][a]),
        None => format!("({:.2}, {:.2}, {:.2})", d[0], d[1], d[2]),
    }
}
