//! Log-evidences that are known exactly: by Kalman's filter, by quadrature on a grid, and by the forward algorithm.

use motes::formulas::FormulaModel;
use motes_models::batch::Rows;
use motes_models::{
    Measurements, ModelError, PartialMeasurements, StateSpaceModel, TransitionDensity, kalman,
};
use serde::{Deserialize, Serialize};

/// How the log-evidence of a model is known.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Exact {
    /// `"kalman"`: the model is linear and Gaussian.
    Linear(LinearFilter),
    /// A state of one coordinate, by the trapezoidal rule on a grid.
    Quadrature { low: f64, high: f64, points: usize },
    /// Two regimes, which a state of one coordinate stands for.
    Forward {
        /// Their probabilities at the start.
        initial: [f64; 2],
        /// The probability that a regime goes on.
        stay: f64,
        /// A state of each.
        states: [f64; 2],
    },
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum LinearFilter {
    Kalman,
}

impl Exact {
    /// `log p(y_{0:T−1})`, and, of a linear Gaussian model, the standard deviations of the last state given all measurements.
    pub(super) fn of(
        &self,
        model: &FormulaModel,
        measurements: &Measurements,
    ) -> Result<(f64, Option<Vec<f64>>), ModelError> {
        match self {
            Exact::Linear(LinearFilter::Kalman) => {
                let linear = model.linear_system().ok_or(ModelError::Parameter {
                    name: "exact",
                    value: "kalman".into(),
                    expected: "of a linear Gaussian model",
                })?;
                let filtered = kalman::filter(linear, measurements)?;
                let last = filtered.steps.last().map(|step| &step.filtered);
                let deviations =
                    last.map(|belief| (0..model.state_dim()).map(|i| belief.standard_deviation(i)).collect());
                Ok((filtered.log_evidence(), deviations))
            }
            Exact::Quadrature { low, high, points } => {
                Ok((quadrature(model, measurements, *low, *high, *points)?, None))
            }
            Exact::Forward { initial, stay, states } => {
                Ok((forward(model, measurements, *initial, *stay, *states)?, None))
            }
        }
    }
}

/// Densities further below the largest than this are left out, in nats.
const NEGLIGIBLE: f64 = 50.0;

/// `p_t(x) ∝ p(y_t | x) ∫ p(x | x′) p_{t−1}(x′) dx′` on a grid.
fn quadrature(
    model: &FormulaModel,
    measurements: &Measurements,
    low: f64,
    high: f64,
    points: usize,
) -> Result<f64, ModelError> {
    let width = (high - low) / (points as f64 - 1.0);
    let grid: Vec<f64> = (0..points).map(|i| low + width * i as f64).collect();
    let (mut log_density, mut of_grid) = (vec![0.0; points], vec![0.0; points]);
    let mut total = 0.0;
    model.log_densities(&model.step_of_index(0), None, &grid, &mut log_density);
    for (time, measurement) in PartialMeasurements::from(measurements).rows().enumerate() {
        let step = model.step_of_index(time);
        if time > 0 {
            let mut next = vec![0.0; points];
            for (from, log) in grid.iter().zip(&log_density).filter(|(_, log)| **log > -NEGLIGIBLE) {
                let previous = vec![*from; points];
                model.log_densities(&step, Some(Rows::all(&previous, 1)), &grid, &mut of_grid);
                let mass = log.exp() * width;
                next.iter_mut().zip(&of_grid).for_each(|(next, log)| *next += mass * log.exp());
            }
            log_density = next.into_iter().map(f64::ln).collect();
        }
        model.log_likelihoods(&step, &grid, measurement, &mut of_grid)?;
        log_density.iter_mut().zip(&of_grid).for_each(|(density, log)| *density += log);
        let increment = log_sum(&log_density) + width.ln();
        log_density.iter_mut().for_each(|density| *density -= increment);
        total += increment;
    }
    Ok(total)
}

/// The forward algorithm over two regimes.
fn forward(
    model: &FormulaModel,
    measurements: &Measurements,
    initial: [f64; 2],
    stay: f64,
    states: [f64; 2],
) -> Result<f64, ModelError> {
    let (mut probabilities, mut total) = (initial, 0.0);
    for (time, measurement) in PartialMeasurements::from(measurements).rows().enumerate() {
        if time > 0 {
            let [first, second] = probabilities;
            probabilities = [first * stay + second * (1.0 - stay), second * stay + first * (1.0 - stay)];
        }
        let mut logs = [0.0; 2];
        let step = model.step_of_index(time);
        model.log_likelihoods(&step, &states, measurement, &mut logs)?;
        logs.iter_mut().zip(probabilities).for_each(|(log, probability)| *log += probability.ln());
        let increment = log_sum(&logs);
        probabilities = logs.map(|log| (log - increment).exp());
        total += increment;
    }
    Ok(total)
}

/// `log Σ exp`.
fn log_sum(logs: &[f64]) -> f64 {
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    largest + logs.iter().map(|log| (log - largest).exp()).sum::<f64>().ln()
}
