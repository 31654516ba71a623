//! Changes of topology undone before that is advised: a place is thickened or widened on a lattice of its own and printed again.

use super::departure::Departure;
use super::trial::Trial;
use crate::error::Result;
use crate::geometry::vector::Vec3;
use crate::medial::Side;
use crate::part::{Part, bead_of};
use crate::process::Process;
use crate::units::short;

/// Places of a kind that are tried, those first that lack most.
pub const TRIED: usize = 3;
/// Growth is counted across upright faces.
const ACROSS: Vec3 = [1.0, 0.0, 0.0];

/// What trying has shown: how much a place has to grow so that printing leaves it as it is, on both sides together, millimetres; `None` if
/// three cells on either side do not do it.
pub type Growth = Option<f64>;

/// Lets a place grow by at least what it lacks until printing leaves it as it is; `None` if the place is too large to try.
///
/// # Errors
/// As [`Part::deposited`].
pub fn growth(
    part: &Part,
    process: &Process,
    side: Side,
    (extent, missing): ((Vec3, Vec3), f64),
) -> Result<Option<Growth>> {
    let departure = Departure::of_outline(side, process);
    let Some(trial) = Trial::around(part, bead_of(process), extent, departure)? else { return Ok(None) };
    let steps = trial.remedied(ACROSS, missing)?;
    Ok(Some(steps.map(|n| n as f64 * trial.step_along(ACROSS))))
}

/// What is said of a remedy, from what was tried at some of `places`: the greatest growth that was needed.
pub fn words(remedy: &str, tries: &[Growth], places: usize) -> String {
    let most = tries.iter().flatten().fold(0.0f64, |m, g| m.max(*g));
    let (tried, works) = (tries.len(), tries.iter().flatten().count());
    let by = short((1e3 * most).round() / 1e3);
    match (works, tried == places && works == tried) {
        _ if tried == 0 => "what is less than an element across is not printed as drawn".into(),
        (0, _) => "grown by three cells on either side it is still not printed as drawn, checked on the cells".into(),
        (_, true) => format!("{remedy} by {by} mm: checked on the cells, it is printed as drawn then"),
        _ => format!(
            "{remedy} by {by} mm: checked on the cells at {tried} of {places} places, {works} are printed as drawn then"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid};
    use crate::part::Up;

    fn part(mesh: TriangleMesh) -> Part {
        Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap()
    }

    #[test]
    fn a_thin_wall_is_printed_once_it_has_grown_and_a_closing_slot_stays_open() {
        let process = Process::named("fdm").unwrap();
        let wall = part(cuboid([0.0; 3], [0.1, 3.0, 3.0]));
        let by = growth(&wall, &process, Side::Material, (([0.0, 1.0, 1.0], [0.1, 2.0, 2.0]), 0.0))
            .unwrap()
            .unwrap()
            .unwrap();
        assert!(by > 0.05 && by < 0.7, "{by}");
        let slot = part(cuboid([0.0; 3], [2.0, 3.0, 3.0]).joined(&cuboid([2.1, 0.0, 0.0], [4.1, 3.0, 3.0])));
        let by =
            growth(&slot, &process, Side::Void, (([2.0, 1.0, 1.0], [2.1, 2.0, 2.0]), 0.0)).unwrap().unwrap().unwrap();
        assert!(by > 0.05 && by < 0.7, "{by}");
    }

    #[test]
    fn what_no_growth_keeps_is_not_advised() {
        assert!(words("thicken it", &[None, None], 2).starts_with("grown by three cells"));
        assert_eq!(
            words("widen it", &[Some(0.2)], 1),
            "widen it by 0.2 mm: checked on the cells, it is printed as drawn then"
        );
        assert!(words("widen it", &[Some(0.2), None], 5).contains("at 2 of 5 places, 1 are printed"));
    }
}
