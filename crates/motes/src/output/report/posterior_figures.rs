//! Figures of a posterior, as SVG.

use plotters::prelude::*;

use super::style::{Axes, COLOURS, Drawn, INK, extent, is_shown};

const SIZE: (u32, u32) = (440, 250);

const BARS: usize = 40;

/// Intervals of the ranks of draws.
const RANKS: usize = 20;

/// Points of a line or a cloud; more of them would only be a blot.
const MOST_POINTS: usize = 1500;

/// The draws of a parameter as bars of their density, and the prior's density between its quantiles as a line.
pub(super) fn marginal_figure(name: &str, draws: &[f64], prior: &[f64]) -> Drawn<String> {
    let (low, high) = extent(draws.iter().copied());
    let width = (high - low) / BARS as f64;
    let mut counts = [0.0; BARS];
    for value in draws {
        counts[(((value - low) / width) as usize).min(BARS - 1)] += 1.0;
    }
    // The prior's bulk is shown, too, as far as it is not so far away that draws would be a line.
    let reach = 1.5 * (high - low);
    let quantile = |share: f64| prior.get((share * prior.len() as f64) as usize).copied();
    let bulk = |share: f64| quantile(share).filter(|x| !x.is_nan());
    let left = bulk(0.05).map_or(low, |x| x.clamp(low - reach, low));
    let right = bulk(0.95).map_or(high, |x| x.clamp(high, high + reach));
    let density = |count: f64| count / (draws.len() as f64 * width);
    let of_prior: Vec<(f64, f64)> = prior
        .windows(2)
        .filter(|pair| pair[1] > pair[0])
        .map(|pair| (0.5 * (pair[0] + pair[1]), 1.0 / ((prior.len() as f64) * (pair[1] - pair[0]))))
        .filter(|(x, _)| (left..=right).contains(x))
        .collect();
    let top = counts.iter().map(|count| density(*count)).chain(of_prior.iter().map(|point| point.1));
    let (_, top) = extent(top.chain([0.0]));
    let axes = Axes { size: SIZE, title: name, x: left..right, y: 0.0..1.08 * top, names: ["", "density"] };
    axes.figure(|chart| {
        let bars = counts.iter().enumerate().map(|(bar, count)| {
            let left = low + bar as f64 * width;
            Rectangle::new([(left, 0.0), (left + width, density(*count))], COLOURS[0].mix(0.45).filled())
        });
        chart.draw_series(bars)?;
        chart.draw_series(LineSeries::new(of_prior, INK.stroke_width(2)))?;
        Ok(())
    })
}

/// The draws of each chain, one after the other.
pub(super) fn trace_figure(name: &str, chains: &[Vec<f64>]) -> Drawn<String> {
    let (low, high) = extent(chains.iter().flatten().copied());
    let length = chains.first().map_or(1, Vec::len).max(2);
    let axes = Axes { size: SIZE, title: name, x: 0.0..length as f64, y: low..high, names: ["draw", ""] };
    axes.figure(|chart| {
        for (chain, colour) in chains.iter().zip(COLOURS.into_iter().cycle()) {
            let every = chain.len().div_ceil(MOST_POINTS).max(1);
            let points = chain.iter().enumerate().step_by(every).map(|(at, value)| (at as f64, *value));
            chart.draw_series(LineSeries::new(points, colour.mix(0.7).stroke_width(1)))?;
        }
        Ok(())
    })
}

/// How many draws of each chain lie in each twentieth of all draws in order, with what there would be if all chains were alike.
pub(super) fn rank_figure(name: &str, chains: &[Vec<f64>]) -> Drawn<String> {
    let mut order: Vec<(f64, usize)> = Vec::new();
    for (chain, draws) in chains.iter().enumerate() {
        order.extend(draws.iter().map(|value| (*value, chain)));
    }
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut counts = vec![[0.0; RANKS]; chains.len()];
    for (rank, (_, chain)) in order.iter().enumerate() {
        counts[*chain][rank * RANKS / order.len()] += 1.0;
    }
    let even = order.len() as f64 / (RANKS * chains.len().max(1)) as f64;
    let (_, top) = extent(counts.iter().flatten().copied().chain([even]));
    let (all, y) = (order.len().max(1) as f64, 0.0..1.08 * top.max(1.0));
    Axes { size: SIZE, title: name, x: 0.0..all, y, names: ["rank", "draws"] }.figure(|chart| {
        for (of_chain, colour) in counts.iter().zip(COLOURS.into_iter().cycle()) {
            let width = all / RANKS as f64;
            let steps = of_chain
                .iter()
                .enumerate()
                .flat_map(|(at, count)| [(at as f64 * width, *count), ((at + 1) as f64 * width, *count)]);
            chart.draw_series(LineSeries::new(steps, colour.mix(0.8).stroke_width(1)))?;
        }
        chart.draw_series(DashedLineSeries::new([(0.0, even), (all, even)], 3, 3, INK.mix(0.8).into()))?;
        Ok(())
    })
}

/// The draws of two parameters beside each other.
pub(super) fn pair_figure(names: [&str; 2], x: &[f64], y: &[f64]) -> Drawn<String> {
    let ((left, right), (low, high)) = (extent(x.iter().copied()), extent(y.iter().copied()));
    let every = x.len().div_ceil(MOST_POINTS).max(1);
    Axes { size: (440, 320), title: "", x: left..right, y: low..high, names }.figure(|chart| {
        let are_shown = |(x, y): &(&f64, &f64)| is_shown(**x) && is_shown(**y);
        let points = x.iter().zip(y).step_by(every).filter(are_shown);
        chart.draw_series(points.map(|(x, y)| Circle::new((*x, *y), 2, COLOURS[0].mix(0.35).filled())))?;
        Ok(())
    })
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
            rank_figure("a", &[draws.clone(), vec![]]).unwrap();
            pair_figure(["a", "b"], &draws, &draws).unwrap();
        }
    }
}
