//! Derivatives through a Cholesky factor and through the kernel covariance, in reverse mode.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::{KernelCovariance, kernel_matrix};

/// The derivative with respect to a symmetric `Σ = L Lᵀ`, given that with respect to `L` (lower triangle of `d_lower`).
///
/// `Σ̄ = ½ (S + Sᵀ)` with `S = L⁻ᵀ Φ(Lᵀ L̄) L⁻¹`, `Φ` the lower triangle with halved diagonal (Murray 2016). It is the
/// adjoint of the exact differential `dL = L Φ(L⁻¹ dΣ L⁻ᵀ)`: the scalar changes by `Σᵢⱼ Σ̄ᵢⱼ dΣᵢⱼ`.
pub fn cholesky_adjoint(lower: MatRef<'_, f64>, d_lower: MatRef<'_, f64>) -> Mat<f64> {
    let n = lower.nrows();
    let product = lower.transpose() * d_lower;
    let mut s = Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => 0.5 * product[(i, j)],
        std::cmp::Ordering::Greater => product[(i, j)],
    });
    let upper = lower.transpose();
    upper.solve_upper_triangular_in_place(s.as_mut());
    let mut s = s.transpose().to_owned();
    upper.solve_upper_triangular_in_place(s.as_mut());
    Mat::from_fn(n, n, |i, j| 0.5 * (s[(i, j)] + s[(j, i)]))
}

impl KernelCovariance {
    /// Pulls derivatives of a scalar back through `x = μ + L ε` and `log q = −Σᵢ log Lᵢᵢ + …` to `z` and `C`.
    ///
    /// Takes each particle's `z` (`R×N`), factor (`R` of `N×N` column-major), noise `ε` (`R×N`) and the derivatives with
    /// respect to its state (`R×N`) and its log density (`R`). Returns the derivatives with respect to `z` (`R×N`) and
    /// to `C` (`N×N` row-major); that with respect to `μ` is that with respect to the state.
    ///
    /// With `Σ̄` from [`cholesky_adjoint`]: `C̄ = Σ_k 2 Σ̄ C K`, `K̄ = Cᵀ Σ̄ C`, `z̄ᵢ = −4 Σⱼ K̄ᵢⱼ Kᵢⱼ (zᵢ − zⱼ)`.
    pub fn pull_back(
        &self,
        representations: &[f64],
        lowers: &[f64],
        noise: &[f64],
        d_states: &[f64],
        d_log_density: &[f64],
    ) -> (Vec<f64>, Vec<f64>) {
        let n = self.width();
        let c = self.mixing.as_ref();
        let mut d_representations = vec![0.0; representations.len()];
        let mut d_mixing = Mat::<f64>::zeros(n, n);
        let (mut kernel, mut left, mut d_kernel) = (Mat::zeros(n, n), Mat::zeros(n, n), Mat::zeros(n, n));
        for (row, z) in representations.chunks_exact(n).enumerate() {
            let at = row * n..(row + 1) * n;
            let lower = MatRef::from_column_major_slice(&lowers[row * n * n..(row + 1) * n * n], n, n);
            let (d_state, epsilon) = (&d_states[at.clone()], &noise[at.clone()]);
            let d_lower = Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Less => 0.0,
                std::cmp::Ordering::Equal => d_state[i] * epsilon[j] - d_log_density[row] / lower[(i, i)],
                std::cmp::Ordering::Greater => d_state[i] * epsilon[j],
            });
            let d_covariance = cholesky_adjoint(lower, d_lower.as_ref());
            kernel_matrix(z, &mut kernel);
            matmul(&mut left, Accum::Replace, &d_covariance, c, 1.0, Par::Seq);
            matmul(&mut d_mixing, Accum::Add, &left, &kernel, 2.0, Par::Seq);
            matmul(&mut d_kernel, Accum::Replace, c.transpose(), &left, 1.0, Par::Seq);
            for (i, d) in d_representations[at].iter_mut().enumerate() {
                *d = -4.0 * (0..n).map(|j| d_kernel[(i, j)] * kernel[(i, j)] * (z[i] - z[j])).sum::<f64>();
            }
        }
        let d_mixing = (0..n * n).map(|at| d_mixing[(at / n, at % n)]).collect();
        (d_representations, d_mixing)
    }
}
