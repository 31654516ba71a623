//! Whether what is thickened or widened has room: such a hint is tried on the surface before it is given.

use super::contract::limits_of;
use crate::geometry::vector::{Vec3, sub, unit};
use crate::medial::{Sample, Side};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// Pairs of contacts of a sheet that are tried, evenly over it.
const TRIED: usize = 64;

/// How a hint begins that says that there is none.
pub const NO_ROOM: &str = "there is no room";

/// What has to be left beside what grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// The limit of what lies there.
    Limit,
    /// At least as much as it has grown to: an offset that spares one then spares the other.
    AsMuch,
}

/// Something on one side of a part's surface that is to grow.
pub struct Growth<'a> {
    part: &'a Part,
    side: Side,
    /// What has to be left beside it: the gap beside a wall or a pin, the wall beside a gap or a hole; 0 without such a rule.
    pub beside: f64,
}

impl<'a> Growth<'a> {
    /// With the limit of what lies beside: `narrow-gap` for material, `thin-wall` for void.
    pub fn new(part: &'a Part, process: &Process, side: Side) -> Self {
        let rule = if side == Side::Material { "narrow-gap" } else { "thin-wall" };
        Growth { part, side, beside: limits_of(process, rule).and_then(|l| l.fail.or(l.warn)).unwrap_or(0.0) }
    }

    /// The same, with what is to be left beside something that has grown to a width.
    pub fn leaving(self, beside: Beside, width: f64) -> Self {
        let least = if beside == Beside::AsMuch { width } else { 0.0 };
        Growth { beside: self.beside.max(least), ..self }
    }

    /// Whether a sheet can grow to a width at all pairs of contacts that are tried: on one side, or by half on both.
    ///
    /// # Cost
    /// At most 128 rays.
    pub fn fits<'s>(&self, samples: impl ExactSizeIterator<Item = &'s Sample>, width: f64) -> bool {
        let stride = samples.len().div_ceil(TRIED).max(1);
        samples.step_by(stride).all(|s| self.fits_between(s.contacts, width - s.diameter))
    }

    /// Whether two contacts can move apart by a length, and leave beside them what has to be left.
    pub fn fits_between(&self, [a, b]: [Vec3; 2], by: f64) -> bool {
        let free = |from: Vec3, way: Vec3| {
            let (near, far) = (self.part.step(), by + self.beside);
            self.part.distance().first_hit(from, way, near, far).map_or(far, |(at, _)| at)
        };
        let outward = unit(sub(b, a));
        if by <= 0.0 || outward == [0.0; 3] {
            // Contacts that coincide tell no direction to grow in.
            return by <= 0.0;
        }
        let (behind, beyond) = (free(a, outward.map(|x| -x)), free(b, outward));
        let enough = |free: f64, by: f64| free >= by + self.beside - self.part.tie();
        enough(behind.max(beyond), by) || enough(behind.min(beyond), 0.5 * by)
    }

    /// The hint that asks for so much, with what trying it at `roomy` and `cramped` places has shown.
    pub fn tried(&self, hint: String, verb: &str, width: f64, [roomy, cramped]: [usize; 2]) -> String {
        let beside = short(self.beside);
        let left = match (self.beside > 0.0, self.side) {
            (true, _) => format!("less than {beside} mm would be left beside it"),
            (false, Side::Material) => "it would meet what is beside it".to_string(),
            (false, Side::Void) => "nothing would be left beside it".to_string(),
        };
        match [roomy, cramped] {
            [0, 0] => hint,
            [_, 0] => format!("{hint}: there is room for it, checked on the surface"),
            [0, _] => format!("{NO_ROOM} to {verb} it to {} mm: {left}", short(width)),
            [n, m] => {
                format!("{hint}: checked on the surface, there is room at {n} of {} places; elsewhere {left}", n + m)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{TriangleMesh, cuboid};
    use crate::part::Up;

    /// Two plates of 0.4 mm, upright, with a gap between their faces, and a third one beyond the second.
    fn plates(gap: f64, next: f64) -> TriangleMesh {
        let plate = |x: f64| cuboid([x, 0.0, 0.0], [x + 0.4, 10.0, 10.0]);
        plate(0.0).joined(&plate(0.4 + gap)).joined(&plate(0.8 + gap + next))
    }

    fn part(mesh: TriangleMesh) -> Part {
        Part::new(mesh, Up::PlusZ, 1e-6, 1.0).unwrap()
    }

    #[test]
    fn a_wall_grows_where_the_gaps_beside_it_leave_room() {
        // fdm asks for gaps of 0.2 mm between what is fused.
        let process = Process::named("fdm").unwrap();
        for (gap, next, by, fits) in [
            (1.0, 1.0, 0.4, true),
            (0.3, 1.0, 0.4, true),
            (0.3, 0.3, 0.4, false),
            // Half on both sides.
            (0.41, 0.41, 0.4, true),
            (0.41, 0.41, 0.45, false),
        ] {
            let part = part(plates(gap, next));
            let growth = Growth::new(&part, &process, Side::Material);
            let contacts = [0.4 + gap, 0.8 + gap].map(|x| [x, 5.0, 5.0]);
            assert_eq!(growth.fits_between(contacts, by), fits, "{gap} {next} + {by}, {}", growth.beside);
        }
        let part = part(plates(1.0, 1.0));
        let growth = Growth::new(&part, &process, Side::Void);
        // Behind both faces of the gap stand walls of 0.4 mm, too thin to lose anything.
        assert!(!growth.fits_between([[0.4, 5.0, 5.0], [1.4, 5.0, 5.0]], 0.1) && growth.beside > 0.4);
        assert_eq!(
            growth.tried("widen".into(), "widen", 1.0, [1, 0]),
            "widen: there is room for it, checked on the surface"
        );
    }
}
