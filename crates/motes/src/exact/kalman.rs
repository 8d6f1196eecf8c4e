//! The Kalman filter and smoother in the place of particles.

use std::ops::ControlFlow;
use std::slice::from_mut;

use motes_models::batch::Rows;
use motes_models::equations::normal;
use motes_models::kalman::{Belief, Filtered, KalmanFilter, LinearSystem, smooth};
use motes_models::{ModelError, Seed, Step, StepRecord, Stream};
use motes_smc::{FilterError, Predictive, SmoothedPaths};

use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate};
use crate::model::Model;
use crate::quantiles::Quantiles;
use crate::running_state::{ExactState, FilterState};
use crate::steps::Steps;

use super::rows::series;

/// A Kalman filter in the place of particles.
pub(super) struct Kalman<'m> {
    linear: &'m dyn LinearSystem,
    filter: KalmanFilter<&'m dyn LinearSystem>,
    means: Vec<f64>,
    log_evidence: f64,
}

impl<'m> Kalman<'m> {
    /// Before the first measurement.
    pub(super) fn new(linear: &'m dyn LinearSystem) -> Self {
        let (filter, means) = (KalmanFilter::new(linear), vec![0.0; linear.state_dim()]);
        Kalman { linear, filter, means, log_evidence: 0.0 }
    }

    /// Where it was written down; none of another model.
    pub(super) fn restore(linear: &'m dyn LinearSystem, state: ExactState) -> Option<Self> {
        let ExactState { time, log_evidence, belief } = state;
        let n = linear.state_dim();
        let belief = match belief {
            Some((mean, covariance)) if mean.len() == n && covariance.len() == n * n => {
                Some(Belief::of(&mean, &covariance))
            }
            None => None,
            Some(_) => return None,
        };
        let means = belief.as_ref().map_or(vec![0.0; n], |belief| belief.mean.iter().copied().collect());
        Some(Kalman { linear, filter: KalmanFilter::resume(linear, time, belief), means, log_evidence })
    }
}

/// What a Gaussian belief says of each coordinate.
fn coordinates(belief: &Belief, probabilities: &[f64]) -> Vec<Coordinate> {
    let of = |i: usize| Coordinate {
        mean: belief.mean[i],
        sd: belief.standard_deviation(i),
        quantiles: probabilities.iter().map(|probability| belief.quantile(i, *probability)).collect(),
    };
    (0..belief.mean.nrows()).map(of).collect()
}

/// What a Gaussian belief about the state says of each entry of the measurement.
fn measured(
    linear: &dyn LinearSystem,
    step: &Step<'_>,
    belief: &Belief,
    measurement: &[Option<f64>],
    probabilities: &[f64],
) -> Vec<Predictive> {
    let belief = linear.measurement_map(step).of_belief(belief);
    let of = |(i, value): (usize, &Option<f64>)| {
        let mean = belief.mean[i];
        // What is not known has no spread.
        let sd = if mean.is_nan() { mean } else { belief.standard_deviation(i) };
        let below = |value: f64| normal::<f64>(mean, sd).log_mass(f64::NEG_INFINITY, value).exp();
        Predictive {
            mean,
            sd,
            quantiles: probabilities.iter().map(|probability| belief.quantile(i, *probability)).collect(),
            pit: value.map(below).filter(|pit| !pit.is_nan()),
        }
    };
    measurement.iter().enumerate().map(of).collect()
}

