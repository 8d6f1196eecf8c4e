//! The results folder: finished units one a line, each with its length and hash, written by one process or by several.
//!
//! A process that has a folder to itself appends each finished unit to a part file of its own. One of many, on whatever machines, writes
//! a part for each unit, whole or not at all. Merging puts all parts into `units.jsonl`, sorted by key, one line for each unit.

mod contributor;
mod error;
mod folder;
mod line;
mod lines;
mod merged;
mod part;
mod record;

pub use contributor::Contributor;
pub use error::StoreError;
pub use folder::Store;
pub use lines::Contents;
pub use record::{Outcome, Record};
