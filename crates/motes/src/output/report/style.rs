//! What figures share.

use std::error::Error;

use plotters::style::RGBColor;

/// What drawing gives, or what the drawing library says.
pub(super) type Drawn<T> = Result<T, Box<dyn Error>>;

pub(super) const FONT: &str = "sans-serif";
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);

/// A number on an axis.
pub(super) fn label(value: f64) -> String {
    let size = value.abs();
    match size {
        0.0 => "0".into(),
        size if !(1e-3..1e5).contains(&size) => format!("{value:.1e}"),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 1.0 => format!("{value:.1}"),
        _ => format!("{value:.3}"),
    }
}
