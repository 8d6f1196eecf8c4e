//! How long units will take: short trials of a few, and straight lines between them.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use motes_cli::Interrupt;

use crate::config::{Method, Plan, Point};
use crate::evaluate::Evaluator;
use crate::method_config::MethodConfig;
use crate::metric::Metric;
use crate::runner::guarded;
use crate::threads;
use crate::unit::UnitConfig;

const TRIAL_RUNS: usize = 2;
const TRIAL_TIMES: usize = 20;
/// Steps of a trial of learning once: a few take as long as the simulations before the first.
const ONCE_STEPS: usize = 20;

fn of(timings: &[Metric], name: &str) -> f64 {
    timings.iter().find(|timing| timing.name == name).map_or(0.0, |timing| timing.value)
}

/// Estimates times by trials, and remembers them: figures that differ in their noise alone take the same time.
#[derive(Default)]
pub struct Estimator {
    evaluator: Evaluator,
    /// Seconds by what they depend on.
    known: RefCell<HashMap<String, f64>>,
}

impl Estimator {
    /// Estimated seconds for each of `points`, with its share of the plan's threads, without the reference filters, which units share. What is
    /// learned once counts where it is first needed.
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
        let mut learned = BTreeSet::new();
        points
            .iter()
            .map(|point| {
                let (low, first, slope) = lines[&(point.method, point.panel.as_str())];
                let filters = (first + slope * (point.x - low) as f64).max(0.0);
                let unit = UnitConfig::at(plan, point);
                let once = unit.as_ref().and_then(UnitConfig::learned_once);
                let is_first = once.is_some_and(|(key, _)| learned.insert(key));
                filters
                    + unit.filter(|_| is_first).map_or(0.0, |unit| self.learning(unit, threads, interrupt))
            })
            .collect()
    }

    /// Seconds to learn a unit's proposal once, scaled up from a few steps.
    fn learning(&self, mut unit: UnitConfig, threads: usize, interrupt: &Interrupt) -> f64 {
        let steps = unit.method.steps_mut().map_or(0, |steps| std::mem::replace(steps, ONCE_STEPS));
        (unit.filter_runs, unit.filter.particles, unit.reference_particles) = (1, 1, None);
        unit.system.set_horizon(1);
        let key = serde_json::to_string(&unit).expect("a configuration has only string keys");
        if let Some(&known) = self.known.borrow().get(&key) {
            return known;
        }
        let seconds = self
            .evaluated(&unit, threads, interrupt)
            .map_or(0.0, |timings| of(&timings, "train_seconds") * (steps as f64 / ONCE_STEPS as f64));
        self.known.borrow_mut().insert(key, seconds);
        seconds
    }

    /// What a trial of a unit took; none if it failed.
    fn evaluated(&self, unit: &UnitConfig, threads: usize, interrupt: &Interrupt) -> Option<Vec<Metric>> {
        let evaluator = &self.evaluator;
        // A thread belongs to the first pool that it joins for good: each trial has its own.
        let trial = || threads::on(threads, || guarded(|| evaluator.evaluate(unit, interrupt)));
        let found = std::thread::scope(|scope| scope.spawn(trial).join());
        let found = found.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        found.ok().map(|found| found.timings)
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
        let is_once = matches!(unit.method, MethodConfig::Once(_));
        let seconds = self.evaluated(&unit, threads, interrupt).map_or(0.0, |timings| {
            let training = if is_once { 0.0 } else { of(&timings, "train_seconds") * train_scale };
            time_scale * (training + of(&timings, "filter_seconds") * filter_scale)
        });
        self.known.borrow_mut().insert(key, seconds);
        seconds
    }
}
