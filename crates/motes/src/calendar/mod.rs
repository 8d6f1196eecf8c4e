//! Times as they are written: numbers, dates, months and quarters.

mod following;
mod label;
mod marks;
mod numbers;

pub(crate) use following::following;
pub(crate) use label::{Time, months};
pub(crate) use marks::{days_of, marks};
pub use numbers::NoTime;
pub(crate) use numbers::{has_zone, is_same_time, label_of, time_of};
