//! figure.svg where the x axis has one value: methods below each other, a column of plots for each metric.

use std::error::Error;
use std::ops::Range;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::metrics::Metric;
use super::style::{Area, Drawn, FONT, INK, colour, extent, marker};
use crate::config::Method;
use crate::tables::Row;

const HEAD: u32 = 62;
/// For the names of methods.
const NAMES: u32 = 130;
const PLOT: u32 = 215;
/// The height of a method's line, and of what is above and below all lines of a panel.
const LINE: u32 = 24;
const ABOVE: u32 = 34;
const BELOW: u32 = 44;
/// What is more than so many times the median of all methods is off the axis, and written beside its end.
const FAR: f64 = 20.0;

/// Draws medians as dots with bars over the middle half of the repetitions: a row of plots for each panel.
///
/// # Errors
/// What the drawing library says.
pub(super) fn dots(
    title: &str,
    rows: &[Row],
    panels: &[&str],
    methods: &[Method],
    metrics: &[&Metric],
) -> Result<String, Box<dyn Error>> {
    let height = ABOVE + LINE * methods.len() as u32 + BELOW;
    let size = (NAMES + PLOT * metrics.len() as u32, HEAD + height * panels.len() as u32);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(HEAD);
        head.draw(&Text::new(title.to_string(), (12, 10), (FONT, 17).into_font().color(&INK)))?;
        let note = "medians; bars span the middle half of the repetitions";
        head.draw(&Text::new(note, (12, 36), (FONT, 13).into_font().color(&INK.mix(0.7))))?;
        for (area, panel) in body.split_evenly((panels.len(), 1)).iter().zip(panels) {
            let (names, plots) = area.split_horizontally(NAMES);
            draw_names(&names, panel, methods)?;
            for (cell, metric) in plots.split_evenly((1, metrics.len())).iter().zip(metrics) {
                let of_metric = |row: &&Row| row.metric == metric.name && row.n_ok > 0 && is_comparable(row);
                let all: Vec<&Row> = rows.iter().filter(of_metric).collect();
                let here: Vec<&Row> = all.iter().filter(|row| row.panel == *panel).copied().collect();
                draw_plot(cell, metric, methods, &all, &here)?;
            }
        }
        root.present()?;
    }
    Ok(svg)
}

/// A reference has far more particles: what counts those is not comparable.
fn is_comparable(row: &Row) -> bool {
    !row.method.is_reference() || !["ess", "lost_runs"].contains(&row.metric.as_str())
}

fn draw_names(area: &Area<'_>, panel: &str, methods: &[Method]) -> Drawn {
    area.draw(&Text::new(panel.to_string(), (12, 12), (FONT, 14).into_font().color(&INK)))?;
    for (at, method) in methods.iter().enumerate() {
        let y = (ABOVE + LINE * at as u32 + LINE / 2) as i32;
        let style = (FONT, 14).into_font().color(&colour(*method)).pos(Pos::new(HPos::Right, VPos::Center));
        area.draw(&Text::new(method.name(), (NAMES as i32 - 6, y), style))?;
    }
    Ok(())
}

fn draw_plot(cell: &Area<'_>, metric: &Metric, methods: &[Method], all: &[&Row], here: &[&Row]) -> Drawn {
    let mut medians: Vec<f64> = all.iter().map(|row| row.median).collect();
    medians.sort_by(f64::total_cmp);
    let typical = medians.get(medians.len() / 2).copied().unwrap_or(0.0);
    let is_far = |row: &Row| metric.logarithmic && row.median > FAR * typical;
    let near = all.iter().filter(|row| !is_far(row));
    let (_, high) = extent(near.map(|row| row.quartiles.1).filter(|value| value.is_finite()));
    let end = 1.1 * high.max(f64::MIN_POSITIVE);
    let lines: Range<f64> = 0.0..methods.len() as f64;
    let mut chart = ChartBuilder::on(cell)
        .margin_right(16)
        .margin_left(4)
        .margin_top(ABOVE as i32)
        .x_label_area_size(BELOW)
        .build_cartesian_2d(0.0..end, lines)?;
    chart
        .configure_mesh()
        .x_desc(metric.label)
        .x_labels(4)
        .y_labels(0)
        .x_label_formatter(&|value| if end > 10.0 { format!("{value:.0}") } else { format!("{value:.2}") })
        .disable_y_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(0.12))
        .axis_style(INK.mix(0.6))
        .label_style((FONT, 12).into_font().color(&INK))
        .draw()?;
    for (at, method) in methods.iter().enumerate() {
        // From the top downwards.
        let y = methods.len() as f64 - at as f64 - 0.5;
        let Some(row) = here.iter().find(|row| row.method == *method) else { continue };
        if is_far(row) {
            let style =
                (FONT, 12).into_font().color(&colour(*method)).pos(Pos::new(HPos::Right, VPos::Center));
            chart.draw_series([Text::new(format!("{:.0e} →", row.median), (end, y), style)])?;
            continue;
        }
        let bar = [(row.quartiles.0, y), (row.quartiles.1, y)];
        chart.draw_series([PathElement::new(bar, colour(*method).mix(0.45).stroke_width(3))])?;
        chart.draw_series([marker(*method, (row.median, y))])?;
    }
    Ok(())
}
