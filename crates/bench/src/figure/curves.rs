//! figure.svg: panels side by side, and below the paper's metric those that show what it hides.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;

use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::across::{Across, Scale};
use super::counts;
use super::dots::dots;
use super::metrics::{METRICS, Metric};
use super::style::{Area, Drawn, FONT, INK, colour, extent, marker};
use crate::config::{Axis, Method, Plan};
use crate::tables::Row;

const PANEL: (u32, u32) = (380, 260);
const HEAD: u32 = 84;
/// The height of a line of the legend.
const LINE: u32 = 20;

/// What all charts of a figure have in common.
struct Common<'a> {
    axis: Axis,
    scale: Scale,
    methods: &'a [Method],
    /// The most repetitions that any point has: those with fewer say how many.
    repetitions: usize,
    /// The repetitions of the methods that have fewer at all of their points, by name: the legend says how many.
    of_methods: &'a BTreeMap<&'static str, usize>,
}

/// Draws medians, a curve for each method, with bars over the middle half of the repetitions. On a logarithmic axis a standard
/// deviation larger than the median, as here, would have no lower end; the tables have it.
///
/// # Errors
/// What the drawing library says.
pub(crate) fn figure(plan: &Plan, title: &str, rows: &[Row]) -> Result<String, Box<dyn Error>> {
    let mut panels: Vec<&str> = Vec::new();
    let mut methods: Vec<Method> = Vec::new();
    for row in rows {
        if !panels.contains(&row.panel.as_str()) {
            panels.push(&row.panel);
        }
        if !methods.contains(&row.method) {
            methods.push(row.method);
        }
    }
    // What never happened has no plot.
    let there = |metric: &&Metric| {
        let of = |row: &Row| row.metric == metric.name && row.n_ok > 0;
        rows.iter().any(|row| of(row) && (metric.name != "lost_runs" || row.quartiles.1 > 0.0))
    };
    let metrics: Vec<&Metric> = METRICS.iter().filter(there).collect();
    let xs: BTreeSet<usize> = rows.iter().map(|row| row.x).collect();
    if xs.len() == 1 {
        return dots(title, rows, &panels, &methods, &metrics);
    }
    let width = PANEL.0 * panels.len().max(2) as u32;
    let repetitions = rows.iter().map(|row| row.n_ok).max().unwrap_or(0);
    let is_shown = |row: &&Row| metrics.iter().any(|metric| metric.name == row.metric) && row.n_ok > 0;
    let shown = rows.iter().filter(is_shown).map(|row| (row.method.name(), row.n_ok));
    let of_methods = &counts::uniform(shown, repetitions);
    let legend = legend(&methods, of_methods, width as i32);
    let lines = legend.last().map_or(0, |(_, _, line)| *line);
    let height = HEAD + LINE * lines;
    let size = (width, height + PANEL.1 * metrics.len() as u32);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(height);
        let scale = Scale::of(&xs);
        let common = Common { axis: plan.experiment.axis, scale, methods: &methods, repetitions, of_methods };
        let uneven = rows.iter().filter(is_shown).any(|row| row.n_ok < repetitions);
        draw_head(&head, title, &legend, uneven)?;
        let cells = body.split_evenly((metrics.len(), panels.len()));
        for (at, cell) in cells.iter().enumerate() {
            let (metric, panel) = (metrics[at / panels.len()], panels[at % panels.len()]);
            let of_metric: Vec<&Row> =
                rows.iter().filter(|row| row.metric == metric.name && row.n_ok > 0).collect();
            draw_cell(cell, &common, metric, panel, &of_metric)?;
        }
        root.present()?;
    }
    Ok(svg)
}

/// What the legend says of each method, and where: at which place of which of its lines.
fn legend(
    methods: &[Method],
    of_methods: &BTreeMap<&'static str, usize>,
    width: i32,
) -> Vec<(Method, (String, i32), u32)> {
    let (mut x, mut line) = (12, 0);
    let mut entries = Vec::with_capacity(methods.len());
    for &method in methods {
        let name = match of_methods.get(method.name()) {
            Some(repetitions) => format!("{} (n = {repetitions})", method.name()),
            None => method.name().to_string(),
        };
        let own = 52 + 8 * name.len() as i32;
        if x + own > width && x > 12 {
            (x, line) = (12, line + 1);
        }
        entries.push((method, (name, x), line));
        x += own;
    }
    entries
}

/// Title and legend.
fn draw_head(head: &Area<'_>, title: &str, legend: &[(Method, (String, i32), u32)], uneven: bool) -> Drawn {
    head.draw(&Text::new(title.to_string(), (12, 10), (FONT, 17).into_font().color(&INK)))?;
    let mut below = 0;
    for (method, (name, x), line) in legend {
        below = (LINE * line) as i32;
        let colour = colour(*method);
        head.draw(&PathElement::new(vec![(*x, 46 + below), (x + 26, 46 + below)], colour.stroke_width(2)))?;
        head.draw(&marker(*method, (x + 13, 46 + below)))?;
        head.draw(&Text::new(name.clone(), (x + 32, 39 + below), (FONT, 14).into_font().color(&INK)))?;
    }
    let note = match uneven {
        true => "medians; bars span the middle half of the repetitions, fewer where n says so",
        false => "medians; bars span the middle half of the repetitions",
    };
    head.draw(&Text::new(note, (12, 62 + below), (FONT, 13).into_font().color(&INK.mix(0.7))))?;
    Ok(())
}

