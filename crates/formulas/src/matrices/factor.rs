//! Covariances that may be singular, as sums of independent noise.

use std::collections::BTreeSet;

use faer::{Mat, MatRef, Side};

/// A pivot so much smaller than its entry of the diagonal is what rounding left of 0, and how much may be left beside it.
const ROUNDED: f64 = 1e-9;
const ROUNDED_BESIDE: f64 = 1e-8;

/// Below such a share of a variance there is no noise of its own.
const LEAST_SHARE: f64 = 1e-9;

/// `L D Lᵀ` with ones on the diagonal of `L` and `D` diagonal without negative entries; where `D` is 0, `L` has nothing below its diagonal.
#[derive(Debug)]
pub(super) struct Factor {
    /// `L`.
    pub(super) unit: Mat<f64>,
    /// The diagonal of `D`.
    pub(super) pivots: Vec<f64>,
}

impl Factor {
    /// The factor of a symmetric matrix; none where the matrix is not positive semi-definite, up to a billionth of its diagonal.
    pub(super) fn of(matrix: MatRef<'_, f64>) -> Option<Factor> {
        let n = matrix.nrows();
        let (mut unit, mut pivots) = (Mat::<f64>::identity(n, n), Vec::with_capacity(n));
        let mut left = matrix.to_owned();
        for j in 0..n {
            let (pivot, size) = (left[(j, j)], matrix[(j, j)]);
            let beside = |i: usize| left[(i, j)].abs() <= ROUNDED_BESIDE * (size * matrix[(i, i)]).sqrt();
            if pivot <= ROUNDED * size && (j + 1..n).all(beside) {
                if pivot < -ROUNDED * size || size < 0.0 {
                    return None;
                }
                pivots.push(0.0);
                continue;
            }
            // NaN is no pivot either.
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            pivots.push(pivot);
            let column: Vec<f64> = (0..n).map(|i| if i > j { left[(i, j)] / pivot } else { 0.0 }).collect();
            for i in j + 1..n {
                unit[(i, j)] = column[i];
                for k in j + 1..n {
                    left[(i, k)] -= column[i] * column[k] * pivot;
                }
            }
        }
        Some(Factor { unit, pivots })
    }

    /// What each coordinate is of standard normal numbers, one for each pivot that is not 0: a matrix `B` with `B Bᵀ` the covariance.
    pub(super) fn loads(&self) -> Mat<f64> {
        let noisy: Vec<usize> = (0..self.pivots.len()).filter(|j| self.pivots[*j] > 0.0).collect();
        Mat::from_fn(self.pivots.len(), noisy.len(), |i, j| {
            self.unit[(i, noisy[j])] * self.pivots[noisy[j]].sqrt()
        })
    }

    /// How a coordinate depends on those before it: `x_i = Σ_j M_ij x_j + N(0, D_i)` for numbers of mean 0, strictly lower triangular.
    pub(super) fn regression(&self) -> Mat<f64> {
        let n = self.pivots.len();
        let mut inverse = Mat::<f64>::identity(n, n);
        self.unit.as_ref().solve_unit_lower_triangular_in_place(inverse.as_mut());
        Mat::from_fn(n, n, |i, j| if j < i { -inverse[(i, j)] } else { 0.0 })
    }

    /// Whether coordinates are independent.
    pub(super) fn is_diagonal(&self) -> bool {
        let n = self.pivots.len();
        (0..n).all(|i| (0..i).all(|j| self.unit[(i, j)] == 0.0))
    }
}

/// Splits a covariance into variances of independent noise, as large as they can be in the same share of all that are correlated, and the covariance that is left.
pub(super) fn split(covariance: MatRef<'_, f64>) -> (Vec<f64>, Mat<f64>) {
    let m = covariance.nrows();
    let (mut own, mut rest) = (vec![0.0; m], Mat::<f64>::zeros(m, m));
    let mut seen = BTreeSet::new();
    for first in 0..m {
        if seen.contains(&first) {
            continue;
        }
        // All that are correlated with it, directly or through others.
        let (mut block, mut at) = (vec![first], 0);
        seen.insert(first);
        while let Some(&row) = block.get(at) {
            at += 1;
            block.extend((0..m).filter(|other| covariance[(row, *other)] != 0.0 && seen.insert(*other)));
        }
        let share = share_of_own(covariance, &block);
        for &i in &block {
            own[i] = share * covariance[(i, i)];
            if share < 1.0 {
                for &j in &block {
                    rest[(i, j)] = covariance[(i, j)] - if i == j { own[i] } else { 0.0 };
                }
            }
        }
    }
    (own, rest)
}

/// The share of its variances that a block can have to itself: the smallest eigenvalue of its correlations.
fn share_of_own(covariance: MatRef<'_, f64>, block: &[usize]) -> f64 {
    if block.len() == 1 {
        return 1.0;
    }
    let sd = |i: usize| covariance[(block[i], block[i])].sqrt();
    let correlations =
        Mat::from_fn(block.len(), block.len(), |i, j| covariance[(block[i], block[j])] / (sd(i) * sd(j)));
    let least = correlations.self_adjoint_eigenvalues(Side::Lower).ok().and_then(|all| all.first().copied());
    least.filter(|least| *least > LEAST_SHARE).map_or(0.0, |least| least.min(1.0))
}
