//! The forward algorithm in the place of particles.

use std::ops::ControlFlow;

use motes_models::forward::{
    FiniteSystem, ForwardError, ForwardFilter, ForwardStep, Limits, StateProbabilities, smooth_states,
};
use motes_models::{ModelError, Seed, Step, StepRecord, Stream};
use motes_smc::{FilterError, LogWeights, Predictive, SmoothedPaths};

use super::rows::series;
use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate};
use crate::model::{Kind, Model};
use crate::quantiles::Quantiles;
use crate::running_state::{FilterState, ForwardState};
use crate::steps::Steps;

/// States before a step that failed, for who says what they predict.
const MOST_BEFORE: usize = 1000;

/// Equally likely states whose measurements are drawn for quantiles.
const PLACES: usize = 4096;

/// A filter of probabilities in the place of particles.
pub(super) struct Forward<'m> {
    model: &'m Model,
    filter: ForwardFilter<&'m dyn FiniteSystem>,
    width: usize,
    means: Vec<f64>,
    log_evidence: f64,
    failure: Option<FilterError>,
    /// Of the step that failed: states before it, in proportion to their probabilities, and the state that it failed at.
    before: Vec<f64>,
    state: Vec<f64>,
}

impl<'m> Forward<'m> {
    /// Before the first measurement.
    pub(super) fn new(model: &'m Model, finite: &'m dyn FiniteSystem) -> Self {
        Forward::of((model, finite), ForwardFilter::new(finite, Limits::default()), 0.0)
    }

    /// Where it was written down; none of another model.
    pub(super) fn restore(
        model: &'m Model,
        finite: &'m dyn FiniteSystem,
        state: ForwardState,
    ) -> Option<Self> {
        let ForwardState { time, log_evidence, belief } = state;
        let n = finite.state_dim();
        let belief = match belief {
            Some((states, probabilities)) if states.len() == n * probabilities.len() => {
                Some(StateProbabilities::of(n, states, probabilities))
            }
            None => None,
            Some(_) => return None,
        };
        let filter = ForwardFilter::resume(finite, Limits::default(), time, belief);
        Some(Forward::of((model, finite), filter, log_evidence))
    }

    fn of(
        (model, finite): (&'m Model, &'m dyn FiniteSystem),
        filter: ForwardFilter<&'m dyn FiniteSystem>,
        log_evidence: f64,
    ) -> Self {
        let width = finite.state_dim();
        let means = filter.belief().map_or(vec![0.0; width], means);
        let (before, state) = (Vec::new(), vec![f64::NAN; width]);
        Forward { model, filter, width, means, log_evidence, failure: None, before, state }
    }

    /// What probabilities of states say of each entry of the measurement: exact means, standard deviations and places, as far as distributions have formulas for them, and
    /// quantiles of draws at states in proportion to their probabilities.
    fn measured(
        &self,
        step: &Step<'_>,
        belief: &StateProbabilities,
        measurement: (&[Option<f64>], &[f64]),
    ) -> Vec<Predictive> {
        let place = |number: usize| belief.at((number as f64 + 0.5) / PLACES as f64);
        let places: Vec<f64> = (0..PLACES).flat_map(|number| belief.state(place(number)).to_vec()).collect();
        let mut weights = LogWeights::uniform(belief.probabilities().len());
        let logs: Vec<f64> = belief.probabilities().iter().map(|probability| probability.ln()).collect();
        if weights.update(&logs).is_err() {
            return vec![];
        }
        let of_places = self.expected(step, (&places, &LogWeights::uniform(PLACES)), measurement);
        let of_states = self.expected(step, (belief.states(), &weights), measurement);
        let both = of_states.into_iter().zip(of_places);
        both.map(|(exact, drawn)| Predictive { quantiles: drawn.quantiles, ..exact }).collect()
    }

    /// What would be measured at weighted states.
    fn expected(
        &self,
        step: &Step<'_>,
        weighted: (&[f64], &LogWeights),
        measurement: (&[Option<f64>], &[f64]),
    ) -> Vec<Predictive> {
        let mut stream = Seed::from_u64(0).child("measurement").nth(step.index as u64).stream();
        match self.model.kind() {
            Kind::Learnable(model) => Predictive::of_states(model, step, weighted, measurement, &mut stream),
            Kind::LinearGaussian(model) => {
                Predictive::of_states(model, step, weighted, measurement, &mut stream)
            }
        }
    }

    /// What an error is to who filters, and what it was about.
    fn fail(&mut self, error: ForwardError) -> FilterError {
        let step = self.filter.time();
        if let Some(belief) = self.filter.belief() {
            let at = |number: usize| belief.at((number as f64 + 0.5) / MOST_BEFORE as f64);
            self.before = (0..MOST_BEFORE).flat_map(|number| belief.state(at(number)).to_vec()).collect();
        }
        let failure = match error {
            ForwardError::Impossible => FilterError::Collapse {
                step,
                filter: 0,
                ess_before: f64::NAN,
                largest_log_likelihood: f64::NEG_INFINITY,
            },
            ForwardError::NotANumber { previous, state } => {
                self.before = previous.unwrap_or(std::mem::take(&mut self.before));
                self.state = state;
                FilterError::NotANumber { step, filter: 0, particle: 0, value: f64::NAN }
            }
            error => filter_error(&error),
        };
        self.failure = Some(failure.clone());
        failure
    }
}

