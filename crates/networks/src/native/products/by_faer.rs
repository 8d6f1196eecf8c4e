//! Products that faer computes.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::matrix::{Columns, ColumnsMut, Product};
use crate::values::Real;

/// `a b`.
pub(super) fn times<T: Real>(product: Product<'_, T>) {
    let Product { out, accum, a, b, sizes: [rows, inner, columns] } = product;
    multiply(out, accum, matrix(a, rows, inner), MatRef::from_row_major_slice(b, inner, columns));
}

/// `a bᵀ`.
pub(super) fn times_transposed<T: Real>(product: Product<'_, T>) {
    let Product { out, accum, a, b, sizes: [rows, inner, columns] } = product;
    multiply(out, accum, matrix(a, rows, inner), MatRef::from_row_major_slice(b, columns, inner).transpose());
}

/// `aᵀ b`.
pub(super) fn transposed_times<T: Real>(product: Product<'_, T>) {
    let Product { out, accum, a, b, sizes: [rows, inner, columns] } = product;
    multiply(out, accum, matrix(a, inner, rows).transpose(), MatRef::from_row_major_slice(b, inner, columns));
}

fn matrix<T>(of: Columns<'_, T>, rows: usize, columns: usize) -> MatRef<'_, T> {
    MatRef::from_row_major_slice_with_stride(of.values, rows, columns, of.stride)
}

/// Rows that lie apart.
pub(super) fn matrix_mut<T>(of: ColumnsMut<'_, T>, rows: usize, columns: usize) -> MatMut<'_, T> {
    // As the transpose of a column-major matrix: faer 0.24.4 takes the strides of the row-major one the wrong way round.
    MatMut::from_column_major_slice_with_stride_mut(of.values, columns, rows, of.stride).transpose_mut()
}

fn multiply<T: Real>(out: ColumnsMut<'_, T>, accum: Accum, a: MatRef<'_, T>, b: MatRef<'_, T>) {
    matmul(matrix_mut(out, a.nrows(), b.ncols()), accum, a, b, T::ONE, Par::Seq);
}