fn draw_cell(cell: &Area<'_>, common: &Common<'_>, metric: &Metric, panel: &str, rows: &[&Row]) -> Drawn {
    let x = Across::new(common.scale, rows.iter().map(|row| row.x).collect());
    let here: Vec<&Row> = rows.iter().filter(|row| row.panel == panel).copied().collect();
    // One scale for all panels of a metric, so that they can be compared.
    if metric.logarithmic {
        let (low, _) = extent(rows.iter().map(|row| row.quartiles.0));
        let (_, high) = extent(rows.iter().map(|row| row.quartiles.1));
        // A narrow range is widened to whole decades, so that there are two labelled lines to read it by.
        let (low, high) = match high < 30.0 * low {
            true => {
                let whole = |value: f64, round: fn(f64) -> f64| 10_f64.powf(round(value.log10()));
                // A hair beyond, so that rounding does not leave the line at the end out.
                (0.99 * whole(low / 1.05, f64::floor), 1.01 * whole(high * 1.05, f64::ceil))
            }
            false => (low / 1.5, high * 1.5),
        };
        let y = (low..high).log_scale();
        draw_chart(cell, common, metric, panel, &here, x, y)
    } else {
        let (_, high) = extent(rows.iter().map(|row| row.quartiles.1));
        draw_chart(cell, common, metric, panel, &here, x, 0.0..high * 1.05)
    }
}

fn draw_chart<Y>(
    cell: &Area<'_>,
    common: &Common<'_>,
    metric: &Metric,
    panel: &str,
    rows: &[&Row],
    x: Across,
    y: Y,
) -> Drawn
where
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let spread = x.range().end - x.range().start;
    let last = rows.iter().map(|row| row.x).max();
    let mut chart = ChartBuilder::on(cell)
        .margin(8)
        .margin_right(14)
        .caption(format!("{panel}: {}", metric.label), (FONT, 14).into_font().color(&INK))
        .x_label_area_size(34)
        .y_label_area_size(48)
        .build_cartesian_2d(x, y)?;
    let label = |y: &f64| if metric.logarithmic { format!("{y:.0e}") } else { format!("{y}") };
    chart
        .configure_mesh()
        .x_desc(common.axis.symbol())
        .y_labels(5)
        .x_label_formatter(&|&position| common.scale.label(position))
        .y_label_formatter(&label)
        .light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(0.12))
        .axis_style(INK.mix(0.6))
        .label_style((FONT, 12).into_font().color(&INK))
        .draw()?;
    let is_in_legend = |row: &Row| common.of_methods.contains_key(row.method.name());
    let unsaid = rows.iter().filter(|row| !is_in_legend(row));
    let shared = counts::shared(unsaid.map(|row| (row.x, row.n_ok)), common.repetitions);
    let at_x = |x: usize| common.scale.position(x);
    for (at, &method) in common.methods.iter().enumerate() {
        let colour = colour(method);
        // Bars of different methods stand beside each other.
        let shift = spread * 0.008 * (at as f64 - 0.5 * (common.methods.len() as f64 - 1.0));
        let mut points: Vec<(f64, &Row)> =
            rows.iter().filter(|row| row.method == method).map(|row| (at_x(row.x) + shift, *row)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (x, row) in &points {
            let ends = [(*x, row.quartiles.0), (*x, row.quartiles.1)];
            chart.draw_series([PathElement::new(ends, colour.mix(0.45).stroke_width(2))])?;
        }
        let line = points.iter().map(|(x, row)| (*x, row.median));
        chart.draw_series(LineSeries::new(line.clone(), colour.stroke_width(2)))?;
        chart.draw_series(line.map(|point| marker(method, point)))?;
        let is_alone = |row: &Row| {
            row.n_ok < common.repetitions && !is_in_legend(row) && shared.get(&row.x) != Some(&row.n_ok)
        };
        chart.draw_series(points.iter().filter(|(_, row)| is_alone(row)).map(|(x, row)| {
            // The last one would not have room to the right.
            let (side, anchor) = if Some(row.x) == last { (-6, HPos::Right) } else { (6, HPos::Left) };
            EmptyElement::at((*x, row.median)) + count(row.n_ok, (side, 4), anchor, &colour)
        }))?;
    }
    let floor = chart.y_range().start;
    chart.draw_series(shared.iter().map(|(&x, &repetitions)| {
        EmptyElement::at((at_x(x), floor)) + count(repetitions, (0, -14), HPos::Center, &INK)
    }))?;
    Ok(())
}

fn count(
    repetitions: usize,
    offset: (i32, i32),
    side: HPos,
    colour: &RGBColor,
) -> Text<'static, (i32, i32), String> {
    let style = (FONT, 11).into_font().color(colour).pos(Pos::new(side, VPos::Top));
    Text::new(format!("n = {repetitions}"), offset, style)
}
