//! What all figures have in common: font, ink, colours and ranges.

use std::error::Error;

use plotters::prelude::{Circle, Color, DrawingArea, RGBColor, SVGBackend};

use crate::config::Method;

pub(super) const FONT: &str = "sans-serif";
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);

/// Whether something could be drawn.
pub(super) type Drawn = Result<(), Box<dyn Error>>;

/// A part of a figure.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// Smallest and largest value; 0 and 1 of nothing.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let found = values.fold(None, |extent: Option<(f64, f64)>, value| {
        Some(extent.map_or((value, value), |(low, high)| (low.min(value), high.max(value))))
    });
    found.unwrap_or((0.0, 1.0))
}

/// The colour of a method.
pub(super) fn colour(method: Method) -> RGBColor {
    let [red, green, blue] = method.colour();
    RGBColor(red, green, blue)
}

/// Filled for learned proposals, hollow for designed ones.
pub(super) fn marker<C>(method: Method, at: C) -> Circle<C, i32> {
    let colour = colour(method);
    Circle::new(at, 4, if method.is_learned() { colour.filled() } else { colour.stroke_width(2) })
}

#[cfg(test)]
mod tests {
    use super::extent;

    #[test]
    fn extents() {
        assert_eq!(extent([2.0, -1.0, 5.0].into_iter()), (-1.0, 5.0));
        assert_eq!(extent([].into_iter()), (0.0, 1.0));
    }
}
