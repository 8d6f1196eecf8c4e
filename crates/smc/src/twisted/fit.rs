//! A quadratic by least squares.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use motes_models::equations::triangle::at;

use super::quadratic::Quadratic;

/// The share that is added to each coordinate's variance, so that a covariance can be factored in floating point.
const JITTER: f64 = 1e-12;

/// What is added to the diagonal of the normal equations, whose entries are moments of coordinates of mean 0 and variance 1: enough for two that are alike.
const RIDGE: f64 = 1e-6;

/// The number of coefficients of a quadratic of `n` coordinates.
pub(super) fn coefficients(n: usize) -> usize {
    1 + n + n * (n + 1) / 2
}

/// A particle's share, its state, and the value there.
struct Point<'a> {
    share: f64,
    state: &'a [f64],
    target: f64,
}

/// The quadratic that is nearest to `targets` (`K`) at `states` (`K×N`), particle by particle as heavy as its weight. Directions in which it would curve upwards are straight in it.
///
/// Particles without weight, and those at which the target is not finite, have no say. `None` where they are too much alike.
pub(super) fn fit(n: usize, states: &[f64], log_weights: &[f64], targets: &[f64]) -> Option<Quadratic> {
    let mut points: Vec<Point<'_>> = states
        .chunks_exact(n)
        .zip(log_weights)
        .zip(targets)
        .map(|((state, log_weight), target)| Point { share: log_weight.exp(), state, target: *target })
        .filter(|point| point.share > 0.0 && point.target.is_finite())
        .collect();
    let total: f64 = points.iter().map(|point| point.share).sum();
    points.iter_mut().for_each(|point| point.share /= total);
    let mean_of =
        |of: &dyn Fn(&Point<'_>) -> f64| -> f64 { points.iter().map(|point| point.share * of(point)).sum() };
    let centre: Vec<f64> = (0..n).map(|i| mean_of(&|point| point.state[i])).collect();
    let level = mean_of(&|point| point.target);
    let mut covariance = Mat::from_fn(n, n, |i, j| {
        mean_of(&|point| (point.state[i] - centre[i]) * (point.state[j] - centre[j]))
    });
    for i in 0..n {
        covariance[(i, i)] *= 1.0 + JITTER;
    }
    let lower = covariance.llt(Side::Lower).ok()?.L().to_owned();
    // z = S⁻¹ (x − c), in which coordinates have variance 1.
    let mut z = Mat::from_fn(n, points.len(), |i, k| points[k].state[i] - centre[i]);
    lower.as_ref().solve_lower_triangular_in_place(z.as_mut());
    // Row and column of each entry of a lower triangle, row after row.
    let pairs: Vec<(usize, usize)> = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
    let features = Mat::from_fn(points.len(), coefficients(n), |k, feature| {
        let root = points[k].share.sqrt();
        let z = z.col(k);
        match feature {
            0 => root,
            linear if linear <= n => root * z[linear - 1],
            product => {
                let (i, j) = pairs[product - 1 - n];
                root * z[i] * z[j]
            }
        }
    });
    let rests = Mat::from_fn(points.len(), 1, |k, _| points[k].share.sqrt() * (points[k].target - level));
    let mut normal = features.transpose() * &features;
    for i in 0..normal.nrows() {
        normal[(i, i)] += RIDGE;
    }
    let found = normal.llt(Side::Lower).ok()?.solve(features.transpose() * rests);
    let curvature = Mat::from_fn(n, n, |i, j| {
        let coefficient = found[(1 + n + at(i.max(j), i.min(j)), 0)];
        if i == j { -2.0 * coefficient } else { -coefficient }
    });
    let eigen = curvature.self_adjoint_eigen(Side::Lower).ok()?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    // A = Sᵀ⁻¹ U D Uᵀ S⁻¹, and b = Sᵀ⁻¹ b_z.
    let mut root = Mat::from_fn(n, n, |i, j| vectors[(i, j)] * values[j].max(0.0).sqrt());
    let mut slope = Mat::from_fn(n, 1, |i, _| found[(1 + i, 0)]);
    lower.transpose().solve_upper_triangular_in_place(root.as_mut());
    lower.transpose().solve_upper_triangular_in_place(slope.as_mut());
    let curvature = &root * root.transpose();
    let quadratic = Quadratic {
        centre,
        curvature: pairs.iter().map(|place| curvature[*place]).collect(),
        slope: (0..n).map(|i| slope[(i, 0)]).collect(),
    };
    let is_finite = quadratic.curvature.iter().chain(&quadratic.slope).all(|entry| entry.is_finite());
    is_finite.then_some(quadratic)
}
