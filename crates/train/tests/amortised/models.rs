//! Models to learn for.

use motes_models::Step;
use motes_models::equations::{
    Coordinates, Draws, Equations, Scalar, exponential, normal, poisson, student_t, uniform,
};

/// `x_t = A x_{t−1} + v`, `y_t = C x_t + w`, with two coordinates and one measurement.
pub(crate) struct Linear;

impl Equations for Linear {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..2).for_each(|i| state[i] = draws.draw(normal(0.0, 1.0)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * 0.9 + x[1] * 0.2, 0.7));
        state[1] = draws.draw(normal(x[1] * 0.7, 1.1));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] + x[1] * 0.5, 0.5));
    }
}

/// The growth model: two modes.
pub(crate) struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
        state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

/// What bounds or thickens the noise of [`Awkward`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Noise {
    /// Bounded on one side.
    HalfLine,
    /// Bounded on both.
    Interval,
    /// With the tails of Student's t.
    HeavyTails,
}

/// One coordinate whose noise is not normal, with a count and a number with heavy tails measured of it.
pub(crate) struct Awkward(pub(crate) Noise);

impl Equations for Awkward {
    fn dimensions(&self) -> [usize; 2] {
        [1, 2]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.3, 0.8));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let mean = x[0].sin() + x[0] * 0.5;
        state[0] = draws.draw(match self.0 {
            Noise::HalfLine => exponential(0.6).shifted(mean - 0.5),
            Noise::Interval => uniform(mean - 0.8, mean + 1.2),
            Noise::HeavyTails => student_t(4.0, mean, 0.5),
        });
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(poisson((x[0] * 0.8 + 0.5).exp()));
        y.push(student_t(3.0, x[0] * x[0] * 0.3, 0.7));
    }
}

/// Returns whose log-variance goes back to 0, by steps of a standard deviation.
pub(crate) struct LogVariance(pub(crate) f64);

impl Equations for LogVariance {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 3.0 * self.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * 0.95, self.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(0.0, (x[0] * 0.5).exp()));
    }
}
