//! Error against time, as SVG.

use plotters::prelude::*;

use super::style::{COLOURS, Drawn, INK, label, mesh, text};
use crate::comparing::EqualTime;

const SIZE: (u32, u32) = (900, 420);

/// The root mean square error of the log-evidence over milliseconds a step, a line for each proposal, both in logarithms.
pub fn error_figure(equal_time: &EqualTime) -> Drawn<String> {
    let shown = |error: f64| error.is_finite() && error > 0.0;
    let points: Vec<(&str, f64, f64)> = equal_time
        .points
        .iter()
        .filter_map(|point| {
            let error = point.error().filter(|error| shown(*error))?;
            Some((point.contender.name(), point.ms_per_step, error))
        })
        .collect();
    let mut names: Vec<&str> = equal_time.points.iter().map(|point| point.contender.name()).collect();
    names.dedup();
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(8)
            .margin_right(18)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d(
                decades(points.iter().map(|point| point.1)).log_scale(),
                decades(points.iter().map(|point| point.2)).log_scale(),
            )?;
        mesh(&mut chart)
            .x_desc("milliseconds a step, one thread")
            .y_desc("error of the log-evidence")
            .x_label_formatter(&|x| label(*x))
            .y_label_formatter(&|y| label(*y))
            .draw()?;
        for (name, colour) in names.iter().zip(COLOURS.into_iter().cycle()) {
            let own = || points.iter().filter(|point| point.0 == *name).map(|point| (point.1, point.2));
            chart
                .draw_series(LineSeries::new(own(), colour.stroke_width(2)))?
                .label(*name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
            chart.draw_series(own().map(|at| Circle::new(at, 3, colour.filled())))?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(INK.mix(0.3))
            .label_font(text(13))
            .draw()?;
        root.present()?;
    }
    Ok(svg)
}

/// Whole decades around all values.
fn decades(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    match low <= high {
        true => 10.0_f64.powf(low.log10().floor())..10.0_f64.powf((1.001 * high).log10().ceil()),
        false => 0.1..1.0,
    }
}
