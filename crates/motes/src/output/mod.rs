//! Results as tables, as JSON and as a report.

mod card;
mod csv;
mod evidence;
mod file;
mod json;
mod number;
mod report;
mod summary;

pub use card::{card_json, card_text};
pub use csv::{EstimateTable, simulated_table};
pub use evidence::{evidence_json, evidence_table};
pub use file::{Output, Sink};
pub use json::filter_json;
pub use report::{CardReport, Report, card_report, error_figure, report};
pub use summary::{filter_settings, filter_summary};
