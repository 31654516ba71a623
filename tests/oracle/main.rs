//! Closed forms: the truth lies inside every bracket, wherever the part lies and however it is turned.
//!
//! Each case is a shape with a known measure under a random turn and shift; a case counts as violated if the truth lies outside the
//! certified bracket by more than rounding. None may be.

mod fields;
mod medial;
#[path = "../random/mod.rs"]
mod random;
mod thickness;
