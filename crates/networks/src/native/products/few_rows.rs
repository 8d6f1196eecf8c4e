//! Products of few rows with a large matrix, which is read once and never copied.
//!
//! A general matrix product first copies its factors into an order of its own. Where one factor is a batch of ten particles and the
//! other a matrix of weights, that copy costs more than the product.

use faer::Accum;
use pulp::{Arch, Simd, WithSimd};

use super::matrix::Product;
use super::vectors::{load_two, store_two};

/// Terms of the sums at a time: so few rows of a matrix of weights that the processor reads ahead in all of them. Weights come
/// from far away; those of one training step do not fit into a cache.
const TERMS: usize = 16;

/// `a b`.
pub(super) fn times(product: Product<'_, f32>) {
    Arch::new().dispatch(Times(product));
}

/// `a bᵀ`.
pub(super) fn times_transposed(product: Product<'_, f32>) {
    Arch::new().dispatch(TimesTransposed(product));
}

struct Times<'a>(Product<'a, f32>);

impl WithSimd for Times<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let [all_rows, inner, columns] = self.0.sizes;
        let mut first = 0;
        // A sum of no terms is still a result.
        while first < inner || (first == 0 && inner == 0) {
            let terms = TERMS.min(inner - first);
            let mut column = 0;
            while column < columns {
                let width = (2 * S::F32_LANES).min(columns - column);
                let mut row = 0;
                while row < all_rows {
                    let rows = (all_rows - row).min(10);
                    let corner = Corner { row, column, width, first, terms };
                    match rows {
                        10 => self.tile::<S, 10>(simd, corner),
                        9 => self.tile::<S, 9>(simd, corner),
                        8 => self.tile::<S, 8>(simd, corner),
                        7 => self.tile::<S, 7>(simd, corner),
                        6 => self.tile::<S, 6>(simd, corner),
                        5 => self.tile::<S, 5>(simd, corner),
                        4 => self.tile::<S, 4>(simd, corner),
                        3 => self.tile::<S, 3>(simd, corner),
                        2 => self.tile::<S, 2>(simd, corner),
                        _ => self.tile::<S, 1>(simd, corner),
                    }
                    row += rows;
                }
                column += width;
            }
            first += terms.max(1);
        }
    }
}

/// Where a tile lies, and which terms of its sums come next.
#[derive(Clone, Copy)]
struct Corner {
    row: usize,
    column: usize,
    width: usize,
    first: usize,
    terms: usize,
}

impl Times<'_> {
    /// `R` rows of two vectors of columns, in registers all along some terms of their sums.
    #[inline(always)]
    fn tile<S: Simd, const R: usize>(&mut self, simd: S, corner: Corner) {
        let Corner { row, column, width, first, terms } = corner;
        let Product { out, accum, a: rows, b: weights, sizes: [_, _, columns] } = &mut self.0;
        let mut sums = [[simd.splat_f32s(0.0); 2]; R];
        if *accum == Accum::Add || first > 0 {
            for (r, sums) in sums.iter_mut().enumerate() {
                let at = (row + r) * out.stride + column;
                *sums = load_two::<S>(simd, &out.values[at..at + width]);
            }
        }
        let mut a: [&[f32]; R] = [&[]; R];
        for (r, a) in a.iter_mut().enumerate() {
            let at = (row + r) * rows.stride + first;
            *a = &rows.values[at..at + terms];
        }
        for k in 0..terms {
            let at = (first + k) * *columns + column;
            let b = load_two::<S>(simd, &weights[at..at + width]);
            for (a, sums) in a.iter().zip(&mut sums) {
                let a = simd.splat_f32s(a[k]);
                sums[0] = simd.mul_add_e_f32s(a, b[0], sums[0]);
                sums[1] = simd.mul_add_e_f32s(a, b[1], sums[1]);
            }
        }
        for (r, sums) in sums.into_iter().enumerate() {
            let at = (row + r) * out.stride + column;
            store_two::<S>(simd, &mut out.values[at..at + width], sums);
        }
    }
}

struct TimesTransposed<'a>(Product<'a, f32>);

impl WithSimd for TimesTransposed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let [all_rows, _, columns] = self.0.sizes;
        let mut column = 0;
        while column < columns {
            let four = column + 4 <= columns;
            let mut row = 0;
            while row < all_rows {
                let rows = (all_rows - row).min(5);
                match (four, rows) {
                    (true, 5) => self.tile::<S, 5, 4>(simd, row, column),
                    (true, 4) => self.tile::<S, 4, 4>(simd, row, column),
                    (true, 3) => self.tile::<S, 3, 4>(simd, row, column),
                    (true, 2) => self.tile::<S, 2, 4>(simd, row, column),
                    (true, _) => self.tile::<S, 1, 4>(simd, row, column),
                    (false, 5) => self.tile::<S, 5, 1>(simd, row, column),
                    (false, 4) => self.tile::<S, 4, 1>(simd, row, column),
                    (false, 3) => self.tile::<S, 3, 1>(simd, row, column),
                    (false, 2) => self.tile::<S, 2, 1>(simd, row, column),
                    (false, _) => self.tile::<S, 1, 1>(simd, row, column),
                }
                row += rows;
            }
            column += if four { 4 } else { 1 };
        }
    }
}

impl TimesTransposed<'_> {
    /// `R×C` sums at a time: so many that neither factor is read often.
    #[inline(always)]
    fn tile<S: Simd, const R: usize, const C: usize>(&mut self, simd: S, row: usize, column: usize) {
        let Product { out, accum, a: rows, b: weights, sizes: [_, inner, _] } = &mut self.0;
        let whole = *inner / S::F32_LANES;
        let mut sums = [[simd.splat_f32s(0.0); C]; R];
        let (mut a, mut a_rest) = ([<&[S::f32s]>::default(); R], [<&[f32]>::default(); R]);
        let (mut b, mut b_rest) = ([<&[S::f32s]>::default(); C], [<&[f32]>::default(); C]);
        for r in 0..R {
            let at = (row + r) * rows.stride;
            (a[r], a_rest[r]) = S::as_simd_f32s(&rows.values[at..at + *inner]);
            a[r] = &a[r][..whole];
        }
        for c in 0..C {
            let at = (column + c) * *inner;
            (b[c], b_rest[c]) = S::as_simd_f32s(&weights[at..at + *inner]);
            b[c] = &b[c][..whole];
        }
        for k in 0..whole {
            for r in 0..R {
                for c in 0..C {
                    sums[r][c] = simd.mul_add_e_f32s(a[r][k], b[c][k], sums[r][c]);
                }
            }
        }
        for r in 0..R {
            for c in 0..C {
                let rest: f32 = a_rest[r].iter().zip(b_rest[c]).map(|(a, b)| a * b).sum();
                let sum = simd.reduce_sum_f32s(sums[r][c]) + rest;
                let place = &mut out.values[(row + r) * out.stride + column + c];
                *place = if *accum == Accum::Add { *place + sum } else { sum };
            }
        }
    }
}
