//! How numbers between 0 and 1 are spread, as SVG.

use plotters::prelude::*;

use super::style::{BLUE, Drawn, INK, TITLE, label, mesh, text};

const SIZE: (u32, u32) = (900, 200);
const BARS: usize = 20;

/// Bars of how many of the places lie between 0 and 0.05, and so on up to 1, with what an even spread would give.
pub(super) fn histogram(title: &str, places: impl Iterator<Item = f64>) -> Drawn<String> {
    let mut counts = [0.0; BARS];
    places.for_each(|place| counts[((place * BARS as f64) as usize).min(BARS - 1)] += 1.0);
    let even = counts.iter().sum::<f64>() / BARS as f64;
    let most = counts.iter().copied().fold(even, f64::max).max(1.0);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(title, text(TITLE))
            .margin(6)
            .margin_right(34)
            .x_label_area_size(24)
            .y_label_area_size(62)
            .build_cartesian_2d(0.0..1.0, 0.0..1.08 * most)?;
        mesh(&mut chart)
            .disable_x_mesh()
            .x_labels(11)
            .y_labels(4)
            .x_label_formatter(&|x| format!("{x:.1}"))
            .y_label_formatter(&|y| label(*y))
            .draw()?;
        let width = 1.0 / BARS as f64;
        let bar = |(at, count): (usize, &f64)| {
            let left = at as f64 * width;
            Rectangle::new(
                [(left + 0.05 * width, 0.0), (left + 0.95 * width, *count)],
                BLUE.mix(0.5).filled(),
            )
        };
        chart.draw_series(counts.iter().enumerate().map(bar))?;
        chart.draw_series(DashedLineSeries::new([(0.0, even), (1.0, even)], 3, 3, INK.mix(0.8).into()))?;
        root.present()?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_places_can_be_drawn() {
        for places in [vec![], vec![0.0, 1.0], vec![0.5; 100]] {
            assert!(histogram("a", places.into_iter()).unwrap().contains("<svg"));
        }
    }
}
