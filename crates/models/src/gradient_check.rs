//! A check of state gradients written by hand, against central differences of the log densities.

use std::fmt;
use std::slice::from_mut;

use thiserror::Error;

use crate::batch::Rows;
use crate::{ModelError, Simulator, StateGradients, Stream, check_model};

/// A derivative that [`StateGradients`] gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Derivative {
    /// `∂ log p(x_0) / ∂x_0`.
    Initial,
    /// `∂ log p(x_t | x_{t−1}) / ∂x_{t−1}`.
    TransitionByPrevious,
    /// `∂ log p(x_t | x_{t−1}) / ∂x_t`.
    TransitionByState,
    /// `∂ log p(y_t | x_t) / ∂x_t`.
    Likelihood,
}

impl fmt::Display for Derivative {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Derivative::Initial => "∂ log p(x_0) / ∂x_0",
            Derivative::TransitionByPrevious => "∂ log p(x_t | x_{t-1}) / ∂x_{t-1}",
            Derivative::TransitionByState => "∂ log p(x_t | x_{t-1}) / ∂x_t",
            Derivative::Likelihood => "∂ log p(y_t | x_t) / ∂x_t",
        })
    }
}

/// One coordinate of a gradient at one point, beside its central difference.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Which derivative.
    pub derivative: Derivative,
    /// The time `t` of the density.
    pub time: usize,
    /// The coordinate.
    pub coordinate: usize,
    /// The state by which the derivative is taken.
    pub point: Vec<f64>,
    /// What the model says.
    pub gradient: f64,
    /// The central difference.
    pub difference: f64,
    /// How far they are apart, as a share of the largest coordinate of the gradient. Coordinates are measured in standard deviations
    /// of the drawn states. Rounding is left out.
    pub relative_error: f64,
}

/// What a check found where all gradients are right.
#[derive(Debug, Clone, PartialEq)]
pub struct GradientReport {
    /// Whether derivatives of densities of states were compared: a model may have none.
    pub of_states: bool,
    /// How many coordinates were compared.
    pub compared: usize,
    /// How many had no central difference, because the density has a kink or an edge near the point.
    pub skipped: usize,
    /// The largest relative error of all.
    pub worst: Comparison,
}

/// Why gradients are not known to be right.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GradientError {
    /// A gradient differs from the central difference; the worst one of all.
    #[error(
        "{} at time {}, coordinate {}, is {:e}; the central difference is {:e} (relative error {:.1e}, at the state {:?})",
        .0.derivative, .0.time, .0.coordinate, .0.gradient, .0.difference, .0.relative_error, .0.point
    )]
    Wrong(Box<Comparison>),
    /// A derivative could be compared nowhere: no point lies inside the support, or the density is smooth at none.
    #[error("{0} has a central difference at no point that was drawn")]
    NotCompared(Derivative),
    /// The model cannot be simulated.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Trajectories whose states are the points; they go through the gradients as one batch.
const TRAJECTORIES: usize = 4;

/// The step of a central difference, in standard deviations of a coordinate: near the cube root of the rounding error.
const STEP: f64 = 1e-5;

/// Rounding errors of a log density, in units in its last place.
const ROUNDING: f64 = 32.0;

/// Compares all gradients of `model` with central differences, at the states of four trajectories of `horizon` times: of a model without a transition density, those of
/// the measurement alone.
///
/// A relative error of 1e-5 is a good `tolerance`: right gradients stay below it, and wrong ones rarely do.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian, Seed, check_gradients};
///
/// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.5]])?;
/// let report = check_gradients(&model, 3, 1e-5, &mut Seed::from_u64(1).stream())?;
/// assert!(report.worst.relative_error < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// - [`GradientError::Wrong`] with the worst coordinate, if a relative error is above `tolerance` or not a number.
/// - [`GradientError::NotCompared`] if a derivative could not be checked.
/// - [`GradientError::Model`] as [`simulate`](crate::simulate).
pub fn check_gradients(
    model: &(impl StateGradients + Simulator + ?Sized),
    horizon: usize,
    tolerance: f64,
    stream: &mut Stream,
) -> Result<GradientReport, GradientError> {
    check_gradients_from(model, 0, horizon, tolerance, stream)
}

