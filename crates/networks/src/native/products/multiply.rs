//! Products of row-major matrices in one precision, and what else is done to whole matrices.

use faer::Accum;
use motes_models::batch::by_widest_vectors;

use super::eigen_products::EigenProducts;
use super::matrix::{Columns, ColumnsMut, Product};
use super::outer_products::{OuterProducts, Take};
use crate::native::buffers::Buffers;
use crate::values::Real;

/// A precision with its products.
pub(crate) trait Multiply: Real {
    /// `a b`.
    fn times(product: Product<'_, Self>, buffers: &mut Buffers<Self>);

    /// `a bᵀ`.
    fn times_transposed(product: Product<'_, Self>, buffers: &mut Buffers<Self>);

    /// `aᵀ b`, where the rows of `a` lie one after another too.
    fn transposed_times(product: Product<'_, Self>, buffers: &mut Buffers<Self>);

    /// Products with a matrix for each eigenvalue.
    fn by_eigenvalue(products: EigenProducts<'_, Self>, buffers: &mut Buffers<Self>);

    /// Sums of outer products, in parts.
    fn outer(sums: &OuterProducts<'_, Self>, buffers: &mut Buffers<Self>, take: Take<'_, Self>);
}

/// `out = a b`, or `out += a b`: `rows×inner` times `inner×columns`.
pub(crate) fn times<T: Multiply>(
    out: &mut [T],
    accum: Accum,
    a: &[T],
    b: &[T],
    sizes: [usize; 3],
    buffers: &mut Buffers<T>,
) {
    T::times(whole(out, accum, a, b, sizes), buffers);
}

/// `out = a bᵀ`, or `out += a bᵀ`: `rows×inner` times the transpose of `columns×inner`.
pub(crate) fn times_transposed<T: Multiply>(
    out: &mut [T],
    accum: Accum,
    a: &[T],
    b: &[T],
    sizes: [usize; 3],
    buffers: &mut Buffers<T>,
) {
    T::times_transposed(whole(out, accum, a, b, sizes), buffers);
}

/// A product of whole matrices.
fn whole<'a, T>(out: &'a mut [T], accum: Accum, a: &'a [T], b: &'a [T], sizes: [usize; 3]) -> Product<'a, T> {
    let [_, inner, columns] = sizes;
    let (a, out) = (Columns { values: a, stride: inner }, ColumnsMut { values: out, stride: columns });
    Product { out, accum, a, b, sizes }
}

/// `out = aᵀ b`, or `out += aᵀ b`: the transpose of `inner×rows` times `inner×columns`.
pub(crate) fn transposed_times<T: Multiply>(
    out: &mut [T],
    accum: Accum,
    a: &[T],
    b: &[T],
    sizes: [usize; 3],
    buffers: &mut Buffers<T>,
) {
    let [rows, _, columns] = sizes;
    let (a, out) = (Columns { values: a, stride: rows }, ColumnsMut { values: out, stride: columns });
    T::transposed_times(Product { out, accum, a, b, sizes }, buffers);
}

/// The transpose of `rows×columns`.
pub(crate) fn transpose<T: Copy>(values: &[T], rows: usize, columns: usize, out: &mut [T]) {
    for (i, row) in values.chunks_exact(columns.max(1)).take(rows).enumerate() {
        for (j, value) in row.iter().enumerate() {
            out[j * rows + i] = *value;
        }
    }
}

/// Adds up rows into one.
pub(crate) fn column_sums<T: Real>(out: &mut [T], accum: Accum, rows: &[T]) {
    by_widest_vectors(
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
