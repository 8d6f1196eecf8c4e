//! figure.svg of estimates over time: windows of one trajectory side by side.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::style::{Area, Drawn, FONT, INK, colour, extent};
use crate::config::{Method, SeriesFigure};
use crate::series::StateSeries;
use crate::store::Record;
use crate::unit::REFERENCE_RUNS;

const PANEL: (u32, u32) = (430, 270);
const HEAD: u32 = 62;
const LEGEND: u32 = 26;
/// The truth is black and thicker than what estimates it.
const TRUTH: u32 = 3;

/// Methods that are shown together, and what they have in common.
struct Group<'a> {
    title: &'static str,
    curves: Vec<(Method, &'a StateSeries)>,
}

/// Draws the truth and the mean of each method's runs with a band that nine tenths of the runs lie in, but for references, which have too
/// few runs for one; a row for families as the paper describes
/// them and one for what is not in the paper, both beside minimum degeneracy.
///
/// # Errors
/// What the drawing library says.
pub(crate) fn series_figure(
    shown: &SeriesFigure,
    title: &str,
    records: &[Record],
) -> Result<String, Box<dyn Error>> {
    let curves: Vec<(Method, &StateSeries)> = records
        .iter()
        .filter_map(|record| {
            let mut states = record.series.iter().flat_map(|series| &series.states);
            Some((record.point.method, states.find(|series| series.state == shown.state)?))
        })
        .collect();
    let beyond = |method: Method| method.is_anchored() || method.is_reference();
    let of = |belongs: &dyn Fn(Method) -> bool| -> Vec<(Method, &StateSeries)> {
        let is_shown = |method| method == Method::MinDegeneracy || belongs(method);
        curves.iter().filter(|(method, _)| is_shown(*method)).copied().collect()
    };
    let groups = [
        Group { title: "as the paper describes them", curves: of(&|method| !beyond(method)) },
        Group { title: "around a linear prediction, and references", curves: of(&beyond) },
    ];
    // Minimum degeneracy alone is shown once.
    let is_new = |group: &&Group<'_>| group.curves.iter().any(|(method, _)| *method != Method::MinDegeneracy);
    let mut rows: Vec<&Group<'_>> = groups.iter().filter(is_new).collect();
    if rows.is_empty() {
        rows.push(&groups[0]);
    }
    let columns = shown.windows.len();
    let size = (PANEL.0 * columns as u32, HEAD + (LEGEND + PANEL.1) * rows.len() as u32);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(HEAD);
        head.draw(&Text::new(title.to_string(), (12, 10), (FONT, 17).into_font().color(&INK)))?;
        let of_references = match curves.iter().any(|(method, _)| method.is_reference()) {
            true => format!("; references: mean of {REFERENCE_RUNS} runs"),
            false => String::new(),
        };
        let note =
            format!("first repetition; mean of all runs, bands span nine tenths of them{of_references}");
        head.draw(&Text::new(note, (12, 36), (FONT, 13).into_font().color(&INK.mix(0.7))))?;
        for (area, group) in body.split_evenly((rows.len(), 1)).iter().zip(&rows) {
            let (legend, plots) = area.split_vertically(LEGEND);
            draw_legend(&legend, group)?;
            for (cell, window) in plots.split_evenly((1, columns)).iter().zip(&shown.windows) {
                draw_window(cell, &shown.state, group, *window)?;
            }
        }
        root.present()?;
    }
    Ok(svg)
}

fn draw_legend(area: &Area<'_>, group: &Group<'_>) -> Drawn {
    let font = |size| (FONT, size).into_font().color(&INK);
    area.draw(&Text::new(format!("{}:", group.title), (12, 6), font(14)))?;
    let mut x = 20 + 7 * group.title.len() as i32;
    let truth = ("truth", BLACK.stroke_width(TRUTH));
    let methods = group.curves.iter().map(|(method, _)| (method.name(), colour(*method).stroke_width(2)));
    for (name, style) in [truth].into_iter().chain(methods) {
        area.draw(&PathElement::new(vec![(x, 13), (x + 20, 13)], style))?;
        let style = font(14).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(name, (x + 24, 13), style))?;
        x += 38 + 7 * name.len() as i32;
    }
    Ok(())
}

fn draw_window(cell: &Area<'_>, state: &str, group: &Group<'_>, [first, last]: [usize; 2]) -> Drawn {
    let part = |values: &[f64]| -> Vec<(f64, f64)> {
        let times = values.iter().enumerate().map(|(t, value)| (t as f64, *value));
        times.skip(first).take(last + 1 - first).collect()
    };
    let bands = || group.curves.iter().filter(|(method, _)| !method.is_reference());
    let all = group.curves.iter().flat_map(|(_, series)| [&series.truth, &series.mean]);
    let all = all.chain(bands().flat_map(|(_, series)| [&series.lo, &series.hi]));
    let (low, high) = extent(all.flat_map(|values| part(values)).map(|(_, value)| value));
    let margin = 0.05 * (high - low).max(1.0);
    let mut chart = ChartBuilder::on(cell)
        .margin(8)
        .margin_right(14)
        .x_label_area_size(34)
        .y_label_area_size(52)
        .build_cartesian_2d(first as f64..last as f64, low - margin..high + margin)?;
    chart
        .configure_mesh()
        .x_desc("t")
        .y_desc(format!("{state}(t)"))
        .x_labels(6)
        .y_labels(6)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .light_line_style(TRANSPARENT)
        .bold_line_style(INK.mix(0.12))
        .axis_style(INK.mix(0.6))
        .label_style((FONT, 12).into_font().color(&INK))
        .draw()?;
    for (method, series) in bands() {
        let band = part(&series.lo).into_iter().chain(part(&series.hi).into_iter().rev());
        chart.draw_series([Polygon::new(band.collect::<Vec<_>>(), colour(*method).mix(0.18))])?;
    }
    for (method, series) in &group.curves {
        chart.draw_series(LineSeries::new(part(&series.mean), colour(*method).stroke_width(2)))?;
    }
    if let Some((_, series)) = group.curves.first() {
        chart.draw_series(LineSeries::new(part(&series.truth), BLACK.stroke_width(TRUTH)))?;
    }
    Ok(())
}
