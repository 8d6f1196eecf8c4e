//! Times as they are written: numbers, dates, months and quarters.

mod following;
mod label;
#[cfg(feature = "report")]
mod marks;
mod numbers;

pub(crate) use following::following;
pub(crate) use label::{Time, months};
#[cfg(feature = "report")]
pub(crate) use marks::{days_of, marks};
pub use numbers::NoTime;
pub(crate) use numbers::{has_zone, is_same_time, label_of, time_of};
