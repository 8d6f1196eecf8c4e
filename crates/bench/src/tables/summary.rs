//! summary.csv: median and standard deviation over repetitions.

use serde::Serialize;

use super::rows::{csv, exact_or_empty};
use crate::config::Method;
use crate::statistics::{median, quartiles, standard_deviation};
use crate::store::{Outcome, Record};

/// One metric of one method at one point, over its repetitions.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    pub(crate) panel: String,
    pub(crate) method: Method,
    pub(crate) x: usize,
    pub(crate) metric: String,
    pub(crate) median: f64,
    /// What the middle half of the repetitions spans.
    pub(crate) quartiles: (f64, f64),
    /// Sample standard deviation; 0 for one repetition.
    pub(crate) std: f64,
    /// Repetitions that have this metric.
    pub(crate) n_ok: usize,
    /// Repetitions that were run.
    pub(crate) n: usize,
}

/// Summarises sorted records. A point at which every unit failed has a row with no value, for a metric that others have.
pub(crate) fn summarise(records: &[Record]) -> Vec<Row> {
    let first = |record: &Record| match &record.outcome {
        Outcome::Metrics(metrics) => metrics.first().map(|metric| metric.name.clone()),
        Outcome::Failed(_) => None,
    };
    let some_metric = records.iter().find_map(first).unwrap_or_else(|| "nmse_final".into());
    let same = |a: &Record, b: &Record| {
        (&a.point.panel, a.point.method, a.point.x) == (&b.point.panel, b.point.method, b.point.x)
    };
    let mut rows = Vec::new();
    for group in records.chunk_by(same) {
        let found: Vec<_> = group
            .iter()
            .filter_map(|record| match &record.outcome {
                Outcome::Metrics(metrics) => Some(metrics),
                Outcome::Failed(_) => None,
            })
            .collect();
        let mut names: Vec<&str> = Vec::new();
        for metric in found.iter().flat_map(|metrics| metrics.iter()) {
            if !names.contains(&metric.name.as_str()) {
                names.push(&metric.name);
            }
        }
        if names.is_empty() {
            names.push(&some_metric);
        }
        for name in names {
            let values: Vec<f64> = group.iter().filter_map(|record| value(record, name)).collect();
            let point = &group[0].point;
            rows.push(Row {
                panel: point.panel.clone(),
                method: point.method,
                x: point.x,
                metric: name.to_string(),
                std: standard_deviation(&values),
                quartiles: quartiles(&values),
                n_ok: values.len(),
                n: group.len(),
                median: median(values),
            });
        }
    }
    rows
}

fn value(record: &Record, name: &str) -> Option<f64> {
    match &record.outcome {
        Outcome::Metrics(metrics) => metrics.iter().find(|metric| metric.name == name).map(|m| m.value),
        Outcome::Failed(_) => None,
    }
}

#[derive(Serialize)]
struct SummaryRow<'a> {
    figure: &'a str,
    panel: &'a str,
    method: &'a str,
    x: usize,
    metric: &'a str,
    #[serde(serialize_with = "exact_or_empty")]
    median: Option<f64>,
    #[serde(serialize_with = "exact_or_empty")]
    std: Option<f64>,
    n_ok: usize,
    n: usize,
}

/// The summary as CSV; a point without any value has empty cells.
pub(crate) fn summary_csv(figure: &str, rows: &[Row]) -> String {
    let rows = rows.iter().map(|row| {
        let known = |value: f64| (row.n_ok > 0).then_some(value);
        SummaryRow {
            figure,
            panel: &row.panel,
            method: row.method.name(),
            x: row.x,
            metric: &row.metric,
            median: known(row.median),
            std: known(row.std),
            n_ok: row.n_ok,
            n: row.n,
        }
    });
    csv(&["figure", "panel", "method", "x", "metric", "median", "std", "n_ok", "n"], rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Point;
    use crate::metric::Metric;
    use crate::unit::tests::unit;

    fn record(x: usize, repetition: usize, outcome: Outcome) -> Record {
        let point = Point { panel: "N10".into(), x, method: Method::Bootstrap, repetition };
        let config = unit(10, 12, x);
        Record {
            point,
            config,
            revision: String::new(),
            processor: None,
            outcome,
            timings: vec![],
            series: None,
        }
    }

    #[test]
    fn failed_units_are_counted_and_never_dropped() {
        let ok = |value| Outcome::Metrics(vec![Metric::new("nmse_final", value)]);
        let failed = || Outcome::Failed("why".into());
        let records = [
            record(10, 0, ok(1.0)),
            record(10, 1, failed()),
            record(10, 2, ok(4.0)),
            record(20, 0, failed()),
        ];
        let csv = summary_csv("fig1", &summarise(&records));
        let lines: Vec<&str> = csv.lines().skip(1).collect();
        assert_eq!(lines[0], "fig1,N10,bootstrap,10,nmse_final,2.5,2.1213203435596424,2,3");
        assert_eq!(lines[1], "fig1,N10,bootstrap,20,nmse_final,,,0,1");
    }
}
