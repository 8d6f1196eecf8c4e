//! The report: one HTML file with figures, that needs nothing else.

mod axis;
mod card;
mod error_figure;
mod estimates;
mod figures;
mod fit;
mod histogram;
mod maximum;
mod page;
mod posterior_figures;
mod style;

pub use card::{CardReport, card_report};
pub use error_figure::error_figure;
pub use estimates::{Report, report};
pub use fit::{FitReport, fit_report};
pub use maximum::{MaximumReport, maximum_report};
