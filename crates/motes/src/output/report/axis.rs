//! Where rows stand on the axis of time: at their dates, at the numbers that label them, or at t.

use std::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::coord::types::RangedCoordf64;

use crate::calendar::{days_of, marks};
use crate::estimate::Forecast;

/// Marks that there is room for.
const MARKS: usize = 9;

/// The axis of the rows of a series, and of what is predicted after them.
pub(super) struct TimeAxis {
    /// What it is called.
    name: String,
    /// Where each row stands, and behind them each forecast.
    places: Vec<f64>,
    /// How many of them are rows.
    pub(super) rows: usize,
    /// Round places, with what they are called.
    marks: Vec<(f64, String)>,
}

impl TimeAxis {
    /// That of rows at these times, which may be labelled in a column of that name, and of forecasts.
    pub(super) fn of(
        times: &[f64],
        labels: &[Option<&str>],
        column: Option<&str>,
        forecasts: &[Forecast],
    ) -> Self {
        let labelled = |of: &dyn Fn(&str) -> Option<f64>| -> Option<Vec<f64>> {
            let found: Vec<f64> = labels.iter().map(|label| of((*label)?)).collect::<Option<_>>()?;
            let is_increasing = found.windows(2).all(|pair| pair[0] <= pair[1]);
            (is_increasing && found.first() < found.last()).then_some(found)
        };
        let number = |label: &str| label.trim().parse().ok().filter(|value: &f64| value.is_finite());
        let dates = labelled(&days_of);
        let has_dates = dates.is_some();
        let numbers = dates.or_else(|| labelled(&number));
        let name = column.filter(|_| numbers.is_some()).unwrap_or("t").to_string();
        let mut places = numbers.unwrap_or_else(|| times.to_vec());
        let (last, gap) = (times.len().saturating_sub(1), times.len().saturating_sub(2));
        if let (Some(place), Some(time)) = (places.last().copied(), times.last().copied()) {
            // What stands behind the last row goes on as the last gap did.
            let (of_place, of_time) = (place - places[gap], time - times[gap]);
            let scale = if last > gap && of_time > 0.0 { of_place / of_time } else { 1.0 };
            places.extend(forecasts.iter().map(|ahead| place + scale * (ahead.time - time)));
        }
        let mut axis = TimeAxis { name, places, rows: times.len(), marks: vec![] };
        let Range { start, end } = axis.range();
        axis.marks = if has_dates { marks(start, end, MARKS) } else { round_numbers(start, end) };
        axis
    }

    /// What it is called.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Where a row, or a forecast behind the rows, stands.
    pub(super) fn place(&self, at: usize) -> f64 {
        self.places[at]
    }

    /// Between the last row and the first forecast, where there is one.
    pub(super) fn edge(&self) -> Option<f64> {
        let (last, first) = (self.places.get(self.rows.checked_sub(1)?)?, self.places.get(self.rows)?);
        Some(0.5 * (last + first))
    }

    /// From half a gap before the first row to half a gap behind the last.
    fn range(&self) -> Range<f64> {
        let (first, last) = (self.places.first().copied(), self.places.last().copied());
        let (first, last) = (first.unwrap_or(0.0), last.unwrap_or(0.0));
        let gap = match self.places.len() {
            0 | 1 => 1.0,
            count => (last - first) / (count - 1) as f64,
        };
        let margin = if gap > 0.0 { 0.5 * gap } else { 0.5 };
        first - margin..last + margin
    }

    /// For drawing.
    pub(super) fn coordinate(&self) -> MarkedAxis {
        MarkedAxis {
            numbers: self.range().into(),
            marks: self.marks.iter().map(|(place, _)| *place).collect(),
        }
    }

    /// What a mark is called.
    pub(super) fn mark(&self, place: f64) -> String {
        self.marks.iter().find(|(at, _)| *at == place).map_or(String::new(), |(_, text)| text.clone())
    }
}

/// Numbers on an axis that has its marks at given places.
pub(super) struct MarkedAxis {
    numbers: RangedCoordf64,
    marks: Vec<f64>,
}

impl Ranged for MarkedAxis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.numbers.map(value, limit)
    }

    fn key_points<H: KeyPointHint>(&self, _hint: H) -> Vec<f64> {
        self.marks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.numbers.range()
    }
}

/// Round numbers between two, and what they are called.
fn round_numbers(low: f64, high: f64) -> Vec<(f64, String)> {
    let least = (high - low) / MARKS as f64;
    let power = 10.0_f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|digit| digit * power).find(|step| *step >= least);
    let Some(step) = step.filter(|step| step.is_normal()) else { return vec![] };
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    let first = (low / step).ceil();
    let all = (0..=2 * MARKS).map(|at| (first + at as f64) * step);
    // A hair behind the end is rounding.
    let all = all.take_while(|mark| *mark <= high + 1e-9 * step);
    all.map(|mark| (mark, format!("{mark:.decimals$}"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_numbers_are_round() {
        let texts =
            |low, high| round_numbers(low, high).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts(-0.5, 99.5), ["0", "20", "40", "60", "80"]);
        assert_eq!(texts(0.0, 0.7), ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7"]);
        assert!(texts(0.0, 0.0).is_empty() && texts(f64::NAN, 1.0).is_empty());
        assert!(texts(1870.5, 1970.5).contains(&"1900".to_string()));
    }

    #[test]
    fn rows_stand_at_their_dates_and_forecasts_go_on() {
        let labels = ["2024-01-31", "2024-02-29", "2024-03-31"].map(Some);
        let estimate = crate::estimate::Estimate::of_state(vec![]);
        let ahead = [Forecast { time: 3.0, label: None, is_given: false, estimate }];
        let axis = TimeAxis::of(&[0.0, 1.0, 2.0], &labels, Some("month"), &ahead);
        assert_eq!((axis.name(), axis.places.len(), axis.rows), ("month", 4, 3));
        assert_eq!(axis.place(3) - axis.place(2), 31.0);
        assert_eq!(axis.edge().unwrap() - axis.place(2), 15.5);
        assert!(axis.marks.iter().any(|(_, text)| text == "2024-03"), "{:?}", axis.marks);
        // What is no date, or does not go on, is no axis.
        for label in ["b", "2023-01-01"] {
            let labels = [Some("2024-01-31"), Some(label)];
            assert_eq!(TimeAxis::of(&[0.0, 1.0], &labels, Some("month"), &[]).name(), "t");
        }
        let axis = TimeAxis::of(&[0.0, 1.0], &["1871", "1872"].map(Some), Some("year"), &[]);
        assert_eq!((axis.name(), axis.place(1)), ("year", 1872.0));
    }
}
