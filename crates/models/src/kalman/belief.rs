//! A Gaussian belief about a state.

use faer::{Col, Mat, MatRef};

use crate::ModelError;

/// A Gaussian belief about a state.
#[derive(Debug, Clone)]
pub struct Belief {
    /// The mean, `N`.
    pub mean: Col<f64>,
    /// The covariance, `N×N`.
    pub covariance: Mat<f64>,
}

impl Belief {
    /// That of a mean (`N`) and a covariance (row-major `N×N`).
    ///
    /// # Panics
    /// If there are not `N×N` entries.
    pub fn of(mean: &[f64], covariance: &[f64]) -> Self {
        let n = mean.len();
        assert_eq!(covariance.len(), n * n, "a covariance has N×N entries");
        Belief {
            mean: Col::from_fn(n, |i| mean[i]),
            covariance: Mat::from_fn(n, n, |i, j| covariance[i * n + j]),
        }
    }

    /// The standard deviation of a coordinate.
    ///
    /// # Panics
    /// If there is no such coordinate.
    pub fn standard_deviation(&self, coordinate: usize) -> f64 {
        self.covariance[(coordinate, coordinate)].max(0.0).sqrt()
    }

    /// The quantile of a coordinate at a probability `p`, `m + s √2 erf⁻¹(2p − 1)`.
    ///
    /// # Panics
    /// If there is no such coordinate, or the probability is not between 0 and 1.
    pub fn quantile(&self, coordinate: usize, probability: f64) -> f64 {
        assert!((0.0..=1.0).contains(&probability), "a probability is between 0 and 1");
        let standard = std::f64::consts::SQRT_2 * statrs::function::erf::erf_inv(2.0 * probability - 1.0);
        // Without a spread there is no end far away either.
        let sd = self.standard_deviation(coordinate);
        self.mean[coordinate] + if sd > 0.0 { sd * standard } else { 0.0 }
    }

    /// Refuses a belief that left the range of numbers.
    pub(super) fn check(self, computation: &'static str, time: usize) -> Result<Self, ModelError> {
        let finite = self.mean.is_all_finite() && self.covariance.is_all_finite();
        match finite {
            true => Ok(self),
            false => {
                let reason = "its mean or its covariance is not finite".into();
                Err(ModelError::Numerical { computation, time, reason })
            }
        }
    }
}

/// The symmetric part, which removes what rounding made of a symmetric product.
pub(super) fn symmetric(matrix: Mat<f64>) -> Mat<f64> {
    let matrix: MatRef<'_, f64> = matrix.as_ref();
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]))
}
