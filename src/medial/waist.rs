//! The narrowest section of a rod.

use super::rod::Search;
use super::section::Section;
use crate::geometry::vector::{Vec3, add, distance, scale, sub};

/// Towards the tip of a round end the sides draw together by so much more than before it, as a sine: 4 degrees each.
const ROUNDED: f64 = 0.07;
/// Sections that differ by less than this share are as wide.
const LEVEL: f64 = 1e-4;
/// The golden section, and how often what is left of a step is cut by it where a waist is sought.
const GOLDEN: f64 = 0.381_966;
const HALVINGS: usize = 20;

/// The section of least area; what rounds off towards the tip of a closed end is its end, and no neck.
pub(super) fn narrowest(sections: &[Section], tips: [Option<Vec3>; 2]) -> Option<Section> {
    let widest = sections.iter().map(Section::diameter).fold(0.0, f64::max);
    let far = |s: &Section, tip: Vec3| distance(s.centre, tip);
    // What draws together as much before the end as towards it is a taper.
    let before = |tip: Vec3| {
        let inner = sections.iter().filter(|s| far(s, tip) >= 0.5 * widest);
        inner.min_by(|a, b| far(a, tip).total_cmp(&far(b, tip))).map_or(0.0, |s| s.taper)
    };
    let rounded = |s: &&Section| {
        let near = |&tip: &Vec3| far(s, tip) < 0.5 * widest && s.taper > before(tip) + ROUNDED;
        tips.iter().flatten().any(near)
    };
    let least = |all: &mut dyn Iterator<Item = &Section>| all.min_by(|a, b| a.area.total_cmp(&b.area)).cloned();
    least(&mut sections.iter().filter(|s| !rounded(s))).or_else(|| least(&mut sections.iter()))
}

impl Search<'_> {
    /// The narrowest section between the neighbours of one that is narrower than both, by golden sections.
    pub(super) fn waist(&self, sections: &[Section], least: Section) -> Section {
        let at = sections.iter().position(|s| s.centre == least.centre);
        let beside = at.and_then(|i| Some([sections.get(i.checked_sub(1)?)?, sections.get(i + 1)?]));
        let width = least.diameter();
        let is_waist = |of: &[&Section; 2]| {
            of.iter().all(|s| s.diameter() >= width) && of.iter().any(|s| s.diameter() > (1.0 + LEVEL) * width)
        };
        let Some(ends) = beside.filter(is_waist) else {
            return least;
        };
        let [before, after] = ends.map(|s| sub(s.centre, least.centre));
        let look = |t: f64| {
            let way = if t < 0.0 { scale(before, -t) } else { scale(after, t) };
            self.settled(add(least.centre, way), least.axis)
        };
        let (mut from, mut to, mut best) = (-1.0, 1.0, least.clone());
        for _ in 0..HALVINGS {
            let inner = [from + GOLDEN * (to - from), to - GOLDEN * (to - from)];
            let found = inner.map(look);
            let width = |s: &Option<Section>| s.as_ref().map_or(f64::INFINITY, Section::diameter);
            (from, to) = if width(&found[0]) < width(&found[1]) { (from, inner[1]) } else { (inner[0], to) };
            best = found.into_iter().flatten().fold(best, |b, s| if s.area < b.area { s } else { b });
        }
        best
    }
}
