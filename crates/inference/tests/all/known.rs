//! Likelihoods whose posteriors are known.

use std::convert::Infallible;

use motes_inference::{Estimator, EstimatorCost, Likelihood};
use motes_models::{LN_2PI, Seed, fill_standard_normal};

/// `y = A v + N(0, s²)` for two coordinates, exact or with unbiased noise of variance `noise/K`.
pub(crate) struct Line {
    pub(crate) rows: Vec<[f64; 3]>,
    pub(crate) sd: f64,
    pub(crate) noise: f64,
    costs: Vec<EstimatorCost>,
}

impl Line {
    /// With three measurements; `noise` is `K` times the variance of `log ẑ`, 0 where it is exact.
    pub(crate) fn new(noise: f64) -> Self {
        let rows = vec![[1.0, 0.0, 0.7], [1.0, 1.0, 2.0], [0.5, -1.0, -0.3]];
        let costs = vec![EstimatorCost { per_particle: 1.0, fixed: 0.0, is_exact: noise == 0.0 }];
        Line { rows, sd: 0.4, noise, costs }
    }

    pub(crate) fn exact(&self, v: &[f64]) -> f64 {
        let of_row = |[a, b, y]: &[f64; 3]| {
            let rest = (y - a * v[0] - b * v[1]) / self.sd;
            -0.5 * rest * rest - self.sd.ln() - 0.5 * LN_2PI
        };
        self.rows.iter().map(of_row).sum()
    }

    /// The posterior's means and standard deviations, and `log p(y)`, by sums over a fine grid.
    pub(crate) fn on_a_grid(&self) -> ([f64; 2], [f64; 2], f64) {
        let (step, ends) = (0.02, 5.0);
        let count = (2.0 * ends / step) as usize;
        let (mut sum, mut first, mut second) = (0.0, [0.0; 2], [0.0; 2]);
        for i in 0..=count {
            for j in 0..=count {
                let v = [i as f64 * step - ends, j as f64 * step - ends];
                let density = (self.exact(&v) - 0.5 * (v[0] * v[0] + v[1] * v[1]) - LN_2PI).exp();
                let mass = density * step * step;
                sum += mass;
                for at in 0..2 {
                    first[at] += mass * v[at];
                    second[at] += mass * v[at] * v[at];
                }
            }
        }
        let means = first.map(|value| value / sum);
        let sds = [0, 1].map(|at| (second[at] / sum - means[at] * means[at]).sqrt());
        (means, sds, sum.ln())
    }
}

/// `N(−s²/2, s²)`, the logarithm of something with mean 1.
pub(crate) fn log_of_noise(variance: f64, seed: &Seed) -> f64 {
    let mut noise = [0.0];
    fill_standard_normal(&mut seed.stream(), &mut noise);
    variance.sqrt() * noise[0] - 0.5 * variance
}

impl Likelihood for Line {
    type Error = Infallible;

    fn dimension(&self) -> usize {
        2
    }

    fn estimators(&self) -> &[EstimatorCost] {
        &self.costs
    }

    fn log_likelihood(&self, v: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, Infallible> {
        Ok(self.exact(v) + log_of_noise(self.noise / estimator.particles as f64, seed))
    }
}

/// A parameter of which the data say the sign alone is not 0: two modes, at −1 and 1, of which the chance of the second is 0.7.
pub(crate) struct TwoModes {
    pub(crate) costs: Vec<EstimatorCost>,
}

impl Likelihood for TwoModes {
    type Error = Infallible;

    fn dimension(&self) -> usize {
        1
    }

    fn estimators(&self) -> &[EstimatorCost] {
        &self.costs
    }

    fn log_likelihood(&self, v: &[f64], _: Estimator, _: &Seed) -> Result<f64, Infallible> {
        let mode = |at: f64, share: f64| share * (-0.5 * ((v[0] - at) / 0.2).powi(2)).exp();
        // Equal densities of the prior at both.
        Ok((mode(-1.0, 0.3) + mode(1.0, 0.7)).ln())
    }
}

/// A likelihood that is 0 wherever the first coordinate is below this.
pub(crate) struct Half {
    pub(crate) above: f64,
    pub(crate) costs: Vec<EstimatorCost>,
}

impl Likelihood for Half {
    type Error = Infallible;

    fn dimension(&self) -> usize {
        1
    }

    fn estimators(&self) -> &[EstimatorCost] {
        &self.costs
    }

    fn log_likelihood(&self, v: &[f64], _: Estimator, _: &Seed) -> Result<f64, Infallible> {
        Ok(if v[0] > self.above { 0.0 } else { f64::NEG_INFINITY })
    }
}

pub(crate) const EXACT: EstimatorCost = EstimatorCost { per_particle: 1.0, fixed: 0.0, is_exact: true };
