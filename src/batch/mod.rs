//! Many parts in one run: which parts, what is known of them already, one line for each, and tables of all lines.
//!
//! A result is kept under a key made of the part's bytes, its name, everything that was asked, and the version; a result that is
//! there is never computed again, which is also how a run that was killed goes on where it stopped. A result's folder takes
//! its name in one step when all of it is written.

mod index;
mod key;
mod list;
mod merge;
mod row;
mod run;
mod shard;
mod store;
mod table;

pub use index::PARTS;
pub use key::key;
pub use list::{Entry, entries};
pub use merge::{Merged, merge};
pub use row::{Refusal, Row, worst_code};
pub use run::{Contents, Earlier, Finished, Work, names_key, run};
pub use shard::Shard;
pub use store::Store;
pub use table::{csv, json_lines, line, remove_outdated, write_tables};
