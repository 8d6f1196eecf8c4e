//! Derivatives through the kernel covariance and its Cholesky factor, in reverse mode.

use super::{KernelCovariance, kernel_matrices};
use crate::lanes::{LANES, Lane, Square};
use motes_models::batch::by_widest_vectors;

impl KernelCovariance {
    /// Pulls derivatives of a scalar back through `x = μ + L ε` and `log q = −Σᵢ log Lᵢᵢ + …` to `z` and `C`.
    ///
    /// Takes each particle's `z` (`R×N`), factor (`R` of `N×N` column-major), noise `ε` (`R×N`) and the derivatives with
    /// respect to its state (`R×N`) and its log density (`R`; none if they are all zero). Returns the derivatives with respect to `z` (`R×N`) and
    /// to `C` (`N×N` row-major); that with respect to `μ` is that with respect to the state.
    ///
    /// `L̄ = tril(x̄ εᵀ) − q̄ diag(L)⁻¹`. With `Φ` the lower triangle with halved diagonal and `S = L⁻ᵀ Φ(Lᵀ L̄) L⁻¹`,
    /// `Σ̄ = ½ (S + Sᵀ)`: the adjoint of the exact differential `dL = L Φ(L⁻¹ dΣ L⁻ᵀ)` (Murray 2016). Then
    /// `C̄ = Σ_k 2 Σ̄ C K`, `K̄ = Cᵀ Σ̄ C`, `z̄ᵢ = −4 Σⱼ K̄ᵢⱼ Kᵢⱼ (zᵢ − zⱼ)`.
    pub fn pull_back(
        &self,
        representations: &[f64],
        lowers: &[f64],
        noise: &[f64],
        d_states: &[f64],
        d_log_density: Option<&[f64]>,
    ) -> (Vec<f64>, Vec<f64>) {
        let n = self.width;
        if let Some(d_log_density) = d_log_density {
            assert_eq!(d_log_density.len() * n, d_states.len(), "one log density for each particle");
        }
        let mut d_representations = vec![0.0; representations.len()];
        let mut work = Adjoint {
            kernel: Square::zeros(n),
            lower: Square::zeros(n),
            d_lower: Square::zeros(n),
            s: Square::zeros(n),
            d_covariance: Square::zeros(n),
            left: Square::zeros(n),
            d_mixing: Square::zeros(n),
        };
        let rows = LANES * n;
        let blocks = representations.chunks(rows).zip(lowers.chunks(rows * n)).zip(noise.chunks(rows));
        let blocks = blocks.zip(d_states.chunks(rows)).zip(d_representations.chunks_mut(rows));
        let mut d_log_density = d_log_density.map(|d_log_density| d_log_density.chunks(LANES));
        for ((((z, lowers), noise), d_states), d_z) in blocks {
            let d_log = d_log_density.as_mut().and_then(Iterator::next);
            by_widest_vectors(
                #[inline(always)]
                || {
                    work.load(n, lowers, noise, d_states, d_log);
                    work.covariance(n);
                    kernel_matrices(n, z, &mut work.kernel);
                    work.beyond(n, &self.mixing, z, d_z);
                },
            );
        }
        (d_representations, work.d_mixing.sums())
    }
}

/// Space for one block of particles.
struct Adjoint {
    kernel: Square,
    lower: Square,
    d_lower: Square,
    s: Square,
    d_covariance: Square,
    left: Square,
    /// The sum over all blocks.
    d_mixing: Square,
}