/// An error that is about no state.
fn filter_error(error: &ForwardError) -> FilterError {
    let too_many = |name, most: usize| FilterError::Setting {
        name,
        value: format!("above {most}"),
        expected: "at most so many for exact answers; take --proposal bootstrap",
    };
    match error {
        ForwardError::TooManyStates(most) => too_many("the number of states that can be reached", *most),
        ForwardError::TooManyWays(most) => {
            too_many("the number of ways from all states of one time to those of the next", *most)
        }
        ForwardError::Model(error) => FilterError::Model(error.clone()),
        error => FilterError::Model(ModelError::Numerical {
            computation: "the forward algorithm",
            time: 0,
            reason: error.to_string(),
        }),
    }
}

fn means(belief: &StateProbabilities) -> Vec<f64> {
    (0..belief.width()).map(|coordinate| belief.mean(coordinate)).collect()
}

/// What probabilities say of each coordinate.
fn coordinates(belief: &StateProbabilities, probabilities: &[f64]) -> Vec<Coordinate> {
    let of = |i: usize| Coordinate {
        mean: belief.mean(i),
        sd: belief.standard_deviation(i),
        quantiles: probabilities.iter().map(|probability| belief.quantile(i, *probability)).collect(),
    };
    (0..belief.width()).map(of).collect()
}

impl Steps for Forward<'_> {
    fn step(&mut self, step: &Step<'_>, measurement: &[Option<f64>]) -> Result<(), FilterError> {
        match self.filter.step_at(step, measurement) {
            Ok(found) => {
                self.log_evidence += found.log_evidence_increment;
                self.means = self.filter.belief().map(means).unwrap_or_default();
                Ok(())
            }
            Err(error) => Err(self.fail(error)),
        }
    }

    fn measurement_ahead(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Result<Vec<Predictive>, FilterError> {
        let mut ahead = self.filter.clone();
        ahead.step_at(step, &vec![None; measurement.len()]).map_err(|error| filter_error(&error))?;
        let measurement = (measurement, probabilities);
        Ok(ahead.belief().map_or(vec![], |belief| self.measured(step, belief, measurement)))
    }

    fn measurement(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Vec<Predictive> {
        let measurement = (measurement, probabilities);
        self.filter.belief().map_or(vec![], |belief| self.measured(step, belief, measurement))
    }

    fn state(&self, probabilities: &[f64]) -> Vec<Coordinate> {
        self.filter.belief().map(|belief| coordinates(belief, probabilities)).unwrap_or_default()
    }

    /// Those that say what is predicted, where a step failed.
    fn particles(&self) -> usize {
        if self.before.is_empty() { MOST_BEFORE * self.width } else { self.before.len() }
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

    fn failure(&self) -> Option<&FilterError> {
        self.failure.as_ref()
    }

    fn snapshot(&self) -> FilterState {
        let belief =
            self.filter.belief().map(|belief| (belief.states().to_vec(), belief.probabilities().to_vec()));
        FilterState::Forward(ForwardState {
            time: self.filter.time(),
            log_evidence: self.log_evidence,
            belief,
        })
    }

    fn of_particle(&self, particle: usize) -> (Option<&[f64]>, &[f64]) {
        (self.before.chunks_exact(self.width).nth(particle), &self.state)
    }
}

/// The forward algorithm over a series.
pub(super) fn filter_finite(
    finite: &dyn FiniteSystem,
    steps: &[&[StepRecord]],
    rows: &[&[Option<f64>]],
) -> Result<Vec<(StepRecord, ForwardStep)>, ForwardError> {
    let mut filter = ForwardFilter::new(finite, Limits::default());
    let of_step = |(step, row): (&StepRecord, Vec<Option<f64>>)| {
        filter.step_at(&step.step(), &row).map(|found| (step.clone(), found))
    };
    series(steps, rows).into_iter().map(of_step).collect()
}

/// Probabilities of the states of each row of a series given all rows, with these quantiles, and trajectories drawn from `p(x_{0:T−1} | y_{0:T−1})`.
///
/// # Errors
/// [`MotesError`] as the filter, or if `proceed` said to stop.
pub(super) fn smooth_finite(
    finite: &dyn FiniteSystem,
    (steps, rows): (&[&[StepRecord]], &[&[Option<f64>]]),
    (paths, quantiles): (usize, &Quantiles),
    seed: &Seed,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<(Vec<Estimate>, SmoothedPaths), MotesError> {
    let failed = |error: ForwardError| MotesError::from(filter_error(&error));
    let filtered = filter_finite(finite, steps, rows).map_err(failed)?;
    if proceed().is_break() {
        return Err(MotesError::Interrupted);
    }
    let mut streams: Vec<Stream> = (0..paths).map(|path| seed.nth(path as u64).stream()).collect();
    let found = smooth_states(finite, &filtered, Limits::default(), &mut streams).map_err(failed)?;
    // Steps before the first row have estimates that nobody asked for, and so have those between two rows.
    let ends: Vec<usize> = steps
        .iter()
        .scan(0, |count, steps| {
            *count += steps.len();
            Some(*count - 1)
        })
        .collect();
    let before = steps.first().map_or(0, |steps| steps.len().saturating_sub(1));
    let estimate =
        |at: &usize| Estimate::of_state(coordinates(&found.beliefs[*at], quantiles.probabilities()));
    let estimates = ends.iter().map(estimate).collect();
    let (times, n) = (filtered.len(), finite.state_dim());
    Ok((estimates, SmoothedPaths::independent(found.paths, times, n).without_first(before)))
}
