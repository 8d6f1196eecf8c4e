//! The forward algorithm as a filter, for measurements with and without gaps.

use std::ops::Deref;

use super::error::ForwardError;
use super::layer::{Layer, next};
use super::probabilities::StateProbabilities;
use super::system::{FiniteSystem, Limits};
use crate::{ModelError, StateSpaceModel, Step};

/// What a step says.
#[derive(Debug, Clone, PartialEq)]
pub struct ForwardStep {
    /// The states after each sub-step; one where no time passes, or at the start.
    pub layers: Vec<Layer>,
    /// `log p(y_t | y_{0:t−1})`.
    pub log_evidence_increment: f64,
}

/// Probabilities of all states that can be reached, measurement by measurement.
///
/// `p(x_t | y_{0:t−1}) = Σ p(x_t | x_{t−1}) p(x_{t−1} | y_{0:t−1})`, and `p(x_t | y_{0:t}) ∝ p(y_t | x_t) p(x_t | y_{0:t−1})`. States are found as they are reached, so that
/// coordinates that follow from what was drawn before are part of them.
#[derive(Debug, Clone)]
pub struct ForwardFilter<M> {
    model: M,
    limits: Limits,
    time: usize,
    belief: Option<StateProbabilities>,
}

impl<M: Deref<Target: FiniteSystem>> ForwardFilter<M> {
    /// Before the first measurement.
    pub fn new(model: M, limits: Limits) -> Self {
        ForwardFilter { model, limits, time: 0, belief: None }
    }

    /// That which had taken in so many measurements and had this belief then; none before the first.
    pub fn resume(model: M, limits: Limits, time: usize, belief: Option<StateProbabilities>) -> Self {
        ForwardFilter { model, limits, time, belief }
    }

    /// `p(x_t | y_{0:t})` after the last measurement; none before the first.
    pub fn belief(&self) -> Option<&StateProbabilities> {
        self.belief.as_ref()
    }

    /// How many measurements were taken in.
    pub fn time(&self) -> usize {
        self.time
    }

    /// Takes in the measurement (`M` entries, some of which may be missing) of the step that leads to it.
    ///
    /// # Errors
    /// [`ForwardError`]; nothing is taken in then.
    pub fn step_at(
        &mut self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<ForwardStep, ForwardError> {
        let (model, width) = (&*self.model, measurement.len());
        let expected = model.measurement_dim();
        if width != expected {
            return Err(ModelError::MeasurementWidth { width, expected }.into());
        }
        let mut predicted: Vec<StateProbabilities> = Vec::new();
        match (&self.belief, step.sub_steps) {
            (None, _) => predicted.push(next(model, &step.part(0, model.input_dim()), None, self.limits)?),
            (Some(belief), 0) => predicted.push(belief.clone()),
            (Some(belief), count) => {
                for sub_step in 0..count {
                    let part = step.part(sub_step, model.input_dim());
                    let before = predicted.last().unwrap_or(belief);
                    predicted.push(next(model, &part, Some(before), self.limits)?);
                }
            }
        }
        let mut layers: Vec<Layer> = predicted
            .into_iter()
            .map(|predicted| Layer { filtered: predicted.probabilities().to_vec(), predicted })
            .collect();
        let mut log_evidence_increment = 0.0;
        if let (Some(last), true) = (layers.last_mut(), measurement.iter().any(Option::is_some)) {
            log_evidence_increment = weigh(model, step, measurement, last)?;
        }
        self.belief = layers.last().map(Layer::belief);
        self.time += 1;
        Ok(ForwardStep { layers, log_evidence_increment })
    }
}

/// Weighs the states by the measurement, and gives its log density.
fn weigh(
    model: &(impl FiniteSystem + ?Sized),
    step: &Step<'_>,
    measurement: &[Option<f64>],
    layer: &mut Layer,
) -> Result<f64, ForwardError> {
    let mut log_likelihoods = vec![f64::NAN; layer.filtered.len()];
    model.log_likelihoods(step, layer.predicted.states(), measurement, &mut log_likelihoods)?;
    let is_wrong = |value: &f64| value.is_nan() || *value == f64::INFINITY;
    if let Some(number) = log_likelihoods.iter().position(is_wrong) {
        let state = layer.predicted.state(number).to_vec();
        return Err(ForwardError::NotANumber { previous: None, state });
    }
    let possible = log_likelihoods.iter().zip(&layer.filtered).filter(|(_, own)| **own > 0.0);
    let largest = possible.map(|(value, _)| *value).fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return Err(ForwardError::Impossible);
    }
    for (own, value) in layer.filtered.iter_mut().zip(&log_likelihoods) {
        *own *= (value - largest).exp();
    }
    let sum: f64 = layer.filtered.iter().sum();
    layer.filtered.iter_mut().for_each(|own| *own /= sum);
    Ok(largest + sum.ln())
}
