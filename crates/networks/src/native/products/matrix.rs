//! Matrices as they lie in memory, and products of them that are to be computed.

use faer::{Accum, MatMut};

/// A row-major matrix, or some of its columns: how far it is from one row to the next.
#[derive(Clone, Copy)]
pub(crate) struct Columns<'a, T> {
    pub(crate) values: &'a [T],
    pub(crate) stride: usize,
}

/// The same, to be written to.
pub(crate) struct ColumnsMut<'a, T> {
    pub(crate) values: &'a mut [T],
    pub(crate) stride: usize,
}

/// A factor of a product, or the transpose of what lies there.
#[derive(Clone, Copy)]
pub(super) struct Factor<'a> {
    pub(super) lies: Columns<'a, f32>,
    pub(super) transposed: bool,
}

/// A product that is to be computed; the rows of `b` lie one after another.
pub(crate) struct Product<'a, T> {
    pub(crate) out: ColumnsMut<'a, T>,
    /// Whether the result is added to `out`.
    pub(crate) accum: Accum,
    pub(crate) a: Columns<'a, T>,
    pub(crate) b: &'a [T],
    /// `[rows of the result, terms of each sum, columns of the result]`.
    pub(crate) sizes: [usize; 3],
}

/// `out = a b`, or `out += a b`, of single precision and not of few rows.
pub(super) struct Task<'a> {
    /// Each row is contiguous.
    pub(super) out: MatMut<'a, f32>,
    pub(super) accum: Accum,
    pub(super) a: Factor<'a>,
    pub(super) b: Factor<'a>,
    /// The terms of each sum.
    pub(super) inner: usize,
}

impl<'a> Task<'a> {
    /// `[rows, terms of each sum, columns of the result]`.
    pub(super) fn sizes(&self) -> [usize; 3] {
        [self.out.nrows(), self.inner, self.out.ncols()]
    }

    /// The first `columns` of the result, and the others.
    pub(super) fn split(self, columns: usize) -> [Self; 2] {
        let Task { out, accum, a, b, inner } = self;
        let Factor { lies: Columns { values, stride }, transposed } = b;
        let (left, right) = out.split_at_col_mut(columns);
        let first = if transposed { columns * stride } else { columns };
        let others = Factor { lies: Columns { values: &values[first..], stride }, transposed };
        [Task { out: left, accum, a, b, inner }, Task { out: right, accum, a, b: others, inner }]
    }
}

/// A row of what a task is to write.
#[inline(always)]
pub(super) fn row<'a>(out: &'a mut MatMut<'_, f32>, row: usize) -> &'a mut [f32] {
    let row = out.as_mut().row_mut(row).try_as_row_major_mut();
    row.expect("each row of a task is contiguous").as_slice_mut()
}
