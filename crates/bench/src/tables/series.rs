//! series.csv: estimates over time.

use serde::Serialize;

use super::rows::{csv, exact_or_empty};
use crate::series::StateSeries;
use crate::store::Record;

#[derive(Serialize)]
struct SeriesRow<'a> {
    figure: &'a str,
    method: &'a str,
    repetition: usize,
    t: usize,
    state: &'a str,
    #[serde(serialize_with = "exact_or_empty")]
    truth: Option<f64>,
    #[serde(serialize_with = "exact_or_empty")]
    mean: Option<f64>,
    #[serde(serialize_with = "exact_or_empty")]
    lo: Option<f64>,
    #[serde(serialize_with = "exact_or_empty")]
    hi: Option<f64>,
}

/// Every time of every coordinate that was recorded, with the truth, the mean of all runs, and what nine tenths of them span.
pub(crate) fn series_csv(figure: &str, records: &[Record]) -> String {
    let states = records.iter().flat_map(|record| {
        let states = record.series.iter().flat_map(|series| &series.states);
        states.map(move |series| (record, series))
    });
    let rows = states.flat_map(|(record, series)| {
        let StateSeries { state, truth, mean, lo, hi } = series;
        (0..truth.len()).map(move |t| SeriesRow {
            figure,
            method: record.point.method.name(),
            repetition: record.point.repetition,
            t,
            state,
            truth: truth.get(t).copied(),
            mean: mean.get(t).copied(),
            lo: lo.get(t).copied(),
            hi: hi.get(t).copied(),
        })
    });
    csv(&["figure", "method", "repetition", "t", "state", "truth", "mean", "lo", "hi"], rows)
}
