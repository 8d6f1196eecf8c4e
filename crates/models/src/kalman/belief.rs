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
