//! The covariance that every Gaussian family shares: a kernel of a learned representation, mixed by a learned matrix.

mod adjoint;
mod cholesky;

pub use adjoint::cholesky_adjoint;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};
use motes_smc::ProposalError;

use crate::family::check_ridge;
use cholesky::Cholesky;

/// `Σ = C K(z) Cᵀ + δ I` with `K(z)ᵢⱼ = exp(−(zᵢ − zⱼ)²)` (the paper's equations "covMatrix" and "covKernel"; the ridge
/// `δ` makes it positive definite, which without it it need not be).
#[derive(Debug, Clone)]
pub struct KernelCovariance {
    mixing: Mat<f64>,
    ridge: f64,
}

impl KernelCovariance {
    /// Takes `C` (`N×N`, row-major) and `δ`.
    ///
    /// # Errors
    /// [`ProposalError::Mismatch`] if `C` is not square, [`ProposalError::Setting`] if the ridge is negative or not finite.
    pub fn new(width: usize, mixing: &[f64], ridge: f64) -> Result<Self, ProposalError> {
        if width == 0 || mixing.len() != width * width {
            let what = "the number of entries of the mixing matrix C";
            return Err(ProposalError::Mismatch { what, found: mixing.len(), expected: width * width });
        }
        check_ridge("the ridge of the covariance", ridge)?;
        Ok(KernelCovariance { mixing: Mat::from_fn(width, width, |i, j| mixing[i * width + j]), ridge })
    }

    fn width(&self) -> usize {
        self.mixing.nrows()
    }

    /// The Cholesky factor of each particle's `Σ`, given its `z` (rows of `R×N`): `R` matrices, `N×N` column-major.
    ///
    /// # Errors
    /// [`ProposalError::Numerical`] with the particle, if its `z` is not finite or its `Σ` not positive definite.
    pub fn factors(&self, representations: &[f64]) -> Result<Vec<f64>, ProposalError> {
        let n = self.width();
        let particles = representations.len() / n;
        let mut lowers = vec![0.0; particles * n * n];
        let (mut kernel, mut mixed) = (Mat::zeros(n, n), Mat::zeros(n, n));
        let mut cholesky = Cholesky::new(n);
        for (particle, z) in representations.chunks_exact(n).enumerate() {
            kernel_matrix(z, &mut kernel);
            let block = &mut lowers[particle * n * n..(particle + 1) * n * n];
            let mut covariance = MatMut::from_column_major_slice_mut(block, n, n);
            matmul(&mut mixed, Accum::Replace, &self.mixing, &kernel, 1.0, Par::Seq);
            matmul(&mut covariance, Accum::Replace, &mixed, self.mixing.transpose(), 1.0, Par::Seq);
            for i in 0..n {
                covariance[(i, i)] += self.ridge;
            }
            cholesky.factor_in_place(covariance).map_err(|reason| ProposalError::Numerical {
                computation: "the Cholesky factor of the proposal's covariance",
                particle,
                reason,
            })?;
        }
        Ok(lowers)
    }
}

/// `K(z)`, into `kernel`.
fn kernel_matrix(z: &[f64], kernel: &mut Mat<f64>) {
    for (j, zj) in z.iter().enumerate() {
        for (i, zi) in z.iter().enumerate() {
            kernel[(i, j)] = (-(zi - zj) * (zi - zj)).exp();
        }
    }
}
