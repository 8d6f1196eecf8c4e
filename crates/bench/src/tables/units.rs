//! units.csv and timings.csv: every number of every unit, one a line.

use super::rows::{FailureRow, MetricRow, csv};
use crate::metric::Metric;
use crate::store::{Outcome, Record};

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
    let failed = records.iter().filter_map(|record| match &record.outcome {
        Outcome::Failed(reason) => Some(FailureRow {
            figure: figure.into(),
            panel: record.point.panel.clone(),
            method: record.point.method.name().into(),
            x: record.point.x,
            repetition: record.point.repetition,
            reason: reason.clone(),
        }),
        Outcome::Metrics(_) => None,
    });
    csv(&["figure", "panel", "method", "x", "repetition", "reason"], failed)
}

fn long(figure: &str, records: &[Record], values: impl Fn(&Record) -> &[Metric]) -> String {
    let rows = records.iter().flat_map(|record| {
        values(record).iter().map(|metric| MetricRow::of(figure, record, &metric.name, metric.value))
    });
    csv(&["figure", "panel", "method", "x", "repetition", "metric", "value"], rows)
}
