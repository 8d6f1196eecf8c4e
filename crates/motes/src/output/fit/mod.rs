//! What a fit found, as tables and as JSON.

mod draws;
mod json;
mod text;

pub use draws::fit_draws;
pub use json::fit_json;
pub use text::{fit_summary, fit_text};
