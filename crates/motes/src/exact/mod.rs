//! Exact answers without particles, where a model has them: by the Kalman filter, or by the forward algorithm.

mod forward;
mod kalman;
mod linear_evidence;
mod rows;

use std::ops::ControlFlow;

use motes_formulas::FormulaModel;
use motes_models::forward::{FiniteSystem, ForwardFilter, Limits};
use motes_models::kalman::{KalmanFilter, LinearSystem};
use motes_models::{Seed, StepRecord};
use motes_smc::{RecordedStep, SmoothedPaths};

use crate::error::MotesError;
use crate::estimate::Estimate;
use crate::exact_system::ExactSystem;
use crate::model::Model;
use crate::quantiles::Quantiles;
use crate::running_state::FilterState;
use crate::steps::Steps;
use forward::{Forward, filter_finite, smooth_finite};
use kalman::{Kalman, filter_linear, smooth_linear};
use rows::with_measurements;

/// A filter without particles before its first measurement; none of a model that has no exact answers.
pub(crate) fn exact_filter(model: &Model) -> Option<Box<dyn Steps + '_>> {
    Some(match model.exact_system()? {
        ExactSystem::Linear(linear) => Box::new(Kalman::new(linear)),
        ExactSystem::Finite(finite) => Box::new(Forward::new(model, finite)),
    })
}

/// Such a filter where it was written down; none of another model, or of another kind of filter.
pub(crate) fn restored(model: &Model, state: FilterState) -> Option<Box<dyn Steps + '_>> {
    match (model.exact_system()?, state) {
        (ExactSystem::Linear(linear), FilterState::Exact(state)) => {
            Some(Box::new(Kalman::restore(linear, state)?))
        }
        (ExactSystem::Finite(finite), FilterState::Forward(state)) => {
            Some(Box::new(Forward::restore(model, finite, state)?))
        }
        _ => None,
    }
}

/// The exact log-evidence of a series beside its particles, as far as it has come.
pub struct ExactEvidence<'m> {
    filter: Beside<'m>,
    /// What gives it, in words.
    name: &'static str,
    log_evidence: f64,
}

enum Beside<'m> {
    Linear(KalmanFilter<&'m dyn LinearSystem>),
    Finite(ForwardFilter<&'m dyn FiniteSystem>),
}

/// So many particles take about as long as a way between two states.
const PARTICLES_PER_WAY: usize = 4;

impl<'m> ExactEvidence<'m> {
    /// That of a model that has one, where it costs next to nothing beside so many particles; none of any other.
    pub fn beside(model: &'m Model, particles: usize) -> Option<Self> {
        let (system, n) = (model.exact_system()?, model.states().len());
        let name = system.name();
        let filter = match system {
            ExactSystem::Linear(linear) if n * n <= particles => Beside::Linear(KalmanFilter::new(linear)),
            ExactSystem::Linear(_) => return None,
            ExactSystem::Finite(finite) => {
                let ways = particles / PARTICLES_PER_WAY;
                let limits = Limits { states: ways, ways };
                Beside::Finite(ForwardFilter::new(finite, limits))
            }
        };
        Some(ExactEvidence { filter, name, log_evidence: 0.0 })
    }

    /// Takes in the measurement of a row by the steps that lead to it, and says whether that could be done.
    pub fn row(&mut self, steps: &[StepRecord], measurement: &[Option<f64>]) -> bool {
        for (step, measurement) in with_measurements(steps, measurement) {
            let step = step.step();
            let found = match &mut self.filter {
                Beside::Linear(filter) => {
                    filter.step_at(&step, &measurement).ok().map(|step| step.log_evidence_increment)
                }
                Beside::Finite(filter) => {
                    filter.step_at(&step, &measurement).ok().map(|step| step.log_evidence_increment)
                }
            };
            let Some(increment) = found else { return false };
            self.log_evidence += increment;
        }
        true
    }

    /// `log p(y_{0:t})`.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence
    }

    /// What gives it: `the Kalman filter`.
    pub fn name(&self) -> &'static str {
        self.name
    }
}

/// `log p(y)` of a series and nothing else, by fewer operations than the filter takes; none where the filter has to be asked.
pub(crate) fn log_evidence_alone(model: &Model, steps: &[RecordedStep]) -> Option<f64> {
    let ExactSystem::Linear(linear) = model.exact_system()? else { return None };
    let is_invariant =
        model.timeline().is_none() && model.formulas().is_none_or(FormulaModel::is_time_invariant);
    linear_evidence::log_evidence(linear, is_invariant, steps)
}

/// What an exact filter says of a series.
pub(crate) struct ExactSeries {
    /// The means of the state (`N`) after each step.
    pub(crate) means: Vec<Vec<f64>>,
    /// `log p(y_t | y_{0:t−1})` of each step.
    pub(crate) increments: Vec<f64>,
}

/// The exact filter over a series (`T` rows, with the steps that lead to each); none where it does not get through.
///
/// # Errors
/// [`MotesError`] as the Kalman filter.
pub(crate) fn filter_series(
    system: ExactSystem<'_>,
    steps: &[&[StepRecord]],
    rows: &[&[Option<f64>]],
) -> Result<Option<ExactSeries>, MotesError> {
    match system {
        ExactSystem::Linear(linear) => {
            let steps = filter_linear(linear, steps, rows)?.steps;
            Ok(Some(ExactSeries {
                means: steps.iter().map(|step| step.filtered.mean.iter().copied().collect()).collect(),
                increments: steps.iter().map(|step| step.log_evidence_increment).collect(),
            }))
        }
        ExactSystem::Finite(finite) => {
            let Ok(steps) = filter_finite(finite, steps, rows) else { return Ok(None) };
            let means = |belief: motes_models::forward::StateProbabilities| {
                (0..belief.width()).map(|coordinate| belief.mean(coordinate)).collect()
            };
            let last = steps.iter().filter_map(|(_, step)| step.layers.last());
            Ok(Some(ExactSeries {
                means: last.map(|layer| means(layer.belief())).collect(),
                increments: steps.iter().map(|(_, step)| step.log_evidence_increment).collect(),
            }))
        }
    }
}

/// What an exact smoother says of a series (`T` rows, with the steps that lead to each), with these quantiles, and trajectories drawn from `p(x_{0:T−1} | y_{0:T−1})`.
///
/// # Errors
/// [`MotesError`] for a model without exact answers, as the filter, or if `proceed` said to stop.
pub(crate) fn smooth_exactly(
    model: &Model,
    steps: &[&[StepRecord]],
    rows: &[&[Option<f64>]],
    (paths, quantiles): (usize, &Quantiles),
    seed: &Seed,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<(Vec<Estimate>, SmoothedPaths), MotesError> {
    match model.exact_system().ok_or_else(|| not_exact(model))? {
        ExactSystem::Linear(linear) => {
            smooth_linear(model, linear, (steps, rows), (paths, quantiles), seed, proceed)
        }
        ExactSystem::Finite(finite) => {
            smooth_finite(finite, (steps, rows), (paths, quantiles), seed, proceed)
        }
    }
}

/// Why there is nothing exact.
pub(crate) fn not_exact(model: &Model) -> MotesError {
    let reason = format!(
        "{} is neither linear with Gaussian noise nor a model of discrete states; take --proposal linearised or bootstrap",
        model.name()
    );
    MotesError::Proposal { proposal: "exact".into(), reason }
}
