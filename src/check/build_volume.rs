//! AM002: does the part fit the machine.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst};
use super::finding::{Basis, Bracket, Finding, Limits, Sense};
use super::place::locate;
use crate::error::Result;
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// AM002 `build-volume`.
pub struct BuildVolume;

static META: Meta = Meta {
    code: "AM002",
    name: "build-volume",
    title: "Size against the build volume",
    what: "Compares the part's box, as posed for the build, with the machine's build volume, and tries all turns by 90 degrees.",
    why: "A part that does not fit cannot be printed in one piece.",
    how: "The share of the build volume's side that the part takes, along the worst axis; 1 is just full. The six ways to lay the \
          box down are compared, and the best is named.",
    limits: "Turns by other angles are not tried: a long part may still fit along a diagonal. Brims, supports and the machine's own \
             margins are not counted.",
    source: "The machine's data in the process profile.",
};

impl Check for BuildVolume {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let extent = part.extent();
        let volume = process.build_volume_mm;
        let share = worst_share(extent, volume);
        let limits = Limits { fail: Some(1.0), warn: None, sense: Sense::Max };
        let tie = 2.0 * part.step() / volume.into_iter().fold(f64::INFINITY, f64::min);
        let mut measured = Measured {
            worst: Some(Worst { bracket: Bracket::exact(share), unit: "1", at: None }),
            cover: "The box of all vertices, exact.".into(),
            ..Measured::default()
        };
        if share > 1.0 + tie {
            let mut f = Finding::judged(META.code, "box", Bracket::exact(share), Basis::Exact, limits, "1", tie);
            let [x, y, z] = extent.map(short);
            let [a, b, c] = volume.map(short);
            let (best, turn) = best_turn(extent, volume);
            f.message = format!("{x} × {y} × {z} mm does not fit {a} × {b} × {c} mm");
            f.fix = if best <= 1.0 + tie {
                format!("{turn}: then it takes {:.0} % of the worst side", 100.0 * best)
            } else {
                let way = if turn == AS_IT_IS { String::new() } else { format!("{turn} and ") };
                format!("{way}scale to {} %, or cut the part; no turn by 90° fits", short(fitting_percent(best)))
            };
            locate(&mut f, part, context, extent.map(|s| 0.5 * s), ([0.0; 3], extent));
            measured.findings.push(f);
        }
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// Largest ratio of a side of the part to the same side of the volume.
fn worst_share(extent: [f64; 3], volume: [f64; 3]) -> f64 {
    (0..3).map(|a| extent[a] / volume[a]).fold(0.0, f64::max)
}

/// The greatest scale in percent, of two digits, at which what takes `share` of the volume's worst side fits.
fn fitting_percent(share: f64) -> f64 {
    let exact = 100.0 / share;
    let unit = 10f64.powf(exact.log10().floor() - 1.0);
    (exact / unit + 1e-9).floor() * unit
}

/// The way that is no turn.
const AS_IT_IS: &str = "leave it as it is";

/// The best of the six ways to lay a box down, in words.
fn best_turn([x, y, z]: [f64; 3], volume: [f64; 3]) -> (f64, &'static str) {
    [
        ([x, y, z], AS_IT_IS),
        ([y, x, z], "turn it 90° about z"),
        ([x, z, y], "turn it 90° about x"),
        ([z, y, x], "turn it 90° about y"),
        ([y, z, x], "turn it 90° about z, then 90° about x"),
        ([z, x, y], "turn it 90° about z, then 90° about y"),
    ]
    .map(|(e, text)| (worst_share(e, volume), text))
    .into_iter()
    .fold((f64::INFINITY, ""), |best, t| if t.0 < best.0 { t } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_long_is_scaled_as_it_is_turned() {
        let process = Process::named("fdm").unwrap();
        let context = Context { refine: 0, spacing_mm: 1.0 };
        let fix = |sides| {
            let mesh = crate::geometry::cuboid([0.0; 3], sides);
            let part = Part::new(mesh, crate::part::Up::PlusZ, 1e-6, 1.0).unwrap();
            let Ok(Outcome::Measured(found)) = BuildVolume.run(&part, &process, &context) else {
                panic!("not measured")
            };
            found.findings[0].fix.clone()
        };
        // 250 mm are the height of the machine, 220 its sides.
        assert!(fix([300.0, 10.0, 10.0]).starts_with("turn it 90° about y and scale to 83 %, or cut"));
        assert!(fix([10.0, 10.0, 300.0]).starts_with("scale to 83 %, or cut"));
    }

    #[test]
    fn the_best_turn_is_found() {
        let (share, text) = best_turn([300.0, 10.0, 10.0], [100.0, 100.0, 320.0]);
        assert!(share < 1.0 && text == "turn it 90° about y");
    }
}
