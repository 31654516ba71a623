//! The tools of a process and the directions they come from, as the checks of access use them.

use super::contract::Context;
use crate::access::{
    FACES, Rotation, Setup, Tool, Turns, axis_directions, fibonacci, flat_face_normals, lattice_directions,
    super_fibonacci, within_tilt,
};
use crate::error::{Error, Result, ToolFault};
use crate::geometry::InsideRule;
use crate::geometry::vector::{Vec3, angle, norm, unit};
use crate::part::Part;
use crate::process::{Approach, Finishing, Process, ToolChoice};
use crate::units::{Length, short};
use std::borrow::Cow;

/// Spacing at least, millimetres: hand tools are known to a few tenths, and a fine lattice of a long tool costs minutes.
const LEAST_SPACING_MM: f64 = 0.4;
/// Samples along the longest side: access needs no finer grid than the tools are wide.
const SAMPLES: f64 = 100.0;
/// The same where the user names the tools.
const SAMPLES_NAMED: f64 = 192.0;

/// Two directions closer than this are one, radians.
const SAME: f64 = 1e-3;

/// A part before the tools of a list.
pub struct Tooling<'p> {
    pub tools: Vec<Tool>,
    pub setups: Cow<'p, [Setup]>,
    pub spacing: f64,
    /// How near a cutter has to come to count as touching: what a contact needs on a lattice, 2·√3 spacings.
    pub stand_off: f64,
}

impl<'p> Tooling<'p> {
    /// The tools for supports, by hand from everywhere: in all setups of the part, which all checks share.
    ///
    /// # Errors
    /// As [`Tool::chosen`], [`Tool::fits`] and [`Part::setups`].
    pub fn of_removal(part: &'p Part, process: &Process, context: &Context) -> Result<Self> {
        Tooling::new(part, process, context, &process.tools.removal, &Finishing::default())
    }

    /// The tools for surfaces, from where the process or the user says.
    ///
    /// # Errors
    /// As [`Tooling::of_removal`], and [`ToolFault::NoDirections`] if no direction is within the tilt.
    pub fn of_finishing(part: &'p Part, process: &Process, context: &Context) -> Result<Self> {
        Tooling::new(part, process, context, &process.tools.finishing, &process.tools.finish)
    }

    fn new(
        part: &'p Part,
        process: &Process,
        context: &Context,
        list: &[ToolChoice],
        finish: &Finishing,
    ) -> Result<Self> {
        let Lattice { spacing, stand_off, margin } = Lattice::of(process, part.extent(), context.spacing_mm)?;
        let tools = read(list)?;
        if process.tools.named {
            tools.iter().try_for_each(|t| t.fits(part.extent()))?;
        }
        let (h, margin) = (Length::mm(spacing), Length::mm(margin));
        let setups = if is_by_hand(finish) {
            Cow::Borrowed(part.setups(h, margin)?)
        } else {
            let stands = stands(part, finish, &tools);
            if stands.is_empty() {
                let tool = tools.first().map(|t| t.name.clone()).unwrap_or_default();
                return Err(Error::Tool { tool, fault: ToolFault::NoDirections });
            }
            let rule = if part.health().is_solid() { InsideRule::Crossings } else { InsideRule::Winding };
            let from: Vec<Vec3> = stands.iter().map(|s| s.0).collect();
            let mut setups = Setup::all(part.mesh(), rule, &from, h, margin)?;
            setups.iter_mut().zip(stands).for_each(|(setup, (_, turns))| setup.turns = turns);
            Cow::Owned(setups)
        };
        Ok(Tooling { tools, setups, spacing, stand_off })
    }

    /// The tools, the directions and the spacing, in words.
    pub fn described(&self) -> String {
        let names: Vec<&str> = self.tools.iter().map(|t| t.name.as_str()).collect();
        let from = match self.setups.len() {
            1 => "1 direction".to_string(),
            n => format!("{n} directions"),
        };
        let rotations: usize = self.setups.iter().map(|s| s.turns.count()).sum();
        let turned = match self.tools.iter().any(|t| t.meridian().is_none()) {
            true => format!(" (tools of any shape at {rotations} rotations)"),
            false => String::new(),
        };
        format!("{} from {from}{turned} at {} mm", names.join(", "), short(round(self.spacing)))
    }
}

/// What the user lists, or the cube's directions if nothing is listed.
fn listed(finish: &Finishing) -> &[Approach] {
    if finish.from.is_empty() { &[Approach::Cube] } else { &finish.from }
}

