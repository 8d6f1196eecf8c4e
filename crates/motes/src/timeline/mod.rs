//! From rows of data to the steps of a model: times, sub-steps and inputs.

mod clock;
mod error;
mod file;
mod load;

pub use clock::{Clock, RowTime};
pub use error::{BeyondFile, TimelineError};
pub(crate) use load::Timeline;
