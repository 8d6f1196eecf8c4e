//! How long units will take: short trials of a few, and straight lines between them.

use std::collections::BTreeMap;

use crate::config::{Method, Plan, Point};
use crate::evaluate::{Evaluator, Metric};
use crate::runner::guarded;
use crate::{Interrupt, UnitConfig};

const TRIAL_STEPS: usize = 2;
const TRIAL_RUNS: usize = 10;

/// Estimated seconds of one thread for each of `points`.
///
/// For each method and panel the smallest and the largest x are tried with very little training and few filters, which
/// takes a second or so; what lies between is taken to grow linearly. A trial that fails counts for nothing.
pub(crate) fn seconds(
    plan: &Plan,
    points: &[Point],
    evaluator: &Evaluator,
    interrupt: &Interrupt,
) -> Vec<f64> {
    let mut ends: BTreeMap<(Method, &str), (usize, usize)> = BTreeMap::new();
    for point in points {
        let (low, high) = ends.entry((point.method, &point.panel)).or_insert((point.x, point.x));
        (*low, *high) = ((*low).min(point.x), (*high).max(point.x));
    }
    let lines: BTreeMap<_, _> = ends
        .into_iter()
        .map(|((method, panel), (low, high))| {
            let at = |x| {
                let point = Point { panel: panel.into(), x, method, repetition: 0 };
                trial(plan, &point, evaluator, interrupt)
            };
            let first = at(low);
            let slope = if high > low { (at(high) - first) / (high - low) as f64 } else { 0.0 };
            ((method, panel), (low, first, slope))
        })
        .collect();
    points
        .iter()
        .map(|point| {
            let (low, first, slope) = lines[&(point.method, point.panel.as_str())];
            (first + slope * (point.x - low) as f64).max(0.0)
        })
        .collect()
}

/// Seconds for one unit, scaled up from a trial.
fn trial(plan: &Plan, point: &Point, evaluator: &Evaluator, interrupt: &Interrupt) -> f64 {
    let Some(mut unit) = UnitConfig::at(plan, point) else { return 0.0 };
    let runs = unit.filter_runs.min(TRIAL_RUNS);
    let filter_scale = unit.filter_runs as f64 / runs as f64;
    unit.filter_runs = runs;
    let mut train_scale = 0.0;
    if let Some(steps) = unit.method.steps_mut() {
        let few = TRIAL_STEPS.min(*steps);
        train_scale = *steps as f64 / few as f64;
        *steps = few;
    }
    let of =
        |timings: &[Metric], name| timings.iter().find(|timing| timing.name == name).map_or(0.0, |t| t.value);
    match guarded(|| evaluator.evaluate(&unit, interrupt)) {
        Ok(found) => {
            of(&found.timings, "train_seconds") * train_scale
                + of(&found.timings, "filter_seconds") * filter_scale
        }
        Err(_) => 0.0,
    }
}
