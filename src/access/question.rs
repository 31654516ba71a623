//! What is asked of the ways to stand a part up, and what a process asks.

use crate::geometry::vector::Vec3;
use crate::geometry::{Hull, TriangleMesh};
use crate::layer::{SelfHolding, section_points};
use crate::process::Process;
use crate::units::Angle;

/// What is asked of the orientations of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Downward surface below this angle from the horizontal needs support; `None` where nothing does.
    pub support_angle: Option<Angle>,
    /// What prints without support all the same.
    pub self_holding: SelfHolding,
    pub layer_mm: f64,
    pub build_volume_mm: [f64; 3],
    /// Resolution of the coordinates, mm.
    pub step_mm: f64,
    /// Directions spread over the sphere, beside the axes and the part's faces.
    pub directions: usize,
    /// How many of them are measured in full.
    pub best: usize,
    /// A direction that is among these whatever its score.
    pub given: Option<Vec3>,
    /// Directions nearer to each other are one.
    pub apart: Angle,
    /// Samples along the longest side for the full measure.
    pub samples: usize,
    /// What is asked of a pose beside that.
    pub footing: Footing,
    pub liquid: Liquid,
}

/// Whether a part has to stand by itself while it is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Footing {
    /// Its centre of mass has to lie over its first layer: poses that topple come after those that do not.
    Needed,
    /// Powder or supports hold it.
    Any,
}

/// Whether a part is made from liquid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Liquid {
    None,
    /// It hangs from its plate over a film: it keeps liquid upside down, and its cups suck on the film.
    Vat,
}

impl Question {
    /// What a process asks: 400 directions, the best 20 in full at 128 samples.
    pub fn of(process: &Process, step_mm: f64) -> Self {
        let angle = support_angle(process);
        let is_wet = ["drain", "drain.suction"].iter().any(|rule| process.limit(rule).is_some());
        Question {
            support_angle: angle.map(Angle::degrees),
            self_holding: self_holding(process),
            layer_mm: process.layer_height_mm,
            build_volume_mm: process.build_volume_mm,
            step_mm,
            directions: 400,
            best: 20,
            given: None,
            apart: Angle::degrees(8.0),
            samples: 128,
            footing: if process.limit("tall-feature.topple").is_some() { Footing::Needed } else { Footing::Any },
            liquid: if is_wet { Liquid::Vat } else { Liquid::None },
        }
    }

    /// Up to this height a layer lies on the plate: half a layer.
    pub(super) fn plate_z(&self) -> f64 {
        0.5 * self.layer_mm
    }

    /// Whether a part that stands on z = 0 fits the machine and may stand so while it is printed.
    pub fn stands(&self, posed: &TriangleMesh, bounding: impl Fn(usize) -> bool) -> bool {
        self.fits(posed) && self.is_footed(posed, bounding)
    }

    /// Whether a part that stands on z = 0 may stand so.
    pub(super) fn is_footed(&self, posed: &TriangleMesh, bounding: impl Fn(usize) -> bool) -> bool {
        self.footing == Footing::Any
            || posed
                .centre_of_mass(bounding)
                .is_some_and(|[x, y, _]| Hull::of(section_points(posed, 0.5 * self.layer_mm)).depth([x, y]) >= 0.0)
    }

    /// Whether a part, turned about the vertical if that helps, fits the machine.
    pub(super) fn fits(&self, posed: &TriangleMesh) -> bool {
        let [x, y, z] = self.build_volume_mm;
        let Some((_, [w, d, height])) = posed.bounds() else { return false };
        let straight = (w <= x && d <= y) || (d <= x && w <= y);
        let turned = || Hull::of(posed.vertices.iter().map(|p| [p[0], p[1]])).fit([x, y]).share <= 1.0;
        height <= z && (straight || turned())
    }
}

/// The angle from the horizontal below which downward surface needs support, degrees: the stricter of the overhang limits.
pub fn support_angle(process: &Process) -> Option<f64> {
    process.limit("overhang").and_then(|l| l.warn.into_iter().chain(l.fail).reduce(f64::max))
}

/// What prints without support in a process: the stricter limit of each rule.
pub fn self_holding(process: &Process) -> SelfHolding {
    let limit = |key: &str| process.limit(key).and_then(|l| l.warn.or(l.fail));
    SelfHolding {
        bridge_mm: limit("bridge"),
        ledge_mm: limit("bridge.ledge"),
        crown_mm: limit("bridge.horizontal-hole"),
    }
}