impl Adjoint {
    /// `L` and `L̄`; in lanes without a particle the latter is 0, so that nothing comes of them.
    #[inline(always)]
    fn load(
        &mut self,
        n: usize,
        lowers: &[f64],
        noise: &[f64],
        d_states: &[f64],
        d_log_density: Option<&[f64]>,
    ) {
        let particles = d_states.len() / n;
        for i in 0..n {
            let (d_state, epsilon_at) = (Lane::gather(d_states, n, i), |j| Lane::gather(noise, n, j));
            for j in 0..=i {
                let lower = Lane::gather(lowers, n * n, i + n * j);
                let mut d = Lane::default();
                d.add_product(&d_state, &epsilon_at(j));
                if i == j
                    && let Some(d_log_density) = d_log_density
                {
                    for ((d, d_log), lower) in d.0.iter_mut().zip(d_log_density).zip(&lower.0) {
                        *d -= d_log / lower;
                    }
                }
                d.0[particles..].fill(0.0);
                *self.lower.at_mut(i, j) = lower;
                *self.d_lower.at_mut(i, j) = d;
            }
        }
    }

    /// `Σ̄` from `L` and `L̄`.
    #[inline(always)]
    fn covariance(&mut self, n: usize) {
        // Φ(Lᵀ L̄)
        for i in 0..n {
            for j in 0..n {
                let mut sum = Lane::default();
                if i >= j {
                    for k in i..n {
                        sum.add_product(self.lower.at(k, i), self.d_lower.at(k, j));
                    }
                }
                if i == j {
                    sum.0.iter_mut().for_each(|value| *value *= 0.5);
                }
                *self.s.at_mut(i, j) = sum;
            }
        }
        // Lᵀ X = Φ, from the last row up.
        for i in (0..n).rev() {
            for j in 0..n {
                let mut sum = *self.s.at(i, j);
                for k in i + 1..n {
                    sum.subtract_product(self.lower.at(k, i), self.s.at(k, j));
                }
                sum.divide(self.lower.at(i, i));
                *self.s.at_mut(i, j) = sum;
            }
        }
        // S L = X, from the last column back.
        for j in (0..n).rev() {
            for i in 0..n {
                let mut sum = *self.s.at(i, j);
                for k in j + 1..n {
                    sum.subtract_product(self.s.at(i, k), self.lower.at(k, j));
                }
                sum.divide(self.lower.at(j, j));
                *self.s.at_mut(i, j) = sum;
            }
        }
        for i in 0..n {
            for j in 0..=i {
                let mut mean = Lane::default();
                mean.add_scaled(0.5, self.s.at(i, j));
                mean.add_scaled(0.5, self.s.at(j, i));
                *self.d_covariance.at_mut(i, j) = mean;
                *self.d_covariance.at_mut(j, i) = mean;
            }
        }
    }

    /// From `Σ̄` to `C̄`, which is added up, and `z̄`.
    #[inline(always)]
    fn beyond(&mut self, n: usize, mixing: &[f64], z: &[f64], d_z: &mut [f64]) {
        // Σ̄ C
        for i in 0..n {
            for j in 0..n {
                let mut sum = Lane::default();
                for k in 0..n {
                    sum.add_scaled(mixing[k * n + j], self.d_covariance.at(i, k));
                }
                *self.left.at_mut(i, j) = sum;
            }
        }
        for i in 0..n {
            for j in 0..n {
                let mut sum = Lane::default();
                for k in 0..n {
                    sum.add_product(self.left.at(i, k), self.kernel.at(k, j));
                }
                self.d_mixing.at_mut(i, j).add_scaled(2.0, &sum);
            }
        }
        for i in 0..n {
            let mine = Lane::gather(z, n, i);
            let mut d = Lane::default();
            for j in 0..n {
                // K̄ᵢⱼ; on the diagonal zᵢ − zⱼ is 0.
                let mut d_kernel = Lane::default();
                for k in 0..n {
                    d_kernel.add_scaled(mixing[k * n + i], self.left.at(k, j));
                }
                let mut pull = *self.kernel.at(i, j);
                let other = Lane::gather(z, n, j);
                for ((pull, mine), other) in pull.0.iter_mut().zip(&mine.0).zip(&other.0) {
                    *pull *= mine - other;
                }
                d.add_product(&d_kernel, &pull);
            }
            for (row, d) in d_z.chunks_exact_mut(n).zip(&d.0) {
                row[i] = -4.0 * d;
            }
        }
    }
}