/// Whether the tools come from where they come from by hand: then all checks share the setups of the part.
fn is_by_hand(finish: &Finishing) -> bool {
    finish.from.is_empty() && finish.tilt.is_none()
}

/// How many directions need setups of their own, at most: known without the part.
fn most_directions(finish: &Finishing, tools: &[Tool]) -> usize {
    if is_by_hand(finish) {
        return 0;
    }
    let most = |approach: &Approach| match approach {
        Approach::Cube => lattice_directions().len(),
        Approach::Axes => axis_directions().len(),
        // Their opposites complete an odd number; tools of any shape come at as many rotations beside.
        Approach::Sphere(n) if tools.iter().all(|t| t.meridian().is_some()) => n + 1,
        Approach::Sphere(n) => 2 * n + 1,
        Approach::Faces => FACES,
        Approach::Along(_) => 1,
    };
    listed(finish).iter().map(most).sum()
}

/// The directions in the frame of the build with what tools of any shape do there: all of the list in four quarter turns, but for those
/// over the sphere, beside which they come at as many rotations spread over all of them.
fn stands(part: &Part, finish: &Finishing, tools: &[Tool]) -> Vec<(Vec3, Turns)> {
    let any_shape = tools.iter().any(|t| t.meridian().is_none());
    let over_all = listed(finish).iter().filter_map(|approach| match approach {
        Approach::Sphere(n) if any_shape => Some(super_fibonacci(*n)),
        _ => None,
    });
    let axis = |rotation: &Rotation| [0, 1, 2].map(|r| rotation[r][2]);
    let leans = |d: Vec3| finish.tilt.is_none_or(|tilt| !within_tilt(&[d], [0.0, 0.0, 1.0], tilt).is_empty());
    let rotations: Vec<Rotation> = over_all.flatten().filter(|r| leans(axis(r))).collect();
    let spread: Vec<Vec3> = listed(finish)
        .iter()
        .filter_map(|approach| if let Approach::Sphere(n) = approach { Some(fibonacci(*n)) } else { None })
        .flatten()
        .collect();
    let turns = |d: &Vec3| if any_shape && spread.contains(d) { Turns::Nowhere } else { Turns::Quarters };
    let plain = directions(part, finish).into_iter().map(|d| (d, turns(&d)));
    plain.chain(rotations.into_iter().map(|r| (axis(&r), Turns::At(r)))).collect()
}

/// The directions in the frame of the build, each once, those within the tilt.
fn directions(part: &Part, finish: &Finishing) -> Vec<Vec3> {
    let all = listed(finish).iter().flat_map(|approach| match *approach {
        Approach::Cube => lattice_directions(),
        Approach::Axes => axis_directions(),
        Approach::Sphere(n) => fibonacci(n),
        Approach::Faces => flat_face_normals(part.mesh(), &|f| part.bounds_solid(f)),
        Approach::Along(d) => vec![unit(part.direction_to_build(d))],
    });
    let mut once: Vec<Vec3> = Vec::new();
    for d in all {
        if once.iter().all(|e| angle(*e, d) > SAME) {
            once.push(d);
        }
    }
    match finish.tilt {
        Some(tilt) => within_tilt(&once, [0.0, 0.0, 1.0], tilt),
        None => once,
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
    let shared = Setup::samples(extent, Length::mm(spacing), Length::mm(margin));
    // From directions of the user's own, none is wider than the part's diagonal.
    let across = (norm(extent) + 2.0 * margin) / spacing;
    let each = (across.ceil().clamp(1.0, 1e9) as u128 + 3).pow(3);
    Ok(shared + each * most_directions(&process.tools.finish, &read(&process.tools.finishing)?) as u128)
}

/// A length as texts give it: three decimals.
pub fn round(mm: f64) -> f64 {
    (mm * 1e3).round() / 1e3
}

/// A direction of the build's frame in words, in the frame of the file: `+z`, or its three parts.
pub fn direction_in_file(part: &Part, direction: Vec3) -> String {
    let d = part.direction_to_file(direction);
    let axis = (0..3).find(|&a| d[a].abs() > 1.0 - 1e-9);
    match axis {
        Some(a) => format!("{}{}", if d[a] > 0.0 { "+" } else { "-" }, ["x", "y", "z"][a]),
        None => {
            // Rounded first, so that no zero has a sign.
            let [x, y, z] = d.map(|c| (100.0 * c).round() / 100.0 + 0.0);
            format!("({x:.2}, {y:.2}, {z:.2})")
        }
    }
}
