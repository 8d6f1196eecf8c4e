//! Small triangular matrices of numbers, or of the particles of a tile: factored and solved, one particle in each lane.
//!
//! A lower triangle of `N(N+1)/2` entries stands row after row; [`at`] says where.

use super::scalar::Scalar;

/// Where entry `(i, j)` of a lower triangle stands, row after row.
#[inline(always)]
pub fn at(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

/// Replaces the lower triangle of `Λ` (`N(N+1)/2`) by its Cholesky factor `L`, `Λ = L Lᵀ`; NaN where it is not positive definite.
#[inline(always)]
pub fn factor<S: Scalar>(n: usize, lower: &mut [S]) {
    for j in 0..n {
        let mut pivot = lower[at(j, j)];
        for k in 0..j {
            pivot = pivot - lower[at(j, k)] * lower[at(j, k)];
        }
        let pivot = pivot.sqrt();
        lower[at(j, j)] = pivot;
        for i in j + 1..n {
            let mut sum = lower[at(i, j)];
            for k in 0..j {
                sum = sum - lower[at(i, k)] * lower[at(j, k)];
            }
            lower[at(i, j)] = sum / pivot;
        }
    }
}

/// Replaces the lower triangle of `Λ` (`N(N+1)/2`) by the `L` with `Λ = Lᵀ L`; NaN where it is not positive definite.
///
/// With `b` standard normal, `L⁻¹ b` has the precision `Λ`, and its entry `i` is made of the first `i` entries of `b`: each is drawn given those before it.
#[inline(always)]
pub fn factor_from_last<S: Scalar>(n: usize, lower: &mut [S]) {
    for j in (0..n).rev() {
        let mut pivot = lower[at(j, j)];
        for k in j + 1..n {
            pivot = pivot - lower[at(k, j)] * lower[at(k, j)];
        }
        let pivot = pivot.sqrt();
        lower[at(j, j)] = pivot;
        for i in 0..j {
            let mut sum = lower[at(j, i)];
            for k in j + 1..n {
                sum = sum - lower[at(k, j)] * lower[at(k, i)];
            }
            lower[at(j, i)] = sum / pivot;
        }
    }
}

/// Replaces `b` by `L⁻¹ b`.
#[inline(always)]
pub fn solve_lower<S: Scalar>(n: usize, lower: &[S], b: &mut [S]) {
    for i in 0..n {
        let mut sum = b[i];
        for k in 0..i {
            sum = sum - lower[at(i, k)] * b[k];
        }
        b[i] = sum / lower[at(i, i)];
    }
}

/// Replaces `b` by `L⁻ᵀ b`.
#[inline(always)]
pub fn solve_upper<S: Scalar>(n: usize, lower: &[S], b: &mut [S]) {
    for i in (0..n).rev() {
        let mut sum = b[i];
        for k in i + 1..n {
            sum = sum - lower[at(k, i)] * b[k];
        }
        b[i] = sum / lower[at(i, i)];
    }
}

/// Replaces `b` by `Lᵀ b`.
#[inline(always)]
pub fn times_upper<S: Scalar>(n: usize, lower: &[S], b: &mut [S]) {
    for i in 0..n {
        let mut sum = lower[at(i, i)] * b[i];
        for k in i + 1..n {
            sum = sum + lower[at(k, i)] * b[k];
        }
        b[i] = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equations::lanes::Lanes;

    #[test]
    fn a_factor_from_the_last_row_gives_its_matrix_back() {
        let n = 4;
        let entry = |i: usize, j: usize| match i == j {
            true => 3.0 + i as f64,
            false => 0.4 * (i as f64 - 0.3 * j as f64).sin(),
        };
        let pairs = || (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let mut lower: Vec<Lanes> = pairs().map(|(i, j)| Lanes::from(entry(i, j))).collect();
        factor_from_last(n, &mut lower);
        for (i, j) in pairs() {
            let found: f64 = (i..n).map(|k| lower[at(k, i)].0[3] * lower[at(k, j)].0[3]).sum();
            assert!((found - entry(i, j)).abs() < 1e-12, "{i}, {j}");
        }
    }

    #[test]
    fn a_factor_gives_its_matrix_back() {
        let n = 4;
        // Diagonally dominant, another one in each lane.
        let entry = |i: usize, j: usize, lane: usize| match i == j {
            true => 3.0 + i as f64 + 0.1 * lane as f64,
            false => 0.4 * (i as f64 - 0.3 * j as f64 + 0.05 * lane as f64).sin(),
        };
        let lanes = |i: usize, j: usize| Lanes(std::array::from_fn(|lane| entry(i, j, lane)));
        let mut lower: Vec<Lanes> =
            (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|(i, j)| lanes(i, j)).collect();
        factor(n, &mut lower);
        let x: Vec<Lanes> =
            (0..n).map(|i| Lanes(std::array::from_fn(|lane| (i * lane) as f64 - 2.0))).collect();
        let mut product = x.clone();
        times_upper(n, &lower, &mut product);
        let half = product.clone();
        solve_upper(n, &lower, &mut product);
        // L Lᵀ x, row by row, against the matrix itself.
        for lane in [0, 7, 31] {
            for i in 0..n {
                assert!((product[i].0[lane] - x[i].0[lane]).abs() < 1e-12);
                let found: f64 = (0..=i).map(|k| lower[at(i, k)].0[lane] * half[k].0[lane]).sum();
                let expected: f64 = (0..n).map(|j| entry(i.max(j), i.min(j), lane) * x[j].0[lane]).sum();
                assert!((found - expected).abs() < 1e-12, "row {i}, lane {lane}");
            }
        }
        let mut solved = half.clone();
        solve_lower(n, &lower, &mut solved);
        let norm = |v: &[Lanes]| v.iter().map(|v| v.0[5] * v.0[5]).sum::<f64>();
        assert!(norm(&solved) > 0.0 && norm(&solved) < norm(&half));
        let mut back = vec![Lanes::from(0.0); n];
        for i in 0..n {
            for k in 0..=i {
                back[i] = back[i] + lower[at(i, k)] * solved[k];
            }
            assert!((back[i].0[5] - half[i].0[5]).abs() < 1e-12);
        }
    }
}
