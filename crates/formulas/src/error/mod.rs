//! What can be wrong with a model file, in one line that says where and what would be right.

mod composed;
mod fault;
mod nearest;
mod place;
mod problem;

use thiserror::Error;

pub use composed::ComposedProblem;
pub(crate) use fault::{Fault, Section};
pub(crate) use nearest::nearest;
pub use place::Place;
pub(crate) use place::in_line;
pub use problem::Problem;

/// Why a model file gives no model.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FileError {
    /// It could not be read.
    #[error("{file}: {reason}")]
    Read {
        /// The path.
        file: String,
        /// What kind of failure it is to the system.
        kind: std::io::ErrorKind,
        /// The system's reason.
        reason: String,
    },
    /// A file that it names has no inputs as they are needed.
    #[error("{file}: {reason}")]
    Inputs {
        /// The path.
        file: String,
        /// What is wrong.
        reason: String,
    },
    /// It says something that is not a model.
    #[error("{file}{place}: {problem}")]
    Refused {
        /// The path.
        file: String,
        /// Where in the file.
        place: Place,
        /// What is wrong, and what would be right.
        problem: Box<Problem>,
    },
}

impl FileError {
    /// Whether input or output failed: the file itself may be fine.
    pub fn is_io(&self) -> bool {
        matches!(self, FileError::Read { .. })
    }
}
