//! Times as they are written: numbers, dates, months and quarters.

mod label;
mod numbers;

pub(crate) use label::{Time, months};
pub use numbers::NoTime;
pub(crate) use numbers::{has_zone, label_of, time_of};
