//! AM002: does the part fit the machine.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst};
use super::finding::{Basis, Bracket, Finding, Limits, Sense};
use super::place::locate;
use crate::error::Result;
use crate::geometry::vector::Vec3;
use crate::geometry::{Fit, Hull};
use crate::part::Part;
use crate::process::Process;
use crate::units::{Angle, short};
use std::cmp::Ordering;

/// AM002 `build-volume`.
pub struct BuildVolume;

static META: Meta = Meta {
    code: "AM002",
    name: "build-volume",
    title: "Size against the build volume",
    what: "Compares the part's box, as posed for the build, with the machine's build volume. A part that does not fit as it lies and does \
           when it is turned about the vertical warns, for nothing but its place changes; one that fits in no such turn fails.",
    why: "A part that does not fit cannot be printed in one piece.",
    how: "The share of the build volume's side that the part takes, along the worst axis; 1 is just full. Where the box does not fit, the \
          part's shadow on the plate is turned: the best of all angles is found from its convex hull, exactly. A part that fits in \
          none as it lies is laid on the other two sides of its box, and each of them turned.",
    limits: "Poses between the three axes are not tried. Brims, supports and the machine's own margins are not counted.",
    source: "The machine's data in the process profile.",
};

impl Check for BuildVolume {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let extent = part.extent();
        let volume = process.build_volume_mm;
        let as_posed = worst_share(extent, volume);
        let tie = 2.0 * part.step() / volume.into_iter().fold(f64::INFINITY, f64::min);
        let mut measured = Measured {
            worst: Some(Worst { bracket: Bracket::exact(as_posed), unit: "1", at: None }),
            cover: "The box of all vertices, exact.".into(),
            ..Measured::default()
        };
        if as_posed <= 1.0 + tie {
            return Ok(Outcome::Measured(Box::new(measured)));
        }
        let lays = Lay::all(&part.mesh().vertices, volume);
        let turned = lays[0].share();
        let fits = turned <= 1.0 + tie;
        // What a turn about the vertical mends is told by what it is without, and what none does by the best of them.
        let (kind, share, limits) = match fits {
            true => ("turned", as_posed, Limits { fail: None, warn: Some(1.0), sense: Sense::Max }),
            false => ("box", turned, Limits { fail: Some(1.0), warn: None, sense: Sense::Max }),
        };
        measured.worst = Some(Worst { bracket: Bracket::exact(share), unit: "1", at: None });
        let mut f = Finding::judged(META.code, kind, Bracket::exact(share), Basis::Exact, limits, "1", tie);
        let ([x, y, z], [a, b, c]) = (extent.map(short), volume.map(short));
        f.message = format!("{x} × {y} × {z} mm does not fit {a} × {b} × {c} mm");
        f.message += if fits { " as it lies, only turned about z" } else { ", however it is turned about z" };
        f.fix = remedy(&lays, tie);
        locate(&mut f, part, context, extent.map(|s| 0.5 * s), ([0.0; 3], extent));
        measured.findings.push(f);
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// What makes a part fit: a turn about the vertical as it lies, or else another side, straight rather than askew, or a smaller scale as well.
fn remedy(lays: &[Lay; 3], tie: f64) -> String {
    let told = lays.each_ref().map(Lay::told);
    let fits = |t: &&Told| t.share <= 1.0 + tie;
    let straight = || told.iter().filter(fits).filter(|t| t.straight).min_by(Told::least);
    let any = || told.iter().min_by(Told::least);
    let Some(best) = told.first().filter(fits).or_else(straight).or_else(any) else { return String::new() };
    if fits(&best) {
        return format!("{}: then it takes {:.0} % of the worst side", best.turn, 100.0 * best.share);
    }
    let way = if best.turn.is_empty() { String::new() } else { format!("{} and ", best.turn) };
    format!(
        "{way}scale to {} %, or cut the part; it fits on none of its sides, poses between them were not tried",
        short(fitting_percent(best.share))
    )
}

/// A turn in words, and what the part takes then.
struct Told {
    share: f64,
    straight: bool,
    turn: String,
}

impl Told {
    fn least(a: &&Told, b: &&Told) -> Ordering {
        a.share.total_cmp(&b.share)
    }
}

/// A way to lay the part down: its shadow on the plate, and what it takes of the machine with the best turn about the vertical.
struct Lay {
    way: &'static str,
    shadow: Hull,
    plate: [f64; 2],
    tall: f64,
    fit: Fit,
}

impl Lay {
    /// As it lies, and turned by 90° about x or y.
    fn all(points: &[Vec3], [x, y, z]: Vec3) -> [Lay; 3] {
        // The axes that lie along x and y then, and the one that is upright; how far a shadow reaches does not depend on their signs, but on
        // whether it is mirrored.
        let ways = [("", [0, 1, 2], 1.0), ("90° about x", [0, 2, 1], -1.0), ("90° about y", [2, 1, 0], 1.0)];
        ways.map(|(way, [along, across, upright], sign)| {
            let shadow = Hull::of(points.iter().map(|p| [p[along], sign * p[across]]));
            let heights = points.iter().map(|p| p[upright]);
            let ends = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), h| (lo.min(h), hi.max(h)));
            let fit = shadow.fit([x, y]);
            Lay { way, shadow, plate: [x, y], tall: (ends.1 - ends.0).max(0.0) / z, fit }
        })
    }

    fn share(&self) -> f64 {
        self.fit.share.max(self.tall)
    }

    /// The share and the turn in words: by a right angle if that fits, or by the roundest angle that takes no more than a hundredth of the room
    /// that is left, or of itself.
    fn told(&self) -> Told {
        let exact = self.share();
        let allowed = if exact < 1.0 { exact + 0.01 * (1.0 - exact) } else { 1.01 * exact };
        let degrees = self.fit.turn.as_degrees();
        let share = |d: f64| self.shadow.share(self.plate, Angle::degrees(d)).max(self.tall);
        let straight = [0.0, 90.0].into_iter().find(|d| share(*d) <= allowed.max(1.0));
        let rounded = [1.0f64, 10.0, 100.0, 1e4].map(|digits| (digits * degrees).round() / digits);
        let round = rounded.into_iter().find(|d| share(*d) <= allowed);
        let degrees = straight.or(round).unwrap_or(degrees);
        let about_z = (degrees != 0.0).then(|| format!("{}° about z", short(degrees)));
        let way = [Some(self.way.to_string()).filter(|w| !w.is_empty()), about_z];
        let way: Vec<String> = way.into_iter().flatten().collect();
        let turn = if way.is_empty() { String::new() } else { format!("turn it {}", way.join(", then ")) };
        Told { share: share(degrees), straight: straight.is_some(), turn }
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

#[cfg(test)]
mod tests {
    use super::super::finding::State;
    use super::*;
    use crate::geometry::cuboid;
    use crate::part::Up;

    /// State, share and remedy of a box that does not fit.
    fn told(process: &str, sides: [f64; 3]) -> (State, f64, String) {
        let context = Context { refine: 0, spacing_mm: 1.0 };
        let part = Part::new(cuboid([0.0; 3], sides), Up::PlusZ, 1e-6, 1.0).unwrap();
        let process = Process::named(process).unwrap();
        let Ok(Outcome::Measured(found)) = BuildVolume.run(&part, &process, &context) else { panic!("not measured") };
        let [f] = &found.findings[..] else { panic!("{sides:?}: {:?}", found.findings) };
        (f.state, f.value, f.fix.clone())
    }

    #[test]
    fn what_a_turn_about_the_vertical_mends_warns_and_says_which() {
        // 190 × 240 × 300 mm; 220 × 220 × 250 mm.
        let (state, share, fix) = told("sls", [230.0, 100.0, 50.0]);
        assert!(state == State::Warn && (share - 230.0 / 190.0).abs() < 1e-6, "{state:?} {share}");
        assert_eq!(fix, "turn it 90° about z: then it takes 96 % of the worst side");
        let (state, share, fix) = told("fdm", [290.0, 8.0, 8.0]);
        assert!(state == State::Warn && (share - 290.0 / 220.0).abs() < 1e-6, "{state:?} {share}");
        assert_eq!(fix, "turn it 45° about z: then it takes 96 % of the worst side");
    }

    #[test]
    fn what_fits_in_another_pose_fails_and_says_which() {
        let (state, share, fix) = told("fdm", [240.0, 80.0, 80.0]);
        let diagonal = 320.0 / 2f64.sqrt() / 220.0;
        assert!(state == State::Fail && (share - diagonal).abs() < 1e-6, "{state:?} {share}");
        assert_eq!(fix, "turn it 90° about y: then it takes 96 % of the worst side");
        // On one side it fits straight, on another it takes less and is askew.
        let (_, _, fix) = told("fdm", [170.0, 230.0, 20.0]);
        assert_eq!(fix, "turn it 90° about x: then it takes 92 % of the worst side");
        // Taller than the machine, and too long to lie straight.
        let (state, _, fix) = told("fdm", [8.0, 8.0, 290.0]);
        assert!(
            state == State::Fail
                && fix == "turn it 90° about x, then 45° about z: then it takes 96 % of the worst side",
            "{fix}"
        );
    }

    #[test]
    fn what_fits_in_none_is_scaled_as_it_is_turned() {
        // The diagonal of the plate holds 220·√2 − 10 mm.
        let (state, share, fix) = told("fdm", [320.0, 10.0, 10.0]);
        assert!(state == State::Fail && (share - 330.0 / 2f64.sqrt() / 220.0).abs() < 1e-6, "{state:?} {share}");
        assert_eq!(
            fix,
            "turn it 45° about z and scale to 94 %, or cut the part; it fits on none of its sides, poses between them were not tried"
        );
        assert_eq!(
            told("fdm", [300.0, 220.0, 220.0]).2,
            "turn it 90° about y and scale to 83 %, or cut the part; it fits on none of its sides, poses between them were not tried"
        );
        assert_eq!(
            told("fdm", [220.0, 220.0, 300.0]).2,
            "scale to 83 %, or cut the part; it fits on none of its sides, poses between them were not tried"
        );
    }

    #[test]
    fn the_best_turn_is_found() {
        let bar = cuboid([0.0; 3], [300.0, 10.0, 10.0]);
        let fix = remedy(&Lay::all(&bar.vertices, [100.0, 100.0, 320.0]), 0.0);
        assert_eq!(fix, "turn it 90° about y: then it takes 94 % of the worst side");
    }
}