/// [`check_gradients`] of a model that is measured from the time `measured` on only: measurements before it need not have a density.
///
/// # Errors
/// As [`check_gradients`].
pub fn check_gradients_from(
    model: &(impl StateGradients + Simulator + ?Sized),
    measured: usize,
    horizon: usize,
    tolerance: f64,
    stream: &mut Stream,
) -> Result<GradientReport, GradientError> {
    let horizon = horizon.max(measured + 2);
    let trajectories: Vec<Drawn> =
        (0..TRAJECTORIES).map(|_| drawn(model, measured, horizon, stream)).collect::<Result<_, _>>()?;
    let n = model.state_dim();
    let states = |time: usize| -> Vec<f64> {
        trajectories.iter().flat_map(|trajectory| &trajectory.states[time]).copied().collect()
    };
    let mut check = Check { steps: steps(&trajectories, n), tolerance, skipped: 0, found: Vec::new() };
    // What a model does not write is NaN, and an error.
    let unwritten = || vec![f64::NAN; TRAJECTORIES * n];

    if let Some(density) = model.density() {
        let (initial, mut d_states) = (states(0), unwritten());
        let start = model.step_of_index(0);
        model.initial_gradients(&start, &initial, &mut d_states);
        check.compare(Derivative::Initial, 0, &initial, &d_states, |_, x| {
            density.log_density(&start, None, x)
        });
        for time in 1..horizon {
            let step = model.step_of_index(time);
            let (previous, now) = (states(time - 1), states(time));
            let mut d_previous = unwritten();
            d_states = unwritten();
            model.transition_gradients(&step, &previous, &now, &mut d_previous, &mut d_states);
            let row = |of: &[f64], at: usize| of[at * n..(at + 1) * n].to_vec();
            check.compare(Derivative::TransitionByPrevious, time, &previous, &d_previous, |at, x| {
                density.log_density(&step, Some(x), &row(&now, at))
            });
            check.compare(Derivative::TransitionByState, time, &now, &d_states, |at, x| {
                density.log_density(&step, Some(&row(&previous, at)), x)
            });
        }
    }
    for time in measured..horizon {
        let (step, now) = (model.step_of_index(time), states(time));
        for measurement in trajectories.iter().map(|trajectory| &trajectory.measurements[time]) {
            let mut d_states = unwritten();
            model.likelihood_gradients(&step, &now, measurement, &mut d_states);
            check.compare(Derivative::Likelihood, time, &now, &d_states, |_, x| {
                // What cannot be had is NaN, and an error.
                model.log_likelihood(&step, x, measurement).unwrap_or(f64::NAN)
            });
        }
    }
    check.report(model.density().is_some())
}

/// A trajectory, time by time.
struct Drawn {
    states: Vec<Vec<f64>>,
    measurements: Vec<Vec<f64>>,
}

/// A trajectory of so many times, whose measurements are numbers from the time `measured` on.
fn drawn(
    model: &(impl Simulator + ?Sized),
    measured: usize,
    horizon: usize,
    stream: &mut Stream,
) -> Result<Drawn, ModelError> {
    check_model(model)?;
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let mut drawn = Drawn { states: Vec::new(), measurements: Vec::new() };
    for time in 0..horizon {
        let step = model.step_of_index(time);
        let (mut state, mut measurement) = (vec![0.0; n], vec![0.0; m]);
        let previous = drawn.states.last().map(|before: &Vec<f64>| Rows::all(before, n));
        model.sample_states(&step, previous, from_mut(stream), &mut state);
        model.sample_measurements(&step, &state, from_mut(stream), &mut measurement);
        let is_measured = time < measured || measurement.iter().all(|value| value.is_finite());
        if !is_measured || !state.iter().all(|value| value.is_finite()) {
            let reason = format!("state {state:?}, measurement {measurement:?}");
            return Err(ModelError::Numerical { computation: "simulating the system", time, reason });
        }
        drawn.states.push(state);
        drawn.measurements.push(measurement);
    }
    Ok(drawn)
}

