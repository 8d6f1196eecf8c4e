//! How long units will take: short trials of a few, and straight lines between them.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};

use motes_cli::Interrupt;

use crate::config::{Method, Plan, Point};
use crate::evaluate::Evaluator;
use crate::metric::Metric;
use crate::runner::guarded;
use crate::threads;
use crate::unit::UnitConfig;

const TRIAL_RUNS: usize = 2;
const TRIAL_TIMES: usize = 20;

/// Estimates times by trials, and remembers them: figures that differ in their noise alone take the same time.
#[derive(Default)]
pub struct Estimator {
    evaluator: Evaluator,
    /// Seconds by what they depend on.
    known: RefCell<HashMap<String, f64>>,
}

impl Estimator {
    /// Estimated seconds for each of `points`, with its share of the plan's threads, without the reference filters, which units share.
    ///
    /// For each method and panel the smallest and the largest x are tried, with a training step and a filter or two over the first times;
    /// what lies between or beyond is taken to grow linearly. A trial that fails counts for nothing.
    pub(crate) fn seconds(&self, plan: &Plan, points: &[Point], interrupt: &Interrupt) -> Vec<f64> {
        let threads = threads::of_workers(plan.jobs, points.len()).next().unwrap_or(1);
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
                    UnitConfig::at(plan, &point).map_or(0.0, |unit| self.trial(unit, threads, interrupt))
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

    /// Seconds for one unit on so many threads, scaled up from a trial.
    fn trial(&self, mut unit: UnitConfig, threads: usize, interrupt: &Interrupt) -> f64 {
        let sizes = [unit.system.dimension(), unit.system.horizon(), unit.filter.particles, unit.filter_runs];
        let key = serde_json::to_string(&(&unit.method, sizes, threads))
            .expect("a configuration has only string keys");
        if let Some(&known) = self.known.borrow().get(&key) {
            return known;
        }
        let runs = unit.filter_runs.min(TRIAL_RUNS);
        let filter_scale = unit.filter_runs as f64 / runs as f64;
        unit.filter_runs = runs;
        let horizon = unit.system.horizon();
        let times = horizon.min(TRIAL_TIMES);
        let time_scale = horizon as f64 / times as f64;
        unit.system.set_horizon(times);
        unit.reference_particles = None;
        let mut train_scale = 0.0;
        if let Some(steps) = unit.method.steps_mut() {
            train_scale = *steps as f64;
            *steps = 1;
        }
        let of = |timings: &[Metric], name| {
            timings.iter().find(|timing| timing.name == name).map_or(0.0, |timing| timing.value)
        };
        let evaluator = &self.evaluator;
        // A thread belongs to the first pool that it joins for good: each trial has its own.
        let trial = || threads::on(threads, || guarded(|| evaluator.evaluate(&unit, interrupt)));
        let found = std::thread::scope(|scope| scope.spawn(trial).join());
        let seconds = match found.unwrap_or_else(|panic| std::panic::resume_unwind(panic)) {
            Ok(found) => {
                let of = |name| of(&found.timings, name);
                time_scale * (of("train_seconds") * train_scale + of("filter_seconds") * filter_scale)
            }
            Err(_) => 0.0,
        };
        self.known.borrow_mut().insert(key, seconds);
        seconds
    }
}
