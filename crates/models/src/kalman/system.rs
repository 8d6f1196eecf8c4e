//! What the Kalman filter asks of a model.

use faer::{Col, Mat};

use super::belief::{Belief, symmetric};
use crate::{AdditiveGaussian, LinearGaussian, StateSpaceModel, Step};

/// A linear map with Gaussian noise: `z ↦ F z + b + N(0, Q)`. `Q` need not have full rank.
#[derive(Debug, Clone)]
pub struct LinearMap {
    /// `F`.
    pub matrix: Mat<f64>,
    /// `b`.
    pub offset: Col<f64>,
    /// `Q`.
    pub covariance: Mat<f64>,
}

impl LinearMap {
    /// The belief about what it maps a state to: `F m + b`, `F P Fᵀ + Q`.
    pub fn of_belief(&self, belief: &Belief) -> Belief {
        let f = &self.matrix;
        Belief {
            mean: f * &belief.mean + &self.offset,
            covariance: symmetric(f * &belief.covariance * f.transpose() + &self.covariance),
        }
    }
}

/// A model that is linear with Gaussian noise, in each step by matrices of its own.
pub trait LinearSystem: StateSpaceModel {
    /// `p(x_0)`.
    fn initial_belief(&self, step: &Step<'_>) -> Belief;

    /// How `x_t` is made of `x_{t−1}`.
    fn transition_map(&self, step: &Step<'_>) -> LinearMap;

    /// How `y_t` is made of `x_t`.
    fn measurement_map(&self, step: &Step<'_>) -> LinearMap;
}

impl LinearSystem for LinearGaussian {
    fn initial_belief(&self, _step: &Step<'_>) -> Belief {
        Belief {
            mean: Col::from_fn(self.state_dim(), |i| self.initial().mean()[i]),
            covariance: self.initial().covariance().to_owned(),
        }
    }

    fn transition_map(&self, _step: &Step<'_>) -> LinearMap {
        LinearMap {
            matrix: self.transition_matrix().to_owned(),
            offset: Col::zeros(self.state_dim()),
            covariance: self.transition_covariance().to_owned(),
        }
    }

    fn measurement_map(&self, _step: &Step<'_>) -> LinearMap {
        LinearMap {
            matrix: self.measurement_matrix().to_owned(),
            offset: Col::zeros(self.measurement_dim()),
            covariance: self.measurement_covariance().to_owned(),
        }
    }
}