/// The step of each coordinate, by its standard deviation over all states.
fn steps(trajectories: &[Drawn], n: usize) -> Vec<f64> {
    let rows = || trajectories.iter().flat_map(|trajectory| &trajectory.states);
    let count = rows().count() as f64;
    let deviation = |i: usize| {
        let mean = rows().map(|row| row[i] / count).sum::<f64>();
        rows().map(|row| (row[i] - mean).powi(2) / count).sum::<f64>().sqrt()
    };
    (0..n).map(|i| STEP * Some(deviation(i)).filter(|deviation| *deviation > 0.0).unwrap_or(1.0)).collect()
}

/// A check in progress.
struct Check {
    steps: Vec<f64>,
    tolerance: f64,
    skipped: usize,
    found: Vec<Comparison>,
}

impl Check {
    /// Compares the gradient of each row of `points` with the differences of `density`, which is asked with the row's number.
    fn compare(
        &mut self,
        derivative: Derivative,
        time: usize,
        points: &[f64],
        gradients: &[f64],
        density: impl Fn(usize, &[f64]) -> f64,
    ) {
        let n = self.steps.len();
        for (at, (point, gradient)) in points.chunks_exact(n).zip(gradients.chunks_exact(n)).enumerate() {
            let value = density(at, point);
            // Outside the support there is no gradient.
            if value == f64::NEG_INFINITY {
                continue;
            }
            let change = |i: usize, step: f64| {
                let mut moved = point.to_vec();
                moved[i] = point[i] + step;
                let above = density(at, &moved);
                moved[i] = point[i] - step;
                (above - density(at, &moved)) / 2.0
            };
            // By one step and by two: where these differ, the density is not smooth.
            let changes: Vec<[f64; 2]> = self
                .steps
                .iter()
                .enumerate()
                .map(|(i, step)| [change(i, *step), change(i, 2.0 * step) / 2.0])
                .collect();
            let largest = gradient.iter().zip(&self.steps).map(|(g, step)| (g * step).abs());
            let largest = changes.iter().map(|[change, _]| change.abs()).chain(largest).fold(0.0, f64::max);
            let rounding = ROUNDING * f64::EPSILON * (1.0 + value.abs());
            for (coordinate, ([change, other], step)) in changes.into_iter().zip(&self.steps).enumerate() {
                let apart = |value: f64| match (value - change).abs() - rounding {
                    apart if apart <= 0.0 => 0.0,
                    apart => apart / largest,
                };
                let is_smooth = apart(other) <= self.tolerance;
                if !is_smooth {
                    self.skipped += 1;
                    continue;
                }
                self.found.push(Comparison {
                    derivative,
                    time,
                    coordinate,
                    point: point.to_vec(),
                    gradient: gradient[coordinate],
                    difference: change / step,
                    relative_error: apart(gradient[coordinate] * step),
                });
            }
        }
    }

    fn report(self, of_states: bool) -> Result<GradientReport, GradientError> {
        let all = [
            Derivative::Likelihood,
            Derivative::Initial,
            Derivative::TransitionByPrevious,
            Derivative::TransitionByState,
        ];
        for derivative in all.into_iter().take(if of_states { all.len() } else { 1 }) {
            if self.found.iter().all(|comparison| comparison.derivative != derivative) {
                return Err(GradientError::NotCompared(derivative));
            }
        }
        let compared = self.found.len();
        // NaN is the worst there is.
        let size = |comparison: &Comparison| comparison.relative_error.abs();
        let worst = self.found.into_iter().max_by(|a, b| size(a).total_cmp(&size(b)));
        match worst {
            Some(worst) if worst.relative_error <= self.tolerance => {
                Ok(GradientReport { of_states, compared, skipped: self.skipped, worst })
            }
            Some(worst) => Err(GradientError::Wrong(Box::new(worst))),
            None => Err(GradientError::NotCompared(Derivative::Likelihood)),
        }
    }
}
