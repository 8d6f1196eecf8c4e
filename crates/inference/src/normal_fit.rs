//! The normal distribution that is like some positions, for moves of chains.

use faer::{Mat, MatRef, Side};
use motes_models::{Stream, fill_standard_normal};
use serde::{Deserialize, Serialize};

/// The degrees of freedom of the heavy-tailed distribution that independent moves are drawn from.
const DEGREES: usize = 5;

/// A mean and a covariance `L Lᵀ` of `D` coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct NormalFit {
    mean: Vec<f64>,
    /// `L` (`D×D`), row after row; 0 above the diagonal.
    lower: Vec<f64>,
}

impl NormalFit {
    /// The standard normal distribution.
    pub(crate) fn standard(d: usize) -> Self {
        let lower = (0..d * d).map(|at| f64::from(at / d == at % d)).collect();
        NormalFit { mean: vec![0.0; d], lower }
    }

    /// That of positions, at least two. Correlations are shrunk by as much as few positions tell of them; none where a coordinate does not vary.
    pub(crate) fn of(positions: &[&[f64]]) -> Option<Self> {
        let n = positions.len() as f64;
        let d = positions.first()?.len();
        let mean: Vec<f64> = (0..d).map(|i| positions.iter().map(|v| v[i]).sum::<f64>() / n).collect();
        let shrinkage = d as f64 / (n + d as f64);
        let covariance = Mat::from_fn(d, d, |i, j| {
            let products = positions.iter().map(|v| (v[i] - mean[i]) * (v[j] - mean[j]));
            let covariance = products.sum::<f64>() / (n - 1.0);
            if i == j { covariance } else { covariance * (1.0 - shrinkage) }
        });
        Some(NormalFit { mean, lower: lower_factor(covariance.as_ref())? })
    }

    fn dimension(&self) -> usize {
        self.mean.len()
    }

    /// Its mean (`D`).
    pub(crate) fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// `L` (`D×D`), row after row.
    pub(crate) fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// `centre + scale · L ε`.
    fn shifted(&self, centre: &[f64], scale: f64, noise: &[f64]) -> Vec<f64> {
        let d = self.dimension();
        let row = |i: usize| (0..=i).map(|j| self.lower[i * d + j] * noise[j]).sum::<f64>();
        (0..d).map(|i| centre[i] + scale * row(i)).collect()
    }

    /// A step of a random walk from `v`.
    pub(crate) fn walk(&self, v: &[f64], scale: f64, stream: &mut Stream) -> Vec<f64> {
        let mut noise = vec![0.0; self.dimension()];
        fill_standard_normal(stream, &mut noise);
        self.shifted(v, scale, &noise)
    }

    /// A draw of the multivariate t distribution with this location and `L Lᵀ` as its scale.
    pub(crate) fn sample_student(&self, stream: &mut Stream) -> Vec<f64> {
        let mut noise = vec![0.0; self.dimension() + DEGREES];
        fill_standard_normal(stream, &mut noise);
        let (noise, rest) = noise.split_at(self.dimension());
        let chi_squared: f64 = rest.iter().map(|value| value * value).sum();
        self.shifted(&self.mean, (DEGREES as f64 / chi_squared).sqrt(), noise)
    }

    /// The log density of that distribution.
    pub(crate) fn log_density_student(&self, v: &[f64]) -> f64 {
        let (d, degrees) = (self.dimension(), DEGREES as f64);
        let mut standard = vec![0.0; d];
        for i in 0..d {
            let known: f64 = (0..i).map(|j| self.lower[i * d + j] * standard[j]).sum();
            standard[i] = (v[i] - self.mean[i] - known) / self.lower[i * d + i];
        }
        let squared: f64 = standard.iter().map(|value| value * value).sum();
        let log_determinant: f64 = (0..d).map(|i| self.lower[i * d + i].ln()).sum();
        let total = degrees + d as f64;
        ln_gamma(total / 2.0)
            - ln_gamma(degrees / 2.0)
            - 0.5 * d as f64 * (degrees * std::f64::consts::PI).ln()
            - log_determinant
            - 0.5 * total * (squared / degrees).ln_1p()
    }
}

fn ln_gamma(x: f64) -> f64 {
    motes_models::equations::Scalar::ln_gamma(x)
}

/// `L` (`D×D`, row after row) with `L Lᵀ` a covariance; none where that is not positive.
pub(crate) fn lower_factor(covariance: MatRef<'_, f64>) -> Option<Vec<f64>> {
    let d = covariance.nrows();
    let factor = covariance.llt(Side::Lower).ok()?;
    let lower = factor.L();
    let entry = |at: usize| if at % d <= at / d { lower[(at / d, at % d)] } else { 0.0 };
    let lower: Vec<f64> = (0..d * d).map(entry).collect();
    lower.iter().all(|value| value.is_finite()).then_some(lower)
}

/// The log density of `N(0, I)` but for its constant.
pub(crate) fn log_prior(v: &[f64]) -> f64 {
    -0.5 * v.iter().map(|value| value * value).sum::<f64>()
}
