//! What a tool, a nozzle or a probe can reach: tools, setups, obstacles, inaccessibility, reach, removal of supports,
//! and which way to print.
//!
//! A tool T at rotation R and translation t is *free* if vol(X ∩ (R·T + t)) = 0: touching is no collision. What is said of
//! a pose is certified by the part's inner and outer cubes; what is said of a place holds for the directions listed.

mod clearance;
mod direction;
mod disc;
mod flat_end;
mod measure;
mod meridian;
mod obstacle;
mod orient;
mod placed;
mod pose;
mod question;
mod reach;
mod removal;
mod rest;
mod rise;
mod setup;
mod sight;
mod stack;
mod station;
mod struck;
mod surface;
mod tool;
mod touch;
mod turn;
mod unreachable;
mod up;

pub use direction::{FACES, flat_face_normals};
pub use disc::Disc;
pub use measure::{Measure, inaccessibility, overlap_counts, overlap_counts_by_transform};
pub use meridian::{Meridian, Outline, Piece, Role, Support};
pub use obstacle::{Inflation, Trio};
pub use orient::{Orientation, Orientations, orientations, standing, stood, upright};
pub use pose::{
    Rotation, Turns, about, axis_directions, axis_rotations, fibonacci, lattice_directions, quarter_turns, square_to,
    super_fibonacci, within_tilt,
};
pub use question::{Footing, Liquid, Question, self_holding, support_angle};
pub use reach::{Reach, Standing, State, Touching, reach};
pub use removal::{Columns, Keeper, Removal, Stuck, remove};
pub use setup::Setup;
pub use sight::{grain_reach, line_of_sight};
pub use stack::{Run, Sense, Stack};
pub use station::{Stand, Station};
pub use struck::{Room, gets_in, rooms, strike};
pub use surface::{Patch, patches};
pub use tool::{Basis, Body, SharpPoint, Tool};
pub use touch::{clear_aside, drawn_back};
pub use turn::{Turn, flattest, least_hanging};
pub use up::{Up, up_option};
