//! The cover: every place where a wall (or a gap) could be thinner than a limit, searched by branch and bound.
//!
//! A medial ball whose contacts are at least 150° apart has diameter 2r ≥ |pq|, the chord between its contacts.
//! So where no chord between opposing features is shorter than the limit, no wall is; where one is, the patch is
//! sampled by a touching ball (a witness), proved to be blocked by something nearer at a flatter angle, or halved.
//! Facets, edges and vertices are finite, so the search needs no grid and sees walls below any voxel.

use super::feature::Features;
use super::seek::Seeker;
use crate::geometry::MeshDistance;
use crate::geometry::vector::Vec3;
use rayon::prelude::*;

/// Evaluations of the first look at a feature; most are decided by one or two.
pub(super) const FIRST_LOOK: u64 = 256;
/// Further looks at what is still open, each with a larger share.
const LOOKS: usize = 4;

/// What is searched for, all lengths in millimetres.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Limits in increasing order; a sheet is thin if it is below the last.
    pub limits: Vec<f64>,
    /// Sheets up to this thickness are noticed, so that a passing value can be shown.
    pub notice: f64,
    /// What a point of the surface may intrude into a ball: the step of the file's coordinates.
    pub tolerance: f64,
    /// Ball and bound that differ by less are one: half a percent of the widest limit is enough to tell thin from thick.
    pub agree: f64,
    /// Longest edge of the smallest patch: what is thin only over less than this is not looked for.
    pub finest: f64,
    /// Evaluations that the whole search may cost; the first look at each feature is always taken.
    pub budget: u64,
}

impl Question {
    /// How many limits a thickness reaches.
    pub fn class(&self, thickness: f64) -> usize {
        self.limits.partition_point(|&limit| limit <= thickness)
    }

    /// Whether a thickness is below any limit.
    pub fn is_thin(&self, thickness: f64) -> bool {
        thickness < self.widest()
    }

    /// The greatest limit.
    pub fn widest(&self) -> f64 {
        self.limits.last().copied().unwrap_or(0.0)
    }

    /// Longest edge of a sampled patch where sheets are so thick: three quarters of the next limit, or of half the widest.
    pub fn resolution(&self, thickness: f64) -> f64 {
        let next = self.limits.get(self.class(thickness)).copied().unwrap_or(self.widest());
        0.75 * next.max(0.5 * self.widest())
    }

    /// How well ball and bound usually agree in a search for sheets up to so wide.
    pub fn agree_for(widest: f64) -> f64 {
        0.005 * widest
    }

    /// The smallest patch that a search for sheets up to so wide usually asks for: a sixteenth of its resolution.
    pub fn finest_for(widest: f64) -> f64 {
        0.75 * widest / 16.0
    }
}

/// What of the sheets on a feature is sought, where not all is.
#[derive(Clone, Copy)]
pub struct Own<'a> {
    /// Which samples are sought; no others stand for what is passed over because something as thin is known.
    pub counts: &'a dyn Fn(&Sample) -> bool,
    /// The least thickness from a bound on that can be one's own, of what lies within a radius (millimetres) of a point.
    pub from: &'a dyn Fn(Vec3, f64, f64) -> f64,
}

/// What a sample lies in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Contacts at least 150° apart.
    Sheet,
    /// Contacts between 120° and 150° apart: an edge in the making.
    Wedge,
    /// Contacts at least 150° apart of a ball at an edge, or contacts on all sides of it in a plane, beside nearer ones that the surface is in
    /// the way of: where edges go round, what is thin there and nowhere beside it.
    Waist,
    /// Contacts at least 150° apart of a ball beside an edge on which none has such: side by side they lie in a wall whose sides bend towards
    /// its balls at edge after edge.
    Bent,
}

/// A medial ball found on a patch of surface.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    pub shape: Shape,
    pub centre: Vec3,
    /// Contact on the patch and contact opposite.
    pub contacts: [Vec3; 2],
    /// Diameter of the ball: a thickness that is really there.
    pub diameter: f64,
    /// No ball that touches the patch measures less.
    pub low: f64,
    /// Angle between the contacts seen from the centre, radians.
    pub separation: f64,
    /// Area of the patch, mm².
    pub area: f64,
    /// Area of the surface that it stands for, mm²: what is thin of the patch, or lies along it.
    pub thin: f64,
    /// Longest edge of the patch, millimetres.
    pub edge: f64,
    /// Box of the patch.
    pub sides: (Vec3, Vec3),
    /// The feature searched, as an index into the list of all.
    pub feature: u32,
    pub facet: u32,
    pub opposite: u32,
}

impl Sample {
    /// Whether it is a sheet whose two sides are of one body.
    pub(super) fn is_within_a_body(&self, features: &Features) -> bool {
        self.shape == Shape::Sheet && features.body(self.facet) == features.body(self.opposite)
    }
}

/// A patch that may hide something thinner than a limit, left when the budget or the resolution ended.
#[derive(Debug, Clone, Copy)]
pub struct Unresolved {
    pub at: Vec3,
    pub low: f64,
    /// Longest edge of the patch.
    pub extent: f64,
    pub facet: u32,
}

