//! A quadratic that is like noisy values near a point.

use faer::{Mat, Side};

/// The slope and the curvature at 0 of `a + bᵀu + ½ uᵀA u`, by weighted least squares.
#[derive(Debug, Clone)]
pub(super) struct Quadratic {
    pub(super) b: Vec<f64>,
    /// `A` (`D×D`), symmetric.
    pub(super) curvature: Mat<f64>,
    /// The covariance of `(a, b, A)`'s entries, in the order of [`features`].
    covariance: Mat<f64>,
}

/// `1, u_i, ½u_i², u_i u_j` for j above i.
fn features(u: &[f64]) -> Vec<f64> {
    let squares = u.iter().map(|value| 0.5 * value * value);
    let products = (0..u.len()).flat_map(|i| (i + 1..u.len()).map(move |j| u[i] * u[j]));
    std::iter::once(1.0).chain(u.iter().copied()).chain(squares).chain(products).collect()
}

/// The derivatives of [`features`] in coordinate `i`.
fn slopes(u: &[f64], i: usize) -> Vec<f64> {
    let d = u.len();
    let is_it = |at: usize| f64::from(at == i);
    let products = (0..d).flat_map(|j| (j + 1..d).map(move |k| is_it(j) * u[k] + is_it(k) * u[j]));
    let squares = (0..d).map(|at| is_it(at) * u[at]);
    std::iter::once(0.0).chain((0..d).map(is_it)).chain(squares).chain(products).collect()
}

/// The number of coefficients of a quadratic of `d` variables.
pub(super) fn coefficients(d: usize) -> usize {
    (d + 1) * (d + 2) / 2
}

impl Quadratic {
    /// The one that is closest to values at points, with their weights; none where there are too few of them.
    pub(super) fn fit(points: &[(Vec<f64>, f64, f64)]) -> Option<Self> {
        let d = points.first()?.0.len();
        let (count, n) = (coefficients(d), points.len());
        if n < count + 3 {
            return None;
        }
        let rows: Vec<Vec<f64>> = points.iter().map(|(u, ..)| features(u)).collect();
        let normal = Mat::from_fn(count, count, |i, j| {
            rows.iter().zip(points).map(|(row, (.., weight))| weight * row[i] * row[j]).sum::<f64>()
        });
        let right = Mat::from_fn(count, 1, |i, _| {
            rows.iter().zip(points).map(|(row, (_, value, weight))| weight * row[i] * value).sum::<f64>()
        });
        let factor = normal.llt(Side::Lower).ok()?;
        use faer::linalg::solvers::Solve;
        let found = factor.solve(&right);
        let rest = |(row, (_, value, _)): (&Vec<f64>, &(Vec<f64>, f64, f64))| {
            value - row.iter().enumerate().map(|(i, feature)| feature * found[(i, 0)]).sum::<f64>()
        };
        let squares: f64 = rows.iter().zip(points).map(|pair| pair.1.2 * rest(pair).powi(2)).sum();
        // What weights take away of points.
        let effective: f64 = points.iter().map(|(.., weight)| weight).sum();
        let variance = squares / (effective - count as f64).max(1.0);
        let inverse = factor.solve(&Mat::<f64>::identity(count, count));
        let b = (0..d).map(|i| found[(1 + i, 0)]).collect();
        let mut place = 1 + 2 * d;
        let mut curvature = Mat::zeros(d, d);
        for i in 0..d {
            curvature[(i, i)] = found[(1 + d + i, 0)];
            for j in i + 1..d {
                curvature[(i, j)] = found[(place, 0)];
                curvature[(j, i)] = found[(place, 0)];
                place += 1;
            }
        }
        let is_finite = (0..count).all(|i| found[(i, 0)].is_finite());
        is_finite.then(|| Quadratic { b, curvature, covariance: inverse * faer::Scale(variance) })
    }

    /// The standard error of its derivative in coordinate `i` at a point.
    pub(super) fn slope_error_at(&self, u: &[f64], i: usize) -> f64 {
        self.error_of(&slopes(u, i))
    }

    /// The standard error of a linear function of all coefficients, `√(wᵀ Cov w)`.
    fn error_of(&self, w: &[f64]) -> f64 {
        let of_row = |(i, w_i): (usize, &f64)| {
            w.iter().enumerate().map(|(j, w_j)| w_i * self.covariance[(i, j)] * w_j).sum::<f64>()
        };
        w.iter().enumerate().map(of_row).sum::<f64>().max(0.0).sqrt()
    }

    /// Where it is largest within `radius` of 0, and `−A`'s eigenvalues and eigenvectors, eigenvalues at least `least`.
    pub(super) fn ascend(&self, radius: f64, least: f64) -> Option<(Vec<f64>, Vec<f64>, Mat<f64>)> {
        let d = self.b.len();
        let eigen = self.curvature.self_adjoint_eigen(Side::Lower).ok()?;
        let (values, vectors) = (eigen.S(), eigen.U().to_owned());
        let values: Vec<f64> = (0..d).map(|i| (-values[i]).max(least)).collect();
        let along: Vec<f64> =
            (0..d).map(|k| (0..d).map(|i| vectors[(i, k)] * self.b[i]).sum::<f64>() / values[k]).collect();
        let length = along.iter().map(|value| value * value).sum::<f64>().sqrt();
        let share = if length > radius { radius / length } else { 1.0 };
        let step = (0..d).map(|i| (0..d).map(|k| vectors[(i, k)] * along[k] * share).sum()).collect();
        Some((step, values, vectors))
    }
}
