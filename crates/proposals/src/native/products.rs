//! Products of row-major matrices, and what else is done to whole matrices.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use crate::values::Real;

/// `out = a b`, or `out += a b`: `rows×inner` times `inner×columns`.
pub(super) fn times<T: Real>(out: &mut [T], accum: Accum, a: &[T], b: &[T], [rows, inner, columns]: [usize; 3]) {
    let a = MatRef::from_row_major_slice(a, rows, inner);
    let b = MatRef::from_row_major_slice(b, inner, columns);
    matmul(MatMut::from_row_major_slice_mut(out, rows, columns), accum, a, b, T::ONE, Par::Seq);
}

/// `out = a bᵀ`, or `out += a bᵀ`: `rows×inner` times the transpose of `columns×inner`.
pub(super) fn times_transposed<T: Real>(
    out: &mut [T],
    accum: Accum,
    a: &[T],
    b: &[T],
    [rows, inner, columns]: [usize; 3],
) {
    let a = MatRef::from_row_major_slice(a, rows, inner);
    let b = MatRef::from_row_major_slice(b, columns, inner).transpose();
    matmul(MatMut::from_row_major_slice_mut(out, rows, columns), accum, a, b, T::ONE, Par::Seq);
}

/// `out = aᵀ b`, or `out += aᵀ b`: the transpose of `inner×rows` times `inner×columns`.
pub(super) fn transposed_times<T: Real>(
    out: &mut [T],
    accum: Accum,
    a: &[T],
    b: &[T],
    [rows, inner, columns]: [usize; 3],
) {
    let a = MatRef::from_row_major_slice(a, inner, rows).transpose();
    let b = MatRef::from_row_major_slice(b, inner, columns);
    matmul(MatMut::from_row_major_slice_mut(out, rows, columns), accum, a, b, T::ONE, Par::Seq);
}

/// The transpose of `rows×columns`.
pub(super) fn transpose<T: Copy>(values: &[T], rows: usize, columns: usize, out: &mut [T]) {
    for (i, row) in values.chunks_exact(columns.max(1)).take(rows).enumerate() {
        for (j, value) in row.iter().enumerate() {
            out[j * rows + i] = *value;
        }
    }
}

/// Adds up rows into one.
pub(super) fn column_sums<T: Real>(out: &mut [T], accum: Accum, rows: &[T]) {
    vectorised(
        #[inline(always)]
        || {
            if accum == Accum::Replace {
                out.fill(T::ZERO);
            }
            for row in rows.chunks_exact(out.len()) {
                out.iter_mut().zip(row).for_each(|(sum, value)| *sum += *value);
            }
        },
    );
}

/// Runs loops with the widest vector instructions that this machine has.
#[inline(always)]
pub(super) fn vectorised<R>(loops: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(loops)
}
