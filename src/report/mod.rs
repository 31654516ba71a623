//! The press: one [`Report`], printed as JSON, terminal text, pictures and one HTML page.
//!
//! A [`Report`] is plain data with a published, versioned schema; the same input gives the same bytes. What
//! pictures need beyond it (meshes with a value at every corner, slices) is an [`Exhibit`].

pub mod badge;
pub mod baseline;
mod became;
mod chart;
pub mod conclusion;
mod exhibit;
pub mod glb;
pub mod html;
mod joined;
pub mod json;
pub mod junit;
pub mod markdown;
pub mod markup;
mod matched;
pub mod mount;
mod one_body;
pub mod orient;
pub mod phrase;
pub mod render;
pub mod sarif;
mod schema;
pub mod stances;
pub mod terminal;
pub mod thickness;

pub use exhibit::{Coarsened, Exhibit, Exhibited, Layer, Slice, SurfaceMap, Volume};
pub use schema::{
    Axis3, BaselineReport, BodyReport, ChangeReport, CheckReport, GridReport, LimitReport, PartReport, ProcessReport,
    RefinedReport, Report, SCHEMA, Tool, Verdict, WorstReport,
};
