//! series.csv: estimates over time.

use super::units::place;
use super::{csv, number};
use crate::store::Record;

/// Every time of every coordinate that was recorded, with the truth, the mean of all runs, and what nine tenths of them span.
pub(crate) fn series_csv(figure: &str, records: &[Record]) -> String {
    let header = ["figure", "method", "repetition", "t", "state", "truth", "mean", "lo", "hi"];
    let states = records.iter().flat_map(|record| {
        let states = record.series.iter().flat_map(|series| &series.states);
        states.map(move |state| (place(figure, record), state))
    });
    let rows = states.flat_map(|([figure, _, method, _, repetition], series)| {
        (0..series.truth.len()).map(move |t| {
            let at = |values: &[f64]| values.get(t).map_or(String::new(), |value| number(*value));
            [
                figure.clone(),
                method.clone(),
                repetition.clone(),
                t.to_string(),
                series.state.clone(),
                at(&series.truth),
                at(&series.mean),
                at(&series.lo),
                at(&series.hi),
            ]
        })
    });
    csv(header, rows)
}
