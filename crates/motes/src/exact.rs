//! Linear Gaussian models have exact answers: a filter without particles, and what particles are held against.

use std::borrow::Cow;
use std::ops::ControlFlow;

use motes_models::kalman::{Belief, KalmanFilter, Smoothed, filter_partial, smooth};
use motes_models::{LinearGaussian, ModelError, PartialMeasurements, Seed, Step};
use motes_smc::{
    EvidenceWarning, FilterError, FilterHistory, SmoothedPaths, SmoothingError, Verdict, WeightDiagnosis,
};

use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate, PROBABILITIES};
use crate::model::Model;
use crate::running_state::{ExactState, FilterState};
use crate::steps::Steps;

/// A Kalman filter in the place of particles.
pub(crate) struct Exact<'m> {
    filter: KalmanFilter<Cow<'m, LinearGaussian>>,
    means: Vec<f64>,
    log_evidence: f64,
}

impl<'m> Exact<'m> {
    /// Before the first measurement; none of a model that has no exact answers.
    pub(crate) fn new(model: &'m Model) -> Option<Self> {
        let filter = KalmanFilter::new(model.linear_gaussian()?);
        Some(Exact { filter, means: vec![0.0; model.states().len()], log_evidence: 0.0 })
    }

    /// Where it was written down.
    pub(crate) fn restore(model: &'m Model, state: ExactState) -> Option<Self> {
        let ExactState { time, log_evidence, belief } = state;
        let (linear, n) = (model.linear_gaussian()?, model.states().len());
        let belief = match belief {
            Some((mean, covariance)) if mean.len() == n && covariance.len() == n * n => {
                Some(Belief::of(&mean, &covariance))
            }
            None => None,
            Some(_) => return None,
        };
        let means = belief.as_ref().map_or(vec![0.0; n], |belief| belief.mean.iter().copied().collect());
        Some(Exact { filter: KalmanFilter::resume(linear, time, belief), means, log_evidence })
    }
}

/// What a Gaussian belief says of each coordinate.
fn coordinates(belief: &Belief) -> Vec<Coordinate> {
    let of = |i: usize| Coordinate {
        mean: belief.mean[i],
        sd: belief.standard_deviation(i),
        quantiles: PROBABILITIES.map(|probability| belief.quantile(i, probability)),
    };
    (0..belief.mean.nrows()).map(of).collect()
}

impl Steps for Exact<'_> {
    fn step(&mut self, _step: &Step<'_>, measurement: &[Option<f64>]) -> Result<(), FilterError> {
        let step = self.filter.step(measurement)?;
        self.log_evidence += step.log_evidence_increment;
        self.means.clear();
        self.means.extend(step.filtered.mean.iter());
        Ok(())
    }

    fn verdict(&self) -> Option<Verdict> {
        None
    }

    fn difference(&self) -> f64 {
        0.0
    }

    fn standard_error(&self) -> Option<f64> {
        Some(0.0)
    }

    fn evidence_warnings(&self) -> Vec<EvidenceWarning> {
        vec![]
    }

    fn state(&self) -> Vec<Coordinate> {
        self.filter.belief().map(coordinates).unwrap_or_default()
    }

    fn particles(&self) -> usize {
        0
    }

    fn is_large(&self) -> bool {
        false
    }

    fn means(&self) -> &[f64] {
        &self.means
    }

    fn quantiles(&self, coordinate: usize, probabilities: &[f64]) -> Vec<f64> {
        let Some(belief) = self.filter.belief() else { return vec![] };
        probabilities.iter().map(|probability| belief.quantile(coordinate, *probability)).collect()
    }

    fn diagnosis(&self) -> Option<WeightDiagnosis> {
        None
    }

    fn effective_sample_size(&self) -> Option<f64> {
        None
    }

    fn log_evidence(&self) -> f64 {
        self.log_evidence
    }

    fn record(&self, _history: &mut FilterHistory) -> Result<(), SmoothingError> {
        Ok(())
    }

    fn backward(
        &self,
        _history: &FilterHistory,
        _paths: usize,
        _seed: &Seed,
        _proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<SmoothedPaths, SmoothingError> {
        Err(SmoothingError::Nothing { name: "the number of particles" })
    }

    fn failure(&self) -> Option<&FilterError> {
        None
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

/// The exact log-evidence of a series beside its particles, as far as it has come.
pub struct ExactEvidence<'m> {
    filter: KalmanFilter<Cow<'m, LinearGaussian>>,
    log_evidence: f64,
}

impl<'m> ExactEvidence<'m> {
    /// That of a linear Gaussian model, where it costs next to nothing beside so many particles; none of any other.
    pub fn beside(model: &'m Model, particles: usize) -> Option<Self> {
        let n = model.states().len();
        let linear = if n * n <= particles { model.linear_gaussian()? } else { return None };
        Some(ExactEvidence { filter: KalmanFilter::new(linear), log_evidence: 0.0 })
    }

    /// Takes in the measurement of a row, to which so many steps lead.
    ///
    /// # Errors
    /// As [`KalmanFilter::step`].
    pub fn row(&mut self, steps: usize, measurement: &[Option<f64>]) -> Result<(), ModelError> {
        for _ in 1..steps {
            self.log_evidence += self.filter.step(&vec![None; measurement.len()])?.log_evidence_increment;
        }
        self.log_evidence += self.filter.step(measurement)?.log_evidence_increment;
        Ok(())
    }

    /// `log p(y_{0:t})`.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence
    }
}