/// A patch that was not sampled, because a sheet as thin as it may hold had been on the same feature.
#[derive(Debug, Clone, Copy)]
pub struct Passed {
    /// Box of the patch.
    pub sides: (Vec3, Vec3),
    /// Its shortest chord.
    pub chord: [Vec3; 2],
    /// No ball that touches it measures less.
    pub low: f64,
    /// How much of it lies on a sheet, mm².
    pub area: f64,
    pub feature: u32,
}

/// All samples thinner than asked, what stayed open, and what it cost.
#[derive(Debug, Clone, Default)]
pub struct Cover {
    pub samples: Vec<Sample>,
    /// Where other sheets on the features of samples may be, each no thinner than one of the samples.
    pub passed: Vec<Passed>,
    pub unresolved: Vec<Unresolved>,
    /// Balls grown and chords searched.
    pub evaluations: u64,
    /// For each facet of the mesh, what is known of the sheet on it.
    pub facets: Vec<FacetSheet>,
}

/// What the search knows of one whole facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacetSheet {
    /// Length of its shortest chord; infinite if none is within notice.
    pub low: f64,
    /// Greatest diameter of a sheet sampled on it; 0 without a sample.
    pub high: f64,
    /// Area of its samples, mm².
    pub sampled_area: f64,
}

impl FacetSheet {
    pub(super) const FREE: FacetSheet = FacetSheet { low: f64::INFINITY, high: 0.0, sampled_area: 0.0 };

    /// The thickness of the whole facet if it hardly varies: samples cover it and agree with the bound within 2 %.
    pub fn constant(&self, area: f64) -> Option<f64> {
        (self.sampled_area >= 0.7 * area && self.high <= 1.02 * self.low).then_some(self.low)
    }
}

impl Cover {
    /// Searches all features of one side of a mesh.
    ///
    /// # Cost
    /// O(log n) for up to 64 features without an opposing one; a thin region costs its area over the resolution squared.
    /// Runs on all cores; the result does not depend on their number.
    pub fn search(mesh: &MeshDistance, features: &Features, question: &Question) -> Cover {
        let seek = |opposite: &mut Option<u32>, feature: u32, budget: u64| {
            Seeker::new(mesh, features, question, budget).seek(feature, opposite)
        };
        // In the order of the tree, so that one search finds in the cache what the one before has read.
        let order = features.may_be_opposed(question.notice);
        // Shares are small, so that no core is left alone with a large one.
        let shares = order.par_iter().with_min_len(8).with_max_len(32);
        let mut found: Vec<(u32, Cover)> =
            shares.map_init(|| None, |near, &f| (f, seek(near, f, FIRST_LOOK))).collect();
        found.par_sort_unstable_by_key(|(feature, _)| *feature);
        // What nothing opposes counts as one evaluation each, however many of them one walk was enough for.
        let unopposed = (features.list.len() - found.len()) as u64;
        let mut all = Cover { evaluations: unopposed, ..Cover::default() };
        // What a look left open shares the rest of the budget; the shares do not depend on the order of work.
        let mut spent = unopposed + found.iter().map(|(_, c)| c.evaluations).sum::<u64>();
        let coarse = |c: &Cover| c.unresolved.iter().any(|u| u.extent > question.finest);
        let mut last = FIRST_LOOK;
        for _ in 0..LOOKS {
            let open: Vec<&mut (u32, Cover)> = found.iter_mut().filter(|(_, c)| coarse(c)).collect();
            let share = question.budget.saturating_sub(spent) / (open.len() as u64).max(1);
            if open.is_empty() || share <= last {
                break;
            }
            last = share;
            let again: Vec<u64> = open
                .into_par_iter()
                .with_max_len(1)
                .map_init(
                    || None,
                    |near, (feature, known)| {
                        let mut cover = seek(near, *feature, share);
                        let cost = cover.evaluations;
                        cover.evaluations += known.evaluations;
                        *known = cover;
                        cost
                    },
                )
                .collect();
            spent += again.iter().sum::<u64>();
        }
        let facets = features.list.iter().map(|f| f.facet as usize + 1).max().unwrap_or(0);
        all.facets = vec![FacetSheet::FREE; facets];
        for (feature, c) in found {
            let Some(feature) = features.list.get(feature as usize) else { continue };
            if let (true, Some(low)) = (feature.is_facet(), c.facets.first().map(|f| f.low)) {
                let own = c.samples.iter().filter(|s| s.shape == Shape::Sheet);
                all.facets[feature.facet as usize] = FacetSheet {
                    low,
                    high: own.clone().map(|s| s.diameter).fold(0.0, f64::max),
                    sampled_area: own.map(|s| s.area).sum(),
                };
            }
            let first = all.samples.len();
            all.samples.extend(c.samples);
            all.stands_for(first, &c.passed, (question, features));
            all.passed.extend(c.passed);
            all.unresolved.extend(c.unresolved);
            all.evaluations += c.evaluations;
        }
        all.leave_to_edges(mesh, features);
        all
    }
}
