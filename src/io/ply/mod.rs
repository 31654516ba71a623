//! PLY (Stanford polygon format): ASCII, and binary of either byte order.
//!
//! Our own reader, because it has to skip any element and property by its size, to settle counts against
//! the bytes that are left before anything is allocated, and to name the byte or line of a fault.

mod body;
mod header;
mod read;
mod write;

pub use read::read;
pub use write::write;
