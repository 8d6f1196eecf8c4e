//! The maximum of a likelihood as a page.

use plotters::prelude::*;

use super::estimates::{Report, all_series};
use super::page::Page;
use super::style::{Axes, BLUE, Drawn, INK, extent};
use crate::fitting::{MaximumFit, MaximumParameter, MaximumProfilePoint};
use crate::output::fit::{maximum_figures, maximum_summary};
use crate::output::table::Table;

/// What a page of a maximum shows.
pub struct MaximumReport<'a> {
    /// The model's name.
    pub model: &'a str,
    /// What was found.
    pub found: &'a MaximumFit,
    /// The data filtered there, with what was expected of measurements where that was asked for.
    pub states: Option<Report<'a>>,
    /// Settings, a name and a value each.
    pub settings: &'a [(String, String)],
    /// The command that made the report.
    pub command: &'a str,
}

/// The maximum as HTML: its table, and the profile of each parameter.
///
/// # Errors
/// What the drawing library says.
pub fn maximum_report(report: &MaximumReport<'_>) -> Result<String, Box<dyn std::error::Error>> {
    let found = report.found;
    let mut page = Page::new(&format!("Maximum of the likelihood of {}", report.model));
    page.pairs(&maximum_summary(found));
    let warnings: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
    page.warnings(&warnings);
    page.heading("Parameters");
    let Table { header, rows } = maximum_figures(found);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.table(&header, rows.into_iter());
    page.heading("Profiles");
    page.note(
        "Points: the largest log-likelihood over all other parameters, with two standard errors. Dotted lines: the ends of the interval.",
    );
    for (at, name) in found.names.iter().enumerate().filter(|(at, _)| !found.profiles[*at].is_empty()) {
        page.figure(&profile_figure(name, &found.profiles[at], &found.parameters[at])?, "");
    }
    if let Some(states) = &report.states {
        page.heading("States and measurements at the maximum");
        all_series(&mut page, states)?;
    }
    page.heading("Settings");
    page.pairs(report.settings);
    page.command(report.command);
    Ok(page.finish())
}

/// A profile with its interval.
fn profile_figure(name: &str, points: &[MaximumProfilePoint], of: &MaximumParameter) -> Drawn<String> {
    let ends = [of.low, of.high];
    let (left, right) =
        extent(points.iter().map(|point| point.value).chain(ends.iter().filter_map(|end| *end)));
    let reach = |point: &MaximumProfilePoint, side: f64| {
        (point.value, point.log_likelihood + side * 2.0 * point.standard_error)
    };
    let of_errors = points.iter().flat_map(|point| [reach(point, -1.0).1, reach(point, 1.0).1]);
    let (low, high) = extent(of_errors);
    let margin = 0.05 * (high - low);
    let (bottom, top) = (low - margin, high + margin);
    let axes =
        Axes { size: (440, 280), title: name, x: left..right, y: bottom..top, names: ["", "log-likelihood"] };
    axes.figure(|chart| {
        let line = points.iter().map(|point| (point.value, point.log_likelihood));
        chart.draw_series(LineSeries::new(line.clone(), BLUE.mix(0.5).stroke_width(1)))?;
        let errors = points
            .iter()
            .map(|point| PathElement::new([reach(point, -1.0), reach(point, 1.0)], BLUE.stroke_width(2)));
        chart.draw_series(errors)?;
        chart.draw_series(line.map(|at| Circle::new(at, 3, BLUE.filled())))?;
        for end in ends.into_iter().flatten() {
            let across = [(end, bottom), (end, top)];
            chart.draw_series(DashedLineSeries::new(across, 3, 3, INK.mix(0.7).into()))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_profile_can_be_drawn() {
        let point = |value: f64, standard_error: f64| MaximumProfilePoint {
            value,
            log_likelihood: -value * value,
            standard_error,
        };
        let of = |low, high| MaximumParameter { estimate: 0.0, low, high };
        for points in [vec![], vec![point(1.0, 0.0)], vec![point(-1.0, 0.3), point(2.0, f64::NAN)]] {
            profile_figure("a <name>", &points, &of(None, None)).unwrap();
            profile_figure("a", &points, &of(Some(-5.0), Some(f64::INFINITY))).unwrap();
        }
    }
}