/// What the Kalman smoother says of a series (`T` rows, and so many steps before the first of them), and trajectories drawn from `p(x_{0:T−1} | y_{0:T−1})`, each a simulation corrected by what the
/// smoother makes of its difference from the data (Durbin and Koopman 2002).
///
/// # Errors
/// [`MotesError`] for a model that is not linear and Gaussian, as the Kalman filter, or if `proceed` said to stop.
pub(crate) fn smooth_exactly(
    model: &Model,
    before: usize,
    rows: &[&[Option<f64>]],
    paths: usize,
    seed: &Seed,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<(Vec<Estimate>, SmoothedPaths), MotesError> {
    let linear = model.linear_gaussian().ok_or_else(|| not_linear(model))?;
    let (n, m) = (model.states().len(), model.measurements().len());
    let nothing = vec![None; m];
    let rows: Vec<&[Option<f64>]> =
        std::iter::repeat_n(nothing.as_slice(), before).chain(rows.iter().copied()).collect();
    let smoothed = smoothed(&linear, PartialMeasurements::new(m, rows.concat())?)?;
    let estimate = |belief| Estimate { state: coordinates(belief), ess: None, log_evidence: None };
    let estimates = smoothed.beliefs.iter().skip(before).map(estimate).collect();
    let mut states = Vec::with_capacity(paths * rows.len() * n);
    for path in 0..paths {
        let mut stream = seed.nth(path as u64).stream();
        let drawn = motes_models::simulate(&*linear, rows.len(), &mut stream)?;
        // Linear maps of the data: the smoother of a difference is the difference of smoothers, but for the prior's mean, which counts twice.
        let there = rows
            .iter()
            .zip(drawn.measurements.rows())
            .flat_map(|(row, drawn)| row.iter().zip(drawn).map(|(measured, drawn)| measured.map(|_| *drawn)));
        let of_drawn = self::smoothed(&linear, PartialMeasurements::new(m, there.collect())?)?;
        let beliefs = smoothed.beliefs.iter().zip(&of_drawn.beliefs);
        for ((belief, of_drawn), state) in beliefs.zip(drawn.states.rows()) {
            states.extend((0..n).map(|i| state[i] + belief.mean[i] - of_drawn.mean[i]));
        }
        if proceed().is_break() {
            return Err(MotesError::Interrupted);
        }
    }
    Ok((estimates, SmoothedPaths::independent(states, rows.len(), n).without_first(before)))
}

fn smoothed(linear: &LinearGaussian, measurements: PartialMeasurements) -> Result<Smoothed, ModelError> {
    smooth(linear, &filter_partial(linear, &measurements)?)
}

/// Why there is nothing exact.
pub(crate) fn not_linear(model: &Model) -> MotesError {
    let reason = format!(
        "{} is not linear with constant Gaussian noise, at times alike; take --proposal optimal or linearised",
        model.name()
    );
    MotesError::Proposal { proposal: "exact".into(), reason }
}
