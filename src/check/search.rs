//! The one search on each side of the surface that all checks of walls and gaps share.

use super::contract::{Context, limits_of};
use super::detail::{raised_width, rule_width};
use crate::medial::{Question, Side};
use crate::part::Part;
use crate::process::Process;

/// A limit wider than this many times the widest of thin-wall or narrow-gap is searched for on its own.
const JOINED: f64 = 2.5;

/// Boxes and facets that an evaluation visits, about; budgets count them as samples.
pub(super) const BOXES: u64 = 64;

/// The question that finds everything below `limits` (millimetres): the one all checks share if it holds them.
pub fn question(part: &Part, process: &Process, context: &Context, side: Side, limits: &[f64]) -> Question {
    let shared = asked(shared_limits(process, side), part, context);
    let own = asked(limits.to_vec(), part, context);
    if own.limits.iter().all(|l| shared.limits.contains(l)) { shared } else { own }
}

fn asked(mut limits: Vec<f64>, part: &Part, context: &Context) -> Question {
    let tie = part.tie();
    limits.retain(|l| *l > 0.0);
    limits.sort_by(f64::total_cmp);
    limits.dedup();
    let widest = limits.last().copied().unwrap_or(0.0);
    Question {
        // Up to a quarter more is noticed, so that what passes can be named.
        notice: 1.25 * widest,
        agree: Question::agree_for(widest - tie),
        finest: Question::finest_for(widest - tie),
        limits: limits.into_iter().map(|l| l - tie).collect(),
        tolerance: 2.0 * part.step(),
        budget: context.refine / BOXES,
    }
}

/// The limits of the process that are searched for on one side.
fn shared_limits(process: &Process, side: Side) -> Vec<f64> {
    let both = |rule| limits_of(process, rule).map(|l| [l.fail, l.warn]).into_iter().flatten().flatten();
    let (mut limits, detail): (Vec<f64>, f64) = match side {
        Side::Material => (both("thin-wall").collect(), raised_width(process)),
        Side::Void => (
            both("narrow-gap").chain(both("narrow-gap.between-bodies")).collect(),
            rule_width(process, "lost-feature.engraved"),
        ),
    };
    let widest = limits.iter().copied().fold(0.0, f64::max);
    let others = both("offset").map(|l| 2.0 * l).chain([detail]);
    limits.extend(others.filter(|l| *l <= JOINED * widest));
    limits
}
