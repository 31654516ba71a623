//! Which pictures a report gets, each made by itself.

use super::{lettering, section, view};
use crate::report::exhibit::{Exhibit, Slice, SurfaceMap};
use crate::report::phrase::{self, Numbered};
use crate::report::schema::Report;
use rayon::prelude::*;

/// A finished picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// File name without ending: the name of a check, `thin-wall`; `summary`; `close-thin-wall`; `slice-x`.
    pub name: String,
    /// A PNG file of at most 256 colours.
    pub png: Vec<u8>,
    /// What is to be seen, for those who cannot see it.
    pub alt: String,
}

/// All pictures of a report: one view for each map, the summary, a close-up for each check with findings, one for each slice.
///
/// Views are orthographic, so that their scale bar holds everywhere; each is seen from the side that shows the
/// worst finding of its check.
///
/// # Cost
/// O(facets + pixels) for each picture.
pub fn pictures(report: &Report, exhibit: &Exhibit) -> Vec<Picture> {
    let letters = lettering::Lettering::new();
    let findings = phrase::numbered(report);
    let scene = view::Scene::new(report, exhibit, &findings, &letters);
    let mut jobs: Vec<Job> = match exhibit.maps.len() {
        0 => vec![Job::Overview(None)],
        _ => exhibit.maps.iter().map(|m| Job::Overview(Some(m))).collect(),
    };
    jobs.push(Job::Summary);
    jobs.extend(findings.iter().filter(|n| n.within == 1).map(Job::CloseUp));
    jobs.extend(exhibit.slices.iter().map(Job::Section));
    // Each picture is made by itself, so that the number of threads changes nothing.
    let draw = |job: &Job| match job {
        Job::Overview(map) => scene.overview(*map),
        Job::Summary => scene.summary(),
        Job::CloseUp(finding) => scene.close_up(finding),
        Job::Section(slice) => section::picture(report, slice, &findings, &letters),
    };
    // One by one: a thread that is done takes the next, not half of what is left.
    jobs.par_iter().with_max_len(1).map(draw).collect()
}

/// A small picture of the part for a list of parts.
///
/// # Cost
/// O(facets + pixels).
pub fn thumbnail(report: &Report, exhibit: &Exhibit) -> Picture {
    let letters = lettering::Lettering::new();
    let findings = phrase::numbered(report);
    view::Scene::new(report, exhibit, &findings, &letters).thumbnail()
}

/// One picture to be made.
enum Job<'a> {
    Overview(Option<&'a SurfaceMap>),
    Summary,
    CloseUp(&'a Numbered<'a>),
    Section(&'a Slice),
}
