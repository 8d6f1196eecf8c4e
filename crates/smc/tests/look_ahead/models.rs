//! Small models that are not linear, and their evidence by quadrature.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, log_normal, normal, poisson};
use motes_models::{StateSpaceModel, Step};
use motes_smc::RecordedStep;

/// Counts of a log-rate that walks slowly.
pub struct Counts {
    pub sd: f64,
}

impl Equations for Counts {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(1.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(before[0], self.sd));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(poisson(x[0].exp()));
    }
}

/// Returns whose log-variance goes back to its mean.
pub struct Volatility {
    pub sd: f64,
}

impl Equations for Volatility {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(before[0] * 0.95, self.sd));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(0.0, (x[0] * 0.5).exp()));
    }
}

/// A store that loses a part and gets a skewed one at each step: not linear in its noise.
pub struct Store {
    pub sd: f64,
}

impl Equations for Store {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(log_normal(0.5, 0.5));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(log_normal(-0.5, self.sd).shifted(before[0] * 0.7));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.4));
    }
}

/// The log-evidence of a model of one coordinate with densities, on a grid of `count` points over `range`.
pub fn evidence_on_grid<M: Equations>(
    model: &M,
    rows: &[RecordedStep],
    range: [f64; 2],
    count: usize,
) -> f64 {
    let width = (range[1] - range[0]) / (count - 1) as f64;
    let grid: Vec<f64> = (0..count).map(|i| range[0] + width * i as f64).collect();
    let density = model.density().expect("these models have one");
    let (mut belief, mut log, mut likelihoods) = (vec![0.0; count], 0.0, vec![0.0; count]);
    for RecordedStep { step, measurement } in rows {
        let step = step.step();
        let predicted: Vec<f64> = match step.index {
            0 => grid.iter().map(|x| density.log_density(&step, None, &[*x]).exp()).collect(),
            _ => {
                let mut predicted = vec![0.0; count];
                let mut out = vec![0.0; count];
                // However small: where a rate jumps, what comes next is said by the far tail.
                for (at, mass) in belief.iter().enumerate().filter(|(_, mass)| **mass > 0.0) {
                    let previous = vec![grid[at]; count];
                    let previous = motes_models::batch::Rows::all(&previous, 1);
                    density.log_densities(&step, Some(previous), &grid, &mut out);
                    predicted.iter_mut().zip(&out).for_each(|(sum, density)| *sum += mass * density.exp());
                }
                predicted
            }
        };
        StateSpaceModel::log_likelihoods(model, &step, &grid, measurement, &mut likelihoods).unwrap();
        belief = predicted
            .iter()
            .zip(&likelihoods)
            .map(|(density, likelihood)| density * likelihood.exp() * width)
            .collect();
        let total: f64 = belief.iter().sum();
        log += total.ln();
        belief.iter_mut().for_each(|mass| *mass /= total);
    }
    log
}
