//! The models, stated once, what `motes learn` takes for them, and what the networks of it cost.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_proposals::{AmortisedConfig, Base, Covariance, HeadConfig, Sees};

use super::sizes::HORIZON;
use motes_models::Step;

/// The names of the models.
pub(crate) const MODELS: [&str; 2] = ["growth", "tracking"];

/// The growth model.
pub(super) struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    #[inline(always)]
    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    #[inline(always)]
    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
        state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
    }

    #[inline(always)]
    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
        measurement.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

/// A target in the plane, seen by distance and direction.
pub(super) struct Tracking;

impl Equations for Tracking {
    fn dimensions(&self) -> [usize; 2] {
        [4, 2]
    }

    #[inline(always)]
    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        let starts = [(5.0, 1.0), (5.0, 1.0), (0.2, 0.1), (-0.1, 0.1)];
        for (state, (mean, sd)) in state.iter_mut().zip(starts) {
            *state = draws.draw(normal(mean, sd));
        }
    }

    #[inline(always)]
    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..2).for_each(|i| state[i] = draws.draw(normal(x[i] + x[i + 2], 0.05)));
        (2..4).for_each(|i| state[i] = draws.draw(normal(x[i], 0.05)));
    }

    #[inline(always)]
    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal((x[0] * x[0] + x[1] * x[1]).sqrt(), 0.1));
        y.push(normal(x[1].atan2(x[0]), 0.02));
    }
}

/// What `motes learn` takes for the model where nothing is said.
pub(super) fn config(model: &str) -> AmortisedConfig {
    let covariance = Covariance::Full;
    let (base, head) = match model {
        "growth" => (Base::Transition, HeadConfig::Mixture { components: 5, covariance }),
        _ => (Base::Linearised, HeadConfig::Gaussian { covariance }),
    };
    AmortisedConfig { widths: vec![64, 64], sees: Sees::All, base, head, ..AmortisedConfig::gaussian() }
}

/// Multiplications of the network for one row: by the inputs themselves, and by what hidden layers made of them.
fn multiplications(model: &str) -> [usize; 2] {
    let [n, m] = if model == "growth" { Growth.dimensions() } else { Tracking.dimensions() };
    let config = config(model);
    let outputs = config.head.head(n).map_or(0, |head| head.outputs());
    let widths = &config.widths;
    let first = widths.first().copied().unwrap_or_default();
    let last = widths.last().copied().unwrap_or_default();
    let hidden: usize = widths.windows(2).map(|pair| pair[0] * pair[1]).sum();
    // The outputs see the inputs, too.
    [2 * (n + m) * (first + outputs), hidden + last * outputs]
}

/// Floating-point operations of the networks in a filter of so many particles.
pub(crate) fn operations(model: &str, particles: usize) -> f64 {
    let each: usize = multiplications(model).iter().sum();
    2.0 * (each * particles * (HORIZON - 1)) as f64
}

/// Floating-point operations of the networks in a gradient step of so many rows: nobody asks for the derivatives by the inputs.
pub(crate) fn operations_of_step(model: &str, rows: usize) -> f64 {
    let [by_inputs, others] = multiplications(model);
    ((4 * by_inputs + 6 * others) * rows) as f64
}
