//! Products of small matrices, row after row.

/// `A B` of `A` (`m×k`) and `B` (`k×n`), into `out` (`m×n`).
pub(super) fn product(a: &[f64], b: &[f64], [m, k, n]: [usize; 3], out: &mut [f64]) {
    out[..m * n].fill(0.0);
    for i in 0..m {
        for l in 0..k {
            let entry = a[i * k + l];
            if entry != 0.0 {
                add_row(entry, &b[l * n..][..n], &mut out[i * n..][..n]);
            }
        }
    }
}

/// `Aᵀ B` of `A` (`k×m`) and `B` (`k×n`), into `out` (`m×n`).
pub(super) fn product_of_transposed(a: &[f64], b: &[f64], [m, k, n]: [usize; 3], out: &mut [f64]) {
    out[..m * n].fill(0.0);
    add_product_of_transposed(a, b, [m, k, n], out);
}

/// Adds `Aᵀ B` of `A` (`k×m`) and `B` (`k×n`) to `out` (`m×n`).
pub(super) fn add_product_of_transposed(a: &[f64], b: &[f64], [m, k, n]: [usize; 3], out: &mut [f64]) {
    for l in 0..k {
        for i in 0..m {
            let entry = a[l * m + i];
            if entry != 0.0 {
                add_row(entry, &b[l * n..][..n], &mut out[i * n..][..n]);
            }
        }
    }
}

/// Adds `A x` of `A` (`m×k`) to `out` (`m`).
pub(super) fn add_times(a: &[f64], x: &[f64], out: &mut [f64]) {
    if x.is_empty() {
        return;
    }
    for (row, out) in a.chunks_exact(x.len()).zip(out) {
        *out += dot(row, x);
    }
}

/// Subtracts `A x` of `A` (`m×k`) from `out` (`m`).
pub(super) fn subtract_times(a: &[f64], x: &[f64], out: &mut [f64]) {
    if x.is_empty() {
        return;
    }
    for (row, out) in a.chunks_exact(x.len()).zip(out) {
        *out -= dot(row, x);
    }
}

/// Subtracts `Aᵀ x` of `A` (`k×m`) from `out` (`m`).
pub(super) fn subtract_transposed_times(a: &[f64], x: &[f64], out: &mut [f64]) {
    if out.is_empty() {
        return;
    }
    for (row, x) in a.chunks_exact(out.len()).zip(x) {
        add_row(-*x, row, out);
    }
}

/// Adds `Aᵀ x` of `A` (`k×m`) to `out` (`m`).
pub(super) fn add_transposed_times(a: &[f64], x: &[f64], out: &mut [f64]) {
    if out.is_empty() {
        return;
    }
    for (row, x) in a.chunks_exact(out.len()).zip(x) {
        add_row(*x, row, out);
    }
}

/// `aᵀ b`.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add_row(factor: f64, row: &[f64], out: &mut [f64]) {
    for (out, entry) in out.iter_mut().zip(row) {
        *out += factor * entry;
    }
}
