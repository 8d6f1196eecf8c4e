//! Results as tables, as JSON and as a report.

mod card;
mod csv;
mod evidence;
mod file;
mod fit;
mod fit_comparison;
mod json;
mod number;
#[cfg(feature = "report")]
mod report;
mod summary;
mod table;

pub use card::{card_json, card_text};
pub use csv::{EstimateTable, simulated_table};
pub use evidence::{evidence_json, evidence_table};
pub use file::{Output, Sink};
pub use fit::{
    fit_draws, fit_json, fit_summary, fit_text, maximum_json, maximum_summary, maximum_table, maximum_text,
    profile_table,
};
pub use fit_comparison::{fit_comparison_json, fit_comparison_text};
pub use json::{filter_json, mixture_json};
#[cfg(feature = "report")]
pub use report::{
    CardReport, FitReport, MaximumReport, Report, card_report, error_figure, fit_report, maximum_report,
    report,
};
pub use summary::{filter_settings, filter_summary, plus_minus};
