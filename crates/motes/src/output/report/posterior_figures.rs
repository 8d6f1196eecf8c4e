//! Figures of a posterior, as SVG.

use plotters::prelude::*;

use super::style::{Drawn, FONT, INK, label};

/// Colours that people with any sight tell apart (Okabe and Ito), one for each chain.
const CHAINS: [RGBColor; 5] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
];

const BARS: usize = 40;

/// Points of a line or a cloud; more of them would only be a blot.
const MOST_POINTS: usize = 1500;

/// Axes with a title, and what `draw` draws.
macro_rules! chart {
    ($svg:expr, $size:expr, $title:expr, $x:expr, $y:expr, $x_name:expr, $y_name:expr, $chart:ident, $draw:block) => {{
        let root = SVGBackend::with_string($svg, $size).into_drawing_area();
        root.fill(&WHITE)?;
        let mut $chart = ChartBuilder::on(&root)
            .caption($title, (FONT, 15).into_font().color(&INK))
            .margin(6)
            .margin_right(14)
            .x_label_area_size(38)
            .y_label_area_size(66)
            .build_cartesian_2d($x, $y)?;
        $chart
            .configure_mesh()
            .x_desc($x_name)
            .y_desc($y_name)
            .x_labels(6)
            .y_labels(5)
            .x_label_formatter(&|x| label(*x))
            .y_label_formatter(&|y| label(*y))
            .light_line_style(TRANSPARENT)
            .bold_line_style(INK.mix(0.12))
            .axis_style(INK.mix(0.6))
            .label_style((FONT, 12).into_font().color(&INK))
            .draw()?;
        $draw
        root.present()?;
    }};
}

/// Smallest and largest of some numbers, a little apart at least.
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    match low <= high {
        false => (0.0, 1.0),
        true => {
            let least = 1e-9 * (1.0 + low.abs().max(high.abs()));
            if high - low < least { (low - least, high + least) } else { (low, high) }
        }
    }
}

/// The draws of a parameter as bars of their density, and the prior's density between its quantiles as a line.
pub(super) fn marginal_figure(name: &str, draws: &[f64], prior: &[f64]) -> Drawn<String> {
    let (low, high) = extent(draws.iter().copied());
    let width = (high - low) / BARS as f64;
    let mut counts = [0.0; BARS];
    for value in draws {
        counts[(((value - low) / width) as usize).min(BARS - 1)] += 1.0;
    }
    let density = |count: f64| count / (draws.len() as f64 * width);
    let of_prior: Vec<(f64, f64)> = prior
        .windows(2)
        .filter(|pair| pair[1] > pair[0])
        .map(|pair| (0.5 * (pair[0] + pair[1]), 1.0 / ((prior.len() as f64) * (pair[1] - pair[0]))))
        .filter(|(x, _)| (low..=high).contains(x))
        .collect();
    let top = counts.iter().map(|count| density(*count)).chain(of_prior.iter().map(|point| point.1));
    let (_, top) = extent(top.chain([0.0]));
    let mut svg = String::new();
    chart!(&mut svg, (440, 250), name, low..high, 0.0..1.08 * top, "", "density", chart, {
        let bars = counts.iter().enumerate().map(|(bar, count)| {
            let left = low + bar as f64 * width;
            Rectangle::new([(left, 0.0), (left + width, density(*count))], CHAINS[0].mix(0.45).filled())
        });
        chart.draw_series(bars)?;
        chart.draw_series(LineSeries::new(of_prior, INK.stroke_width(2)))?;
    });
    Ok(svg)
}

/// The draws of each chain, one after the other.
pub(super) fn trace_figure(name: &str, chains: &[Vec<f64>]) -> Drawn<String> {
    let (low, high) = extent(chains.iter().flatten().copied());
    let length = chains.first().map_or(1, Vec::len).max(2);
    let mut svg = String::new();
    chart!(&mut svg, (440, 250), name, 0.0..length as f64, low..high, "draw", "", chart, {
        for (chain, colour) in chains.iter().zip(CHAINS.into_iter().cycle()) {
            let every = chain.len().div_ceil(MOST_POINTS).max(1);
            let points = chain.iter().enumerate().step_by(every).map(|(at, value)| (at as f64, *value));
            chart.draw_series(LineSeries::new(points, colour.mix(0.7).stroke_width(1)))?;
        }
    });
    Ok(svg)
}

/// The draws of two parameters beside each other.
pub(super) fn pair_figure(names: [&str; 2], x: &[f64], y: &[f64]) -> Drawn<String> {
    let ((left, right), (low, high)) = (extent(x.iter().copied()), extent(y.iter().copied()));
    let every = x.len().div_ceil(MOST_POINTS).max(1);
    let mut svg = String::new();
    chart!(&mut svg, (440, 320), "", left..right, low..high, names[0], names[1], chart, {
        let points = x.iter().zip(y).step_by(every);
        chart.draw_series(points.map(|(x, y)| Circle::new((*x, *y), 2, CHAINS[0].mix(0.35).filled())))?;
    });
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anything_can_be_drawn() {
        for draws in
            [vec![], vec![1.0], vec![2.0; 9], vec![f64::NAN, 1.0, f64::INFINITY], vec![1e-300, 1e300]]
        {
            marginal_figure("a <name>", &draws, &[0.0, 0.0, 1.0]).unwrap();
            trace_figure("a", &[draws.clone(), vec![]]).unwrap();
            pair_figure(["a", "b"], &draws, &draws).unwrap();
        }
    }
}
