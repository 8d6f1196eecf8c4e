//! From finished units to tables: every number in long form, medians with deviations, and Markdown to paste.

mod equal_time;
mod markdown;
mod order;
mod redrawn;
mod rows;
mod series;
mod summary;
mod units;

pub(crate) use equal_time::equal_time;
pub(crate) use markdown::markdown;
pub(crate) use order::sort;
pub(crate) use redrawn::redrawn;
pub(crate) use rows::{FailureRow, MetricRow, number, read_rows};
pub(crate) use series::series_csv;
pub(crate) use summary::{Row, summarise, summary_csv};
pub(crate) use units::{failures_csv, timings_csv, units_csv};
