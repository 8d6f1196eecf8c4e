//! What a fit found, as tables and as JSON.

mod draws;
mod json;
mod maximum;
mod text;

pub use draws::fit_draws;
pub use json::fit_json;
#[cfg(feature = "report")]
pub(super) use maximum::maximum_figures;
pub use maximum::{maximum_json, maximum_summary, maximum_table, maximum_text, profile_table};
#[cfg(feature = "report")]
pub(super) use text::fit_figures;
pub use text::{fit_summary, fit_text};
