//! Products of some dozens of rows with the transpose of a large matrix, which is read along its rows.
//!
//! The rows of the small factor go into the lanes of vectors: then nothing has to be added up across lanes, and the large factor is
//! needed number by number, in the order in which it lies.

use faer::{Accum, MatMut};
use pulp::{Arch, Simd, WithSimd};

use super::matrix::{Columns, Task, row};
use crate::native::buffers::Buffers;

/// The longest vector.
const LANES: usize = 16;

/// How many columns are turned at a time: what stays in the nearest cache.
const TURNED: usize = 64;

/// `a b`, where `b` is the transpose of what lies there, and `a` lies row by row.
pub(super) fn times_transposed(task: Task<'_>, buffers: &mut Buffers<f32>) {
    debug_assert!(!task.a.transposed && task.b.transposed);
    let [rows, inner, columns] = task.sizes();
    let padded = rows.next_multiple_of(LANES);
    let (mut turned, mut sums) = (buffers.take(padded * inner), buffers.take(padded * columns));
    Arch::new().dispatch(TimesTransposed { task, turned: &mut turned, sums: &mut sums });
    buffers.put(turned);
    buffers.put(sums);
}

struct TimesTransposed<'a> {
    task: Task<'a>,
    /// The columns of `a`, one after another.
    turned: &'a mut [f32],
    /// The columns of `a b`, one after another.
    sums: &'a mut [f32],
}

impl WithSimd for TimesTransposed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let [rows, inner, columns] = self.task.sizes();
        let vectors = rows.div_ceil(S::F32_LANES);
        // As many rows of `b` at a time as leave registers for the sums of each with every vector.
        let most = if S::REGISTER_COUNT >= 32 { 4 } else { 2 };
        let parts = vectors.div_ceil(most);
        for part in 0..parts {
            let (first, last) = (part * vectors / parts, (part + 1) * vectors / parts);
            let start = first * S::F32_LANES;
            let rows = rows.min(last * S::F32_LANES) - start;
            let (count, lanes) = (last - first, (last - first) * S::F32_LANES);
            turn(self.task.a.lies, start, rows, inner, &mut self.turned[..inner * lanes]);
            match count {
                1 => self.all::<S, 12, 1>(simd),
                2 if S::REGISTER_COUNT >= 32 => self.all::<S, 12, 2>(simd),
                2 => self.all::<S, 6, 2>(simd),
                3 => self.all::<S, 8, 3>(simd),
                _ => self.all::<S, 6, 4>(simd),
            }
            let Task { out, accum, .. } = &mut self.task;
            let some = out.as_mut().subrows_mut(start, rows);
            turn_back(some, *accum, lanes, &self.sums[..columns * lanes]);
        }
    }
}

impl TimesTransposed<'_> {
    /// All sums of `V` vectors of rows, `B` rows of `b` at a time.
    #[inline(always)]
    fn all<S: Simd, const B: usize, const V: usize>(&mut self, simd: S) {
        let [_, inner, columns] = self.task.sizes();
        let mut column = 0;
        while column < columns {
            if column + B <= columns {
                self.tile::<S, B, V>(simd, column, inner);
                column += B;
            } else {
                self.tile::<S, 1, V>(simd, column, inner);
                column += 1;
            }
        }
    }

    #[inline(always)]
    fn tile<S: Simd, const B: usize, const V: usize>(&mut self, simd: S, column: usize, inner: usize) {
        let mut sums = [[simd.splat_f32s(0.0); V]; B];
        let mut b: [&[f32]; B] = [&[]; B];
        for (c, b) in b.iter_mut().enumerate() {
            let Columns { values, stride } = self.task.b.lies;
            *b = &values[(column + c) * stride..][..inner];
        }
        let (a, _) = S::as_simd_f32s(self.turned);
        let (a, _) = a.as_chunks::<V>();
        for (k, a) in a[..inner].iter().enumerate() {
            for (b, sums) in b.iter().zip(&mut sums) {
                let b = simd.splat_f32s(b[k]);
                for (a, sum) in a.iter().zip(sums) {
                    *sum = simd.mul_add_e_f32s(b, *a, *sum);
                }
            }
        }
        let (places, _) = S::as_mut_simd_f32s(self.sums);
        let (places, _) = places.as_chunks_mut::<V>();
        places[column..column + B].copy_from_slice(&sums);
    }
}

/// Some rows as columns, with zeros in lanes without a row.
#[inline(always)]
fn turn(a: Columns<'_, f32>, start: usize, rows: usize, inner: usize, turned: &mut [f32]) {
    let lanes = turned.len() / inner.max(1);
    if rows < lanes {
        turned.chunks_exact_mut(lanes).for_each(|column| column[rows..].fill(0.0));
    }
    for (block, turned) in turned.chunks_mut(TURNED * lanes).enumerate() {
        for row in 0..rows {
            let from = &a.values[(start + row) * a.stride..][..inner][block * TURNED..];
            for (column, value) in turned.chunks_exact_mut(lanes).zip(from) {
                column[row] = *value;
            }
        }
    }
}

/// Columns as rows, copied or added.
#[inline(always)]
fn turn_back(mut out: MatMut<'_, f32>, accum: Accum, lanes: usize, sums: &[f32]) {
    for (block, sums) in sums.chunks(TURNED * lanes).enumerate() {
        for at in 0..out.nrows() {
            let into = &mut row(&mut out, at)[block * TURNED..];
            for (into, column) in into.iter_mut().zip(sums.chunks_exact(lanes)) {
                *into = if accum == Accum::Add { *into + column[at] } else { column[at] };
            }
        }
    }
}
