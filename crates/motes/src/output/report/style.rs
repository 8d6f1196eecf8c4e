//! What figures share: colours, fonts, meshes, numbers on axes.

use std::error::Error;
use std::ops::Range;

use plotters::chart::{ChartContext, MeshStyle};
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::{RGBColor, TextStyle};

/// What drawing gives, or what the drawing library says.
pub(super) type Drawn<T> = Result<T, Box<dyn Error>>;

pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const BLUE: RGBColor = RGBColor(31, 90, 160);
pub(super) const RED: RGBColor = RGBColor(192, 60, 40);

/// Colours that people with any sight tell apart (Okabe and Ito), and that print: one for each line of several.
pub(super) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// A text of that size.
pub(super) fn text(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK)
}

/// The size of titles.
pub(super) const TITLE: u32 = 15;

/// The mesh of all figures; what differs is said before it is drawn.
pub(super) fn mesh<'a, 'b, X, Y, B>(
    chart: &'b mut ChartContext<'a, B, Cartesian2d<X, Y>>,
) -> MeshStyle<'a, 'b, X, Y, B>
where
    B: DrawingBackend,
    X: Ranged + ValueFormatter<X::ValueType>,
    Y: Ranged + ValueFormatter<Y::ValueType>,
{
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(0.12))
        .axis_style(INK.mix(0.6))
        .label_style(text(12));
    mesh
}

/// Two axes of numbers, what they are called, and a title.
pub(super) struct Axes<'a> {
    pub(super) size: (u32, u32),
    pub(super) title: &'a str,
    pub(super) x: Range<f64>,
    pub(super) y: Range<f64>,
    pub(super) names: [&'a str; 2],
}

/// What is drawn between [`Axes`].
pub(super) type Plane<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Axes<'_> {
    /// The figure with what `draw` draws, as SVG.
    pub(super) fn figure(self, draw: impl FnOnce(&mut Plane<'_, '_>) -> Drawn<()>) -> Drawn<String> {
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, self.size).into_drawing_area();
            root.fill(&WHITE)?;
            let mut builder = ChartBuilder::on(&root);
            if !self.title.is_empty() {
                builder.caption(self.title, text(TITLE));
            }
            let below = if self.names[0].is_empty() { 24 } else { 38 };
            let mut chart = builder
                .margin(6)
                .margin_right(14)
                .x_label_area_size(below)
                .y_label_area_size(66)
                .build_cartesian_2d(self.x, self.y)?;
            mesh(&mut chart)
                .x_desc(self.names[0])
                .y_desc(self.names[1])
                .x_labels(6)
                .y_labels(5)
                .x_label_formatter(&|x| label(*x))
                .y_label_formatter(&|y| label(*y))
                .draw()?;
            draw(&mut chart)?;
            root.present()?;
        }
        Ok(svg)
    }
}

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

/// Larger numbers are left out: axes have no room for them.
const LARGEST: f64 = 1e100;

/// Whether an axis has room for a number.
pub(super) fn is_shown(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// Smallest and largest of the numbers that can be shown, a little apart at least.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| is_shown(*value))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    match low <= high {
        false => (0.0, 1.0),
        true => {
            // Differences in the last digits are rounding, and no figure.
            let size = low.abs().max(high.abs());
            let least = if size > 1e-200 { 1e-6 * size } else { 1.0 };
            if high - low < least { (low - least, high + least) } else { (low, high) }
        }
    }
}
