//! A Gaussian by its mean and the Cholesky factor of its precision: what heads are built from.

use motes_models::LN_2PI;
use motes_models::equations::triangle::at;
use motes_models::equations::{Lanes, Scalar};

use super::covariance::Covariance;

/// Logarithms of scales stay within this, however far a network extrapolates.
const LARGEST_LOG_SCALE: f64 = 6.0;

/// `N(m, (AᵀA)⁻¹)`: `ε = A(u − m)` is standard normal, with `A` lower triangular.
///
/// `θ` has the mean `m` (`N`), the logarithms of the diagonal of `A` (`N`), and unless the covariance is diagonal the entries of `A` below the diagonal,
/// row after row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Normal {
    pub(super) n: usize,
    pub(super) covariance: Covariance,
    /// Where the entries of `A` below the diagonal begin in `θ`.
    pub(super) below: usize,
}

/// `a = θ / √(1 + (θ/c)²)`, and `∂a/∂θ`.
#[inline(always)]
pub(super) fn bounded(theta: Lanes) -> [Lanes; 2] {
    let scaled = theta / LARGEST_LOG_SCALE;
    let shrunk = Lanes::from(1.0) / (scaled * scaled + 1.0).sqrt();
    [theta * shrunk, shrunk * shrunk * shrunk]
}

impl Normal {
    /// That of `n` coordinates, with all of its `θ` side by side.
    pub(super) fn new(n: usize, covariance: Covariance) -> Self {
        Normal { n, covariance, below: 2 * n }
    }

    /// How many numbers of `θ` are the same for all particles.
    pub(super) fn shared(self) -> usize {
        if self.covariance == Covariance::Shared { self.n * (self.n - 1) / 2 } else { 0 }
    }

    /// How many numbers `θ` are.
    pub(super) fn outputs(self) -> usize {
        let below = if self.covariance != Covariance::Diagonal { self.n * (self.n - 1) / 2 } else { 0 };
        2 * self.n + below
    }

    /// Where the entry of `A` below the diagonal stands.
    #[inline(always)]
    fn below(self, i: usize, j: usize) -> usize {
        // Without the diagonal, row i begins where row i − 1 of a whole triangle does.
        self.below + at(i - 1, j)
    }

    /// `ε` into `noise`, and `log N(u | θ)`.
    #[inline(always)]
    pub(super) fn log_density(self, theta: &[Lanes], u: &[Lanes], noise: &mut [Lanes]) -> Lanes {
        let n = self.n;
        let mut sum = Lanes::from(-0.5 * LN_2PI * n as f64);
        for i in 0..n {
            let [log_scale, _] = bounded(theta[n + i]);
            let mut epsilon = (u[i] - theta[i]) * log_scale.exp();
            if self.covariance != Covariance::Diagonal {
                for j in 0..i {
                    epsilon = epsilon + theta[self.below(i, j)] * (u[j] - theta[j]);
                }
            }
            noise[i] = epsilon;
            sum = sum + log_scale - epsilon * epsilon * 0.5;
        }
        sum
    }

    /// `weight · ∂ log N / ∂θ` into `d_theta`, from the `ε` that [`Normal::log_density`] left.
    #[inline(always)]
    pub(super) fn gradient(
        self,
        theta: &[Lanes],
        u: &[Lanes],
        noise: &[Lanes],
        weight: Lanes,
        d_theta: &mut [Lanes],
    ) {
        let n = self.n;
        for i in 0..n {
            let [log_scale, slope] = bounded(theta[n + i]);
            let pull = noise[i] * log_scale.exp();
            // The diagonal of A is the exponential of its logarithm.
            d_theta[n + i] = weight * slope * (-(pull * (u[i] - theta[i])) + 1.0);
            d_theta[i] = pull;
        }
        if self.covariance != Covariance::Diagonal {
            for (i, noise) in noise.iter().enumerate().skip(1) {
                for j in 0..i {
                    let entry = self.below(i, j);
                    d_theta[entry] = -(weight * *noise * (u[j] - theta[j]));
                    d_theta[j] = d_theta[j] + theta[entry] * *noise;
                }
            }
        }
        for slope in &mut d_theta[..n] {
            *slope = *slope * weight;
        }
    }

    /// Replaces `g` (`N`) by `Aᵀ g`: a derivative along `ε` by one along `u`.
    #[inline(always)]
    pub(super) fn along_draw(self, theta: &[Lanes], g: &mut [Lanes]) {
        let n = self.n;
        for j in 0..n {
            let [log_scale, _] = bounded(theta[n + j]);
            let mut sum = g[j] * log_scale.exp();
            if self.covariance != Covariance::Diagonal {
                for i in j + 1..n {
                    sum = sum + theta[self.below(i, j)] * g[i];
                }
            }
            g[j] = sum;
        }
    }

    /// `Σ_i c_i ∂u_i/∂θ` with `ε` held fixed into `d_theta`; `pull` has `c`, and then `A⁻ᵀ c`, the same along `ε`.
    ///
    /// From `A(u − m) = ε`: `∂u = ∂m − A⁻¹ ∂A (u − m)`.
    #[inline(always)]
    pub(super) fn pull_back(self, theta: &[Lanes], u: &[Lanes], pull: &mut [Lanes], d_theta: &mut [Lanes]) {
        let n = self.n;
        d_theta[..n].copy_from_slice(pull);
        for i in (0..n).rev() {
            let [log_scale, slope] = bounded(theta[n + i]);
            let mut left = pull[i];
            if self.covariance != Covariance::Diagonal {
                for k in i + 1..n {
                    left = left - theta[self.below(k, i)] * pull[k];
                }
            }
            pull[i] = left * (-log_scale).exp();
            // The diagonal of A is the exponential of its logarithm.
            d_theta[n + i] = -(left * (u[i] - theta[i]) * slope);
        }
        if self.covariance != Covariance::Diagonal {
            for i in 1..n {
                for j in 0..i {
                    d_theta[self.below(i, j)] = -(pull[i] * (u[j] - theta[j]));
                }
            }
        }
    }

    /// Replaces `ε` by `u = m + A⁻¹ ε`.
    #[inline(always)]
    pub(super) fn draw(self, theta: &[Lanes], noise: &mut [Lanes]) {
        let n = self.n;
        for i in 0..n {
            let mut left = noise[i];
            if self.covariance != Covariance::Diagonal {
                for j in 0..i {
                    left = left - theta[self.below(i, j)] * noise[j];
                }
            }
            let [log_scale, _] = bounded(theta[n + i]);
            noise[i] = left * (-log_scale).exp();
        }
        for (noise, mean) in noise.iter_mut().zip(theta) {
            *noise = *noise + *mean;
        }
    }
}
