//! The curvature of a likelihood as a swarm shows it, and walks that go along it.

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Side};

use crate::normal_fit::lower_factor;

/// The variance of the likelihood along a direction is taken to be between these, in variances of the prior.
const VARIANCES: [f64; 2] = [1e-4, 1.0];

/// How much of the variance is that of the last pass.
const NEW: f64 = 0.2;

/// `S` (`D×D`, row after row), the inverse of the curvature of a log-likelihood, where that walks with covariance `Σ` over a pass: between walking and selection a swarm has the covariance `C` with `C S⁻¹ C = Σ`.
pub(super) fn inverse_curvature(
    positions: &[f64],
    steps: &[f64],
    variance: f64,
    d: usize,
) -> Option<Vec<f64>> {
    let covariance = covariance(positions, d);
    let walk = square(steps, d) * faer::Scale(variance);
    let through = walk.llt(Side::Lower).ok()?.solve(&covariance);
    bounded((&covariance * through).as_ref())
}

/// What was known of `S` and what the last pass showed of it.
pub(super) fn mixed(before: &[f64], last: &[f64]) -> Vec<f64> {
    before.iter().zip(last).map(|(before, last)| (1.0 - NEW) * before + NEW * last).collect()
}

/// `L` (`D×D`, row after row) with `L Lᵀ = S`.
pub(super) fn factor(s: &[f64], d: usize) -> Option<Vec<f64>> {
    lower_factor(square(s, d).as_ref())
}

/// The mean of positions (`K×D`).
pub(super) fn mean(positions: &[f64], d: usize) -> Vec<f64> {
    let mut mean = vec![0.0; d];
    for position in positions.chunks_exact(d) {
        mean.iter_mut().zip(position).for_each(|(mean, v)| *mean += v);
    }
    let particles = (positions.len() / d) as f64;
    mean.iter().map(|sum| sum / particles).collect()
}

/// A matrix of rows.
fn square(rows: &[f64], d: usize) -> Mat<f64> {
    Mat::from_fn(d, d, |i, j| rows[i * d + j])
}

/// The covariance of positions (`K×D`).
fn covariance(positions: &[f64], d: usize) -> Mat<f64> {
    let particles = (positions.len() / d) as f64;
    let rows = MatRef::from_row_major_slice(positions, positions.len() / d, d);
    let mean = mean(positions, d);
    let centred = Mat::from_fn(rows.nrows(), d, |i, j| rows[(i, j)] - mean[j]);
    centred.transpose() * &centred * faer::Scale(1.0 / particles)
}

/// A covariance whose variances along all directions are within [`VARIANCES`], row after row.
fn bounded(covariance: MatRef<'_, f64>) -> Option<Vec<f64>> {
    let d = covariance.nrows();
    let eigen = covariance.self_adjoint_eigen(Side::Lower).ok()?;
    let [least, most] = VARIANCES;
    let values: Vec<f64> = eigen.S().column_vector().iter().map(|value| value.clamp(least, most)).collect();
    let vectors = eigen.U();
    let entry = |at: usize| {
        let (i, j) = (at / d, at % d);
        (0..d).map(|k| vectors[(i, k)] * values[k] * vectors[(j, k)]).sum::<f64>()
    };
    let rows: Vec<f64> = (0..d * d).map(entry).collect();
    rows.iter().all(|value| value.is_finite()).then_some(rows)
}
