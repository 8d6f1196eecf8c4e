//! A study of warnings: how often a log-evidence is wrong without one, and right with one.

mod case;
mod error;
mod exact;
mod file;
mod runs;
mod study;
mod table;

pub use error::StudyError;
pub use study::{is_study, run_study};