impl Steps for Kalman<'_> {
    fn step(&mut self, step: &Step<'_>, measurement: &[Option<f64>]) -> Result<(), FilterError> {
        let step = self.filter.step_at(step, measurement)?;
        self.log_evidence += step.log_evidence_increment;
        self.means.clear();
        self.means.extend(step.filtered.mean.iter());
        Ok(())
    }

    fn measurement_ahead(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Result<Vec<Predictive>, FilterError> {
        let mut ahead = self.filter.clone();
        let predicted = ahead.step_at(step, &vec![None; measurement.len()])?.predicted;
        Ok(measured(self.linear, step, &predicted, measurement, probabilities))
    }

    fn measurement(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Vec<Predictive> {
        let Some(belief) = self.filter.belief() else { return vec![] };
        measured(self.linear, step, belief, measurement, probabilities)
    }

    fn state(&self, probabilities: &[f64]) -> Vec<Coordinate> {
        self.filter.belief().map(|belief| coordinates(belief, probabilities)).unwrap_or_default()
    }

    fn means(&self) -> &[f64] {
        &self.means
    }

    fn quantiles(&self, coordinate: usize, probabilities: &[f64]) -> Vec<f64> {
        let Some(belief) = self.filter.belief() else { return vec![] };
        probabilities.iter().map(|probability| belief.quantile(coordinate, *probability)).collect()
    }

    fn log_evidence(&self) -> f64 {
        self.log_evidence
    }

    fn snapshot(&self) -> FilterState {
        let belief = self.filter.belief().map(|belief| {
            let n = belief.mean.nrows();
            let entries = (0..n * n).map(|at| belief.covariance[(at / n, at % n)]).collect();
            (belief.mean.iter().copied().collect(), entries)
        });
        FilterState::Exact(ExactState { time: self.filter.time(), log_evidence: self.log_evidence, belief })
    }

    fn of_particle(&self, _particle: usize) -> (Option<&[f64]>, &[f64]) {
        (None, &self.means)
    }
}

/// The Kalman filter over a series.
pub(super) fn filter_linear(
    linear: &dyn LinearSystem,
    steps: &[&[StepRecord]],
    rows: &[&[Option<f64>]],
) -> Result<Filtered, ModelError> {
    let mut filter = KalmanFilter::new(linear);
    let of_step = |(step, row): (&StepRecord, Vec<Option<f64>>)| filter.step_at(&step.step(), &row);
    let steps = series(steps, rows).into_iter().map(of_step).collect::<Result<_, _>>()?;
    Ok(Filtered { steps })
}

/// What the Kalman smoother says of a series (`T` rows, with the steps that lead to each), with these quantiles, and trajectories drawn from `p(x_{0:T−1} | y_{0:T−1})`, each a simulation
/// corrected by what the smoother makes of its difference from the data (Durbin and Koopman 2002).
///
/// # Errors
/// [`MotesError`] as the Kalman filter, or if `proceed` said to stop.
pub(super) fn smooth_linear(
    model: &Model,
    linear: &dyn LinearSystem,
    (steps, rows): (&[&[StepRecord]], &[&[Option<f64>]]),
    (paths, quantiles): (usize, &Quantiles),
    seed: &Seed,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<(Vec<Estimate>, SmoothedPaths), MotesError> {
    let n = model.states().len();
    let smoothed = smooth(&filter_linear(linear, steps, rows)?)?;
    // Steps before the first row have estimates that nobody asked for.
    let before = steps.first().map_or(0, |steps| steps.len().saturating_sub(1));
    let estimate = |belief| Estimate::of_state(coordinates(belief, quantiles.probabilities()));
    let estimates = smoothed.beliefs.iter().skip(before).map(estimate).collect();
    let times = smoothed.beliefs.len();
    let mut states = Vec::with_capacity(paths * times * n);
    for path in 0..paths {
        let mut stream = seed.nth(path as u64).stream();
        let (drawn, measured) = drawn(linear, model, steps, rows, &mut stream);
        let measured: Vec<&[Option<f64>]> = measured.iter().map(Vec::as_slice).collect();
        // Linear maps of the data: the smoother of a difference is the difference of smoothers, but for the prior's mean, which counts twice.
        let of_drawn = smooth(&filter_linear(linear, steps, &measured)?)?;
        let beliefs = smoothed.beliefs.iter().zip(&of_drawn.beliefs);
        for ((belief, of_drawn), state) in beliefs.zip(drawn.chunks_exact(n)) {
            states.extend((0..n).map(|i| state[i] + belief.mean[i] - of_drawn.mean[i]));
        }
        if proceed().is_break() {
            return Err(MotesError::Interrupted);
        }
    }
    Ok((estimates, SmoothedPaths::independent(states, times, n).without_first(before)))
}

/// A simulation: the state of each step, and the measurements of each row that are there in `rows`.
fn drawn(
    linear: &dyn LinearSystem,
    model: &Model,
    steps: &[&[StepRecord]],
    rows: &[&[Option<f64>]],
    stream: &mut Stream,
) -> (Vec<f64>, Vec<Vec<Option<f64>>>) {
    let (n, m) = (model.states().len(), model.measurements().len());
    let (mut before, mut state, mut states) = (vec![0.0; n], vec![0.0; n], Vec::new());
    let (mut measurement, mut measured) = (vec![0.0; m], Vec::with_capacity(rows.len()));
    for (steps, row) in steps.iter().zip(rows) {
        for record in *steps {
            let step = record.step();
            let previous = (step.index > 0).then(|| Rows::all(&before, n));
            linear.sample_states(&step, previous, from_mut(stream), &mut state);
            before.copy_from_slice(&state);
            states.extend_from_slice(&state);
        }
        let Some(last) = steps.last() else { continue };
        model.sample_measurement(&last.step(), &state, stream, &mut measurement);
        measured.push(row.iter().zip(&measurement).map(|(there, drawn)| there.map(|_| *drawn)).collect());
    }
    (states, measured)
}
