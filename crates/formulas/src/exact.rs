//! The matrices behind formulas that are linear with Gaussian noise: such a model has exact answers.

use faer::{Col, Mat};
use motes_models::batch::LANES;
use motes_models::equations::{Coordinates, Distribution, Equations, NoiseSpace, Normal, Wrapped};
use motes_models::kalman::{Belief, LinearMap, LinearSystem};
use motes_models::{StateSpaceModel, Step};

use crate::model::FormulaModel;

/// Means and standard deviations of normal measurements; NaN for any other.
#[derive(Default)]
struct Normals {
    means: Vec<f64>,
    sds: Vec<f64>,
}

impl Coordinates<f64> for Normals {
    fn push(&mut self, distribution: Distribution<f64>) {
        let (mean, sd) = match distribution {
            Distribution::Normal(Normal { mean, sd }) => (mean, sd),
            _ => (f64::NAN, f64::NAN),
        };
        self.means.push(mean);
        self.sds.push(sd);
    }

    fn push_wrapped(&mut self, _: &Wrapped<'_, f64>) {
        self.means.push(f64::NAN);
        self.sds.push(f64::NAN);
    }
}

impl FormulaModel {
    /// The model as one that is linear with Gaussian noise, if it is: draws, states and measurements are normal with means that are linear in states and draws and
    /// standard deviations without them, and what follows without noise is linear. Times, inputs, sub-steps, and coordinates that share a draw do not stand in the way.
    pub fn linear_system(&self) -> Option<&dyn LinearSystem> {
        if self.is_linear() { Some(self) } else { None }
    }

    /// The map from `x_{t−1}` and the noise of a step to `x_t`, which is linear: its value at 0 (`N`), its derivatives by `x_{t−1}` (`N×N`; none at the start), and by the
    /// noise (`N×Q`).
    fn linear_map(&self, step: &Step<'_>) -> (Vec<f64>, Mat<f64>, Mat<f64>) {
        let (n, q) = (self.state_dim(), self.draws(step).len());
        let from = if step.index == 0 { 0 } else { n };
        // The point 0, then a unit vector for each coordinate and each draw: a lane each.
        let points = 1 + from + q;
        let (mut previous, mut noise) = (vec![0.0; n * LANES], vec![0.0; q * LANES]);
        let mut states = vec![0.0; n * LANES];
        let mut values = Mat::<f64>::zeros(n, points);
        for first in (0..points).step_by(LANES) {
            previous.fill(0.0);
            noise.fill(0.0);
            for (lane, point) in (first..points.min(first + LANES)).enumerate() {
                match point.checked_sub(1) {
                    None => {}
                    Some(unit) if unit < from => previous[unit * LANES + lane] = 1.0,
                    Some(unit) => noise[(unit - from) * LANES + lane] = 1.0,
                }
            }
            let before = (step.index > 0).then_some(previous.as_slice());
            self.tile_states(step, before, &noise, &mut states);
            for (lane, point) in (first..points.min(first + LANES)).enumerate() {
                (0..n).for_each(|i| values[(i, point)] = states[i * LANES + lane]);
            }
        }
        let at_zero: Vec<f64> = (0..n).map(|i| values[(i, 0)]).collect();
        let slopes =
            |first: usize, count: usize| Mat::from_fn(n, count, |i, j| values[(i, first + j)] - at_zero[i]);
        (at_zero.clone(), slopes(1, from), slopes(1 + from, q))
    }
}

impl LinearSystem for FormulaModel {
    fn initial_belief(&self, step: &Step<'_>) -> Belief {
        let (mean, _, loads) = self.linear_map(step);
        Belief { mean: Col::from_fn(mean.len(), |i| mean[i]), covariance: &loads * loads.transpose() }
    }

    fn transition_map(&self, step: &Step<'_>) -> LinearMap {
        let (offset, matrix, loads) = self.linear_map(step);
        LinearMap {
            matrix,
            offset: Col::from_fn(offset.len(), |i| offset[i]),
            covariance: &loads * loads.transpose(),
        }
    }

    fn measurement_map(&self, step: &Step<'_>) -> LinearMap {
        let (equations, end) = (self.equations(), step.end(self.input_dim()));
        let (n, m) = (self.state_dim(), self.measurement_dim());
        let at = |x: &[f64]| {
            let mut normals = Normals::default();
            equations.measurement(&end, x, &mut normals);
            normals
        };
        let mut x = vec![0.0; n];
        let Normals { means: offset, sds } = at(&x);
        let mut matrix = Mat::zeros(m, n);
        for j in 0..n {
            x[j] = 1.0;
            let column = at(&x).means;
            x[j] = 0.0;
            (0..m).for_each(|i| matrix[(i, j)] = column[i] - offset[i]);
        }
        LinearMap {
            matrix,
            offset: Col::from_fn(m, |i| offset[i]),
            covariance: Mat::from_fn(m, m, |i, j| if i == j { sds[i] * sds[i] } else { 0.0 }),
        }
    }
}
