//! units.csv and timings.csv: every number of every unit, one a line.

use super::{csv, number};
use crate::Metric;
use crate::store::{Outcome, Record};

const HEADER: [&str; 7] = ["figure", "panel", "method", "x", "repetition", "metric", "value"];

/// What depends on nothing but the configuration.
pub(crate) fn units_csv(figure: &str, records: &[Record]) -> String {
    long(figure, records, |record| match &record.outcome {
        Outcome::Metrics(metrics) => metrics,
        Outcome::Failed(_) => &[],
    })
}

/// What depends on the clock.
pub(crate) fn timings_csv(figure: &str, records: &[Record]) -> String {
    long(figure, records, |record| &record.timings)
}

/// Units that failed, with the reason.
pub(crate) fn failures_csv(figure: &str, records: &[Record]) -> String {
    let header = ["figure", "panel", "method", "x", "repetition", "reason"];
    let failed = records.iter().filter_map(|record| match &record.outcome {
        Outcome::Failed(reason) => Some((record, reason)),
        Outcome::Metrics(_) => None,
    });
    csv(
        header,
        failed.map(|(record, reason)| {
            let [figure, panel, method, x, repetition] = place(figure, record);
            [figure, panel, method, x, repetition, reason.clone()]
        }),
    )
}

pub(super) fn place(figure: &str, record: &Record) -> [String; 5] {
    let point = &record.point;
    let (panel, method) = (point.panel.clone(), point.method.name().to_string());
    [figure.to_string(), panel, method, point.x.to_string(), point.repetition.to_string()]
}

fn long(figure: &str, records: &[Record], values: impl Fn(&Record) -> &[Metric]) -> String {
    let rows = records.iter().flat_map(|record| {
        let [figure, panel, method, x, repetition] = place(figure, record);
        values(record).iter().map(move |metric| {
            let (name, value) = (metric.name.clone(), number(metric.value));
            [figure.clone(), panel.clone(), method.clone(), x.clone(), repetition.clone(), name, value]
        })
    });
    csv(HEADER, rows)
}
