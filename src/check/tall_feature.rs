//! AM205: what stands tall on little.

use super::contract::{Check, Context, Measured, Meta, Outcome, Worst, limits_of};
use super::finding::{Basis, Bracket, Finding, State, Witness};
use super::place::{group_equal, locate, reported};
use super::topple::{round, topple};
use crate::error::Result;
use crate::layer::{Counting, TallFeature as Feature, tall_features};
use crate::part::Part;
use crate::process::Process;
use crate::units::short;

/// A section is round if its greatest width is at most this much larger than its least (an octagon: 1.082).
const ROUND: f64 = 1.09;

/// AM205 `tall-feature`.
pub struct TallFeature;

/// A section longer than this many times its width carries a wall, not a pillar, if one of its outlines is as long by itself.
const WALL: f64 = 4.0;

static META: Meta = Meta {
    code: "AM205",
    name: "tall-feature",
    title: "Pillars that are slender, and parts that topple",
    what: "Finds pillars: pieces of the part that rise high above the section that carries them; the value is height over the section's \
           least width. Where the process says so, it also measures how far inside the footprint the centre of mass lies.",
    why: "A slender pillar sways under the nozzle, the recoater or the peel, and breaks or prints crooked. A part whose centre of mass \
          is not above its footprint stands on its supports alone.",
    how: "Pieces are followed from the top down, on the mesh: a piece is all that is connected above a height, and where it meets another \
          the higher one goes on; of two that are equally high neither does, and what they stand on is a piece of its own. It is judged by its height over the least width of the convex hull of its section, so that legs under a \
          common top, or the four walls of a box, count together, and told at its most slender section. That is sought over all heights \
          down from a layer below its top: stretches of height are divided until no section in them can be more slender by two thousandths than one \
          that was measured. The lowest layer of what joins nothing else is as its section at half its height is; what stands on a point, an edge or a \
          round side, and widens from there without getting as tall as it is wide, is judged from where it widens no more. Sections longer than four times their width carry walls, which \
          `thin-wall` judges, if one of their outlines is as long by itself: two legs beside each other, or posts beside an opening, carry none, \
          however far apart. The length is that of a rectangle with the section's least and greatest width. The centre of mass is exact for a closed mesh, the footprint is the convex hull of the section at half the \
          first layer. Bodies that fuse topple together; as a pillar each is judged by itself.",
    limits: "A section that is about as wide in every direction counts as round, and a round one whose greatest width keeps the limit keeps it. \
             Bracing that touches no layer below, such as supports, is not counted. A piece that carries others is told once, with the \
             highest of them. Where bodies could not be united, or the mesh is open, what is connected is not certain and the value \
             is an estimate. Where 4,096 stretches of height do not show that one outline of long sections is a wall all through, they count as \
             walls.",
    source: "The limits' sources stand in the profile. Least width of a hull by its edges: H. Freeman, R. Shapira, Determining the \
             minimum-area encasing rectangle for an arbitrary closed curve, 1975.",
};

impl Check for TallFeature {
    fn meta(&self) -> &'static Meta {
        &META
    }

    fn run(&self, part: &Part, process: &Process, context: &Context) -> Result<Outcome> {
        let Some(limits) = limits_of(process, "tall-feature") else {
            return Ok(Outcome::NotApplicable("the process sets no limit for it".into()));
        };
        let least = limits.warn.or(limits.fail).unwrap_or(0.0);
        let counting = Counting {
            // A sixth below the limit, so that the worst value is told where it is near.
            least: least / 1.2,
            longest_ratio: WALL,
            layer_mm: process.layer_height_mm,
            tie_mm: part.step(),
        };
        let found = tall_features(part.mesh(), |f| part.bounds_solid(f), part.distance(), &counting);
        let basis = if part.is_plain() { Basis::Certified } else { Basis::Estimated };
        let worst = found.iter().max_by(|a, b| a.slenderness().total_cmp(&b.slenderness()));
        let mut measured = Measured {
            worst: worst.map(|f| Worst { bracket: bracket(f), unit: "1", at: Some(f.foot) }),
            cover: "Every connected piece above every height was judged, by its most slender section.".into(),
            rule: Some("tall-feature"),
            ..Measured::default()
        };
        let pillar = |t: &Feature| {
            // Both lengths are as the file's coordinates tell them, and the facets of a round section may have taken what its corners stand out.
            let narrow = t.width_mm.0.max(part.tie());
            let tie = 1e-6 + part.tie() * (1.0 + t.slenderness()) / narrow + t.slenderness() - as_meant(t);
            let mut f = Finding::judged(META.code, "pillar", bracket(t), basis, limits, "1", tie);
            locate(&mut f, part, context, t.foot, t.extent);
            let layer = |z: f64| (z / process.layer_height_mm).floor().max(0.0) as u64;
            f.layers = Some([layer(t.extent.0[2]), layer(t.extent.1[2])]);
            let top = [t.foot[0], t.foot[1], t.extent.1[2]];
            f.witness =
                Some(Witness { kind: "pillar".into(), points_mm: vec![reported(part, t.foot), reported(part, top)] });
            f.message = format!(
                "pillar of {} mm stands on a section {} mm wide: {} times its width",
                short(round(t.height_mm)),
                short(round(t.width_mm.0)),
                short((10.0 * as_meant(t)).round() / 10.0)
            );
            // As much as clears the limit for certain.
            let (wide, tall) = (t.height_mm / least, t.width_mm.0 * least);
            let share = t.at_most / t.slenderness();
            f.fix = format!(
                "widen it to {} mm between its sides, shorten it to {} mm, or brace it",
                short((100.0 * wide * share).ceil() / 100.0),
                short((100.0 * tall / share).floor() / 100.0)
            );
            f
        };
        let mut findings: Vec<Finding> = found.iter().map(pillar).filter(|f| f.state != State::Pass).collect();
        findings.sort_by(Finding::worst_first);
        measured.findings = group_equal(findings, 0.5);
        for f in measured.findings.iter_mut().filter(|f| f.count > 1) {
            f.message = format!("{} places: {}", f.count, f.message);
        }
        measured.findings.extend(topple(part, process, context));
        Ok(Outcome::Measured(Box::new(measured)))
    }
}

/// The slenderness by the circle that a round section stands for, which its facets lie within.
fn as_meant(f: &Feature) -> f64 {
    let (narrow, broad) = f.width_mm;
    if broad <= ROUND * narrow { f.height_mm / broad } else { f.slenderness() }
}

/// The measured section is there, so its value is reached.
fn bracket(f: &Feature) -> Bracket {
    Bracket::new(as_meant(f), as_meant(f), f.at_most)
}
