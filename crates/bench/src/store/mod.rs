//! The results folder: finished units one a line, each with its length and hash, written by one process or by several.
//!
//! A process appends each finished unit to a part file of its own. Merging puts all parts into `units.jsonl`, sorted by key, one
//! line for each unit.

mod error;
mod folder;
mod line;
mod lines;
mod old_layout;
mod part;
mod record;

pub use error::StoreError;
pub use folder::Store;
pub use lines::Contents;
pub use record::{Outcome, Record};
