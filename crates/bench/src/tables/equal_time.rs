//! What evidence and smoothed states cost: errors beside the time of a filter.

use super::markdown::short;
use crate::config::Method;
use crate::metric::Metric;
use crate::statistics::median;
use crate::store::{Outcome, Record};

/// A method at one point, in medians over repetitions.
struct Cost {
    x: usize,
    n: usize,
    /// Of a filter, with what is found for the sequence before it runs.
    milliseconds: f64,
    /// The squared error of log ẑ times that.
    of_evidence: f64,
    /// The error of smoothed states times that.
    of_states: f64,
    /// What training takes; 0 for designed proposals.
    training: f64,
}

/// A Markdown table: each method of each panel at the x at which its evidence costs least. Nothing where no unit estimates evidence and smoothed states.
pub(crate) fn equal_time(axis: &str, records: &[Record]) -> Option<String> {
    let mut text = String::from(
        "Time for an error of 1 in log ẑ: its squared error times the time of a filter, of a smoother or networks that see the sequence first included, \
         at the point where that is least; likewise for the NMSE of one run's smoothed states. Training comes on top.\n\n",
    );
    text +=
        &format!("| panel | method | {axis} | ms a filter | ms for log ẑ | NMSE × ms | training, s | n |\n");
    text += "|---|---|---:|---:|---:|---:|---:|---:|\n";
    let empty = text.len();
    let same = |a: &Record, b: &Record| (&a.point.panel, a.point.method) == (&b.point.panel, b.point.method);
    for of_method in records.chunk_by(same) {
        let (panel, method): (_, Method) = (&of_method[0].point.panel, of_method[0].point.method);
        let at = |a: &Record, b: &Record| a.point.x == b.point.x;
        let costs = of_method.chunk_by(at).filter_map(cost);
        let Some(best) = costs.min_by(|a, b| a.of_evidence.total_cmp(&b.of_evidence)) else { continue };
        let Cost { x, n, milliseconds, of_evidence, of_states, training } = best;
        let training = if training > 0.0 { format!("{training:.1}") } else { "–".into() };
        text += &format!(
            "| {panel} | {} | {x} | {milliseconds:.3} | {} | {} | {training} | {n} |\n",
            method.name(),
            short(of_evidence),
            short(of_states),
        );
    }
    (text.len() > empty).then_some(text)
}

fn cost(records: &[Record]) -> Option<Cost> {
    let value = |metrics: &[Metric], name: &str| {
        metrics.iter().find(|metric| metric.name == name).map(|metric| metric.value)
    };
    let of_record = |record: &Record| {
        let Outcome::Metrics(metrics) = &record.outcome else { return None };
        let seconds = value(&record.timings, "filter_seconds")? / record.config.filter_runs as f64
            + value(&record.timings, "setup_seconds").unwrap_or(0.0);
        let (log, states) = (value(metrics, "log_evidence_mse")?, value(metrics, "nmse_smoothed_single")?);
        let training = value(&record.timings, "train_seconds").unwrap_or(0.0);
        Some([1e3 * seconds, 1e3 * seconds * log, 1e3 * seconds * states, training])
    };
    let found: Vec<[f64; 4]> = records.iter().filter_map(of_record).collect();
    let of = |at: usize| median(found.iter().map(|row| row[at]).collect());
    (!found.is_empty()).then(|| Cost {
        x: records[0].point.x,
        n: found.len(),
        milliseconds: of(0),
        of_evidence: of(1),
        of_states: of(2),
        training: of(3),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Point;
    use crate::unit::tests::unit;

    #[test]
    fn the_best_point_is_the_one_whose_error_times_time_is_least() {
        let record = |x: usize, [mse, nmse, seconds, setup]: [f64; 4]| Record {
            point: Point { panel: "N10".into(), x, method: Method::LookAhead, repetition: 0 },
            // Three filters.
            config: unit(10, 12, x),
            revision: String::new(),
            processor: None,
            outcome: Outcome::Metrics(vec![
                Metric::new("log_evidence_mse", mse),
                Metric::new("nmse_smoothed_single", nmse),
            ]),
            timings: vec![Metric::new("filter_seconds", seconds), Metric::new("setup_seconds", setup)],
            series: None,
        };
        // 2 ms each with an error of 3, and 5 ms with an error of 1: what is found before the filters runs once for each.
        let records = [record(10, [3.0, 0.5, 0.003, 0.001]), record(20, [1.0, 0.25, 0.009, 0.002])];
        let table = equal_time("K", &records).unwrap();
        assert_eq!(table.lines().last().unwrap(), "| N10 | look-ahead | 20 | 5.000 | 5.00 | 1.25 | – | 1 |");
        let other = Record { outcome: Outcome::Metrics(vec![Metric::new("ess", 1.0)]), ..records[0].clone() };
        assert_eq!(equal_time("K", &[other]), None);
    }
}
