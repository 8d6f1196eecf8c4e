//! The horizontal axis of curves: where something was measured.

use std::collections::BTreeSet;
use std::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::Ranged;

/// Labels that a panel has room for below it.
const MOST_TICKS: usize = 10;
/// From this ratio of the largest x to the smallest on, a linear axis would crowd the small ones.
const WIDE: usize = 20;

/// How x becomes a position along the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scale {
    Linear,
    Logarithmic,
}

impl Scale {
    pub(super) fn of(xs: &BTreeSet<usize>) -> Scale {
        match (xs.first(), xs.last()) {
            (Some(&low), Some(&high)) if low > 0 && high / low >= WIDE => Scale::Logarithmic,
            _ => Scale::Linear,
        }
    }

    pub(super) fn position(self, x: usize) -> f64 {
        match self {
            Scale::Linear => x as f64,
            Scale::Logarithmic => (x as f64).log10(),
        }
    }

    pub(super) fn label(self, position: f64) -> String {
        match self {
            Scale::Linear => format!("{position:.0}"),
            Scale::Logarithmic => format!("{:.0}", 10_f64.powf(position)),
        }
    }
}

/// The library's own ticks are at round numbers, where nothing may have been measured.
pub(super) struct Across {
    range: RangedCoordf64,
    ticks: Vec<f64>,
}

impl Across {
    /// An axis with a tick at each x, or at only some of them, if there is no room for so many labels.
    pub(super) fn new(scale: Scale, xs: BTreeSet<usize>) -> Across {
        let positions: Vec<f64> = xs.into_iter().map(|x| scale.position(x)).collect();
        let low = positions.first().copied().unwrap_or_default();
        let high = positions.last().copied().unwrap_or_default();
        let margin = 0.06 * if high > low { high - low } else { 1.0 };
        let every = positions.len().div_ceil(MOST_TICKS).max(1);
        let range = low - margin..high + margin;
        Across { range: range.into(), ticks: positions.into_iter().step_by(every).collect() }
    }
}

impl Ranged for Across {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.range.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.range()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_axis_is_logarithmic_and_labels_what_was_measured() {
        let wide: BTreeSet<usize> = [50, 500, 5000].into();
        let scale = Scale::of(&wide);
        assert_eq!(scale, Scale::Logarithmic);
        let axis = Across::new(scale, wide);
        let labels: Vec<String> = axis.ticks.iter().map(|&tick| scale.label(tick)).collect();
        assert_eq!(labels, ["50", "500", "5000"]);
        assert!((axis.ticks[1] - axis.ticks[0] - (axis.ticks[2] - axis.ticks[1])).abs() < 1e-12);
        assert_eq!(Scale::of(&[10, 20, 50].into()), Scale::Linear);
    }
}
