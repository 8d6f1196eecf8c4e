//! Figures over time, as SVG.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::axis::{MarkedAxis, TimeAxis};
use super::style::{BLUE, Drawn, INK, RED, TITLE, extent, is_shown, label, mesh, text};

const SIZE: (u32, u32) = (900, 230);

/// Points that are drawn one by one; more of them would only be a blot.
const MOST_POINTS: usize = 5000;

/// A mean with a band around it, which has gaps where its limits are NaN.
pub(super) struct Band {
    pub(super) low: Vec<f64>,
    pub(super) high: Vec<f64>,
    pub(super) middle: Vec<f64>,
}

impl Band {
    /// The times between its gaps.
    fn parts(&self) -> Vec<Range<usize>> {
        let is_gap = |time: &usize| self.low[*time].is_nan() || self.high[*time].is_nan();
        let gaps = (0..self.low.len()).filter(is_gap).chain([self.low.len()]);
        let mut start = 0;
        gaps.map(|gap| std::mem::replace(&mut start, gap + 1)..gap).filter(|part| !part.is_empty()).collect()
    }
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<MarkedAxis, RangedCoordf64>>;

/// A state or a measurement over time, and what is predicted after the last row, with what was measured if there is anything.
pub(super) fn band_figure(
    title: &str,
    axis: &TimeAxis,
    band: &Band,
    points: &[Option<f64>],
) -> Drawn<String> {
    let lines = [&band.low, &band.high, &band.middle].into_iter().flatten();
    let all = lines.copied().chain(points.iter().flatten().copied());
    figure(title, axis, all, |chart| {
        for part in band.parts() {
            let limit = |values: &[f64]| at_places(axis, &values[part.clone()], part.start);
            let outline: Vec<_> =
                limit(&band.low).into_iter().chain(limit(&band.high).into_iter().rev()).collect();
            chart.draw_series([Polygon::new(outline, BLUE.mix(0.18))])?;
        }
        for part in parts(&band.middle) {
            let line = at_places(axis, &band.middle[part.clone()], part.start);
            chart.draw_series(LineSeries::new(line, BLUE.stroke_width(2)))?;
        }
        draw_points(chart, axis, points)?;
        if let Some(x) = axis.edge() {
            let (low, high) = (chart.y_range().start, chart.y_range().end);
            chart.draw_series(DashedLineSeries::new([(x, low), (x, high)], 3, 3, INK.mix(0.5).into()))?;
        }
        Ok(())
    })
}

/// An input over time; missing values leave gaps.
pub(super) fn input_figure(title: &str, axis: &TimeAxis, values: &[Option<f64>]) -> Drawn<String> {
    let numbers: Vec<f64> = values.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
    line_figure(title, axis, &numbers)
}

/// A figure of a filter over time.
pub(super) fn line_figure(title: &str, axis: &TimeAxis, values: &[f64]) -> Drawn<String> {
    figure(title, axis, values.iter().copied(), |chart| {
        for part in parts(values) {
            let line = at_places(axis, &values[part.clone()], part.start);
            // A row between two gaps has no line.
            match line.as_slice() {
                [alone] => chart.draw_series([Circle::new(*alone, 1, INK.filled())]).map(drop)?,
                _ => chart.draw_series(LineSeries::new(line, INK.stroke_width(1))).map(drop)?,
            }
        }
        Ok(())
    })
}

/// The stretches of rows that have a number which can be shown.
fn parts(values: &[f64]) -> Vec<Range<usize>> {
    let gaps = (0..values.len()).filter(|row| !is_shown(values[*row])).chain([values.len()]);
    let mut start = 0;
    gaps.map(|gap| std::mem::replace(&mut start, gap + 1)..gap).filter(|part| !part.is_empty()).collect()
}

/// A line's points from the row `first` on. Where there are more than a figure can show, the smallest and the largest of neighbours stand for all of them.
fn at_places(axis: &TimeAxis, values: &[f64], first: usize) -> Vec<(f64, f64)> {
    let finite = values.iter().enumerate().filter(|(_, value)| is_shown(**value));
    let points: Vec<(f64, f64)> = finite.map(|(row, value)| (axis.place(first + row), *value)).collect();
    if points.len() <= MOST_POINTS {
        return points;
    }
    let neighbours = points.chunks((2 * points.len()).div_ceil(MOST_POINTS));
    let ends = |chunk: &[(f64, f64)]| {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let low = chunk.iter().min_by(by_value).copied();
        let high = chunk.iter().max_by(by_value).copied();
        let mut ends = [low, high];
        ends.sort_by(|a, b| a.map(|a| a.0).partial_cmp(&b.map(|b| b.0)).unwrap_or(std::cmp::Ordering::Equal));
        ends.into_iter().flatten()
    };
    neighbours.flat_map(ends).collect()
}

fn draw_points(chart: &mut Chart<'_, '_>, axis: &TimeAxis, points: &[Option<f64>]) -> Drawn<()> {
    let every = points.len().div_ceil(MOST_POINTS).max(1);
    let there = points
        .iter()
        .enumerate()
        .step_by(every)
        .filter_map(|(row, value)| Some((axis.place(row), value.filter(|value| is_shown(*value))?)));
    chart.draw_series(there.map(|at| Circle::new(at, 2, RED.filled())))?;
    Ok(())
}

/// Axes and a title around what `draw` draws.
fn figure(
    title: &str,
    axis: &TimeAxis,
    values: impl Iterator<Item = f64>,
    draw: impl FnOnce(&mut Chart<'_, '_>) -> Drawn<()>,
) -> Drawn<String> {
    let (low, high) = extent(values);
    let mut svg = String::new();
    {
        let root: DrawingArea<SVGBackend<'_>, Shift> =
            SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let margin = 0.05 * (high - low);
        let mut chart = ChartBuilder::on(&root)
            .caption(title, text(TITLE))
            .margin(6)
            .margin_right(34)
            .x_label_area_size(36)
            .y_label_area_size(62)
            .build_cartesian_2d(axis.coordinate(), low - margin..high + margin)?;
        mesh(&mut chart)
            .x_desc(axis.name())
            .y_labels(5)
            .x_label_formatter(&|x| axis.mark(*x))
            .y_label_formatter(&|y| label(*y))
            .draw()?;
        draw(&mut chart)?;
        root.present()?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(rows: usize) -> TimeAxis {
        let times: Vec<f64> = (0..rows).map(|row| row as f64).collect();
        TimeAxis::of(&times, &vec![None; rows], None, &[])
    }

    #[test]
    fn a_long_line_keeps_its_peaks_in_order_of_time() {
        let mut values = vec![0.0; 100_000];
        (values[12_345], values[67_890]) = (9.0, -9.0);
        let points = at_places(&axis(100_000), &values, 0);
        assert!(points.len() <= MOST_POINTS, "{}", points.len());
        assert!(points.contains(&(12_345.0, 9.0)) && points.contains(&(67_890.0, -9.0)));
        assert!(points.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }

    #[test]
    fn nothing_is_drawn_across_gaps() {
        let low = vec![f64::NAN, f64::NAN, 1.0, 1.0, f64::NAN, 1.0];
        let high = vec![f64::NAN, f64::NAN, 2.0, 2.0, f64::NAN, 2.0];
        assert_eq!(parts(&low), [2..4, 5..6]);
        let band = Band { low, high, middle: vec![1.5; 6] };
        assert_eq!(band.parts(), [2..4, 5..6]);
        let gap = Band { low: vec![f64::NAN; 3], high: vec![f64::NAN; 3], middle: vec![7.0, 8.0, 9.0] };
        assert!(gap.parts().is_empty());
        // The mean alone says how far the axis goes.
        assert!(band_figure("state", &axis(3), &gap, &[]).unwrap().contains("8.0"));
        input_figure("input", &axis(3), &[Some(1.0), None, Some(2.0)]).unwrap();
    }

    #[test]
    fn anything_can_be_drawn() {
        for values in [
            vec![],
            vec![1.0],
            vec![0.0; 5],
            vec![f64::NAN, 1e308, -1e308, f64::INFINITY],
            vec![1e-300, 2e-300],
        ] {
            let axis = axis(values.len().max(2));
            line_figure("a <title>", &axis, &values).unwrap();
            let band = Band { low: values.clone(), high: values.clone(), middle: values.clone() };
            band_figure("state", &axis, &band, &[Some(1.0), None]).unwrap();
        }
    }
}
