//! Products of hundreds of rows with a matrix of millions of weights, and the gradient of such a matrix.
//!
//! Both factors are copied into the order in which they are used, block by block: a panel of one factor stays in the nearest cache, a block of
//! both and of their sums in the next one. As they lie, rows that are a power of two apart push each other out of both.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::matrix::{Columns, Factor, Task};
use super::tiles::{TALLEST, Tiles, tile, write};
use super::vectors::{load_two, store_two};
use crate::native::buffers::Buffers;

/// Terms of the sums at a time: with the longest vectors a panel of the one factor and a tile of the other are 36 KB.
const TERMS: usize = 192;
/// Columns of sums at a time, ...
const GROUP: usize = 512;
/// ... and tiles of rows of them: a block of sums is at most 800 KB, with what it is made of 1.5 MB.
const TILES: usize = 28;

/// `a b`.
pub(super) fn times(task: Task<'_>, buffers: &mut Buffers<f32>) {
    times_by(task, buffers, |work| Arch::new().dispatch(work));
}

fn times_by(task: Task<'_>, buffers: &mut Buffers<f32>, dispatch: impl FnOnce(Large<'_>)) {
    let [rows, inner, _] = task.sizes();
    let mut in_tiles = buffers.take(rows * inner);
    let mut panels = buffers.take(TERMS * GROUP);
    let mut sums = buffers.take((TILES * TALLEST).min(rows) * GROUP);
    dispatch(Large { task, in_tiles: &mut in_tiles, panels: &mut panels, sums: &mut sums });
    for buffer in [in_tiles, panels, sums] {
        buffers.put(buffer);
    }
}

struct Large<'a> {
    task: Task<'a>,
    /// `a` in tiles of rows, each with its columns one after another.
    in_tiles: &'a mut [f32],
    /// Some rows and a group of columns of `b`, in panels of two vectors of columns, each with its rows one after another.
    panels: &'a mut [f32],
    /// A block of rows and the same group of columns of `a b`, in such panels.
    sums: &'a mut [f32],
}

impl WithSimd for Large<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Large { task, in_tiles, panels, sums } = self;
        let [rows, inner, columns] = task.sizes();
        let Task { mut out, accum, a, b, .. } = task;
        let width = 2 * S::F32_LANES;
        let tiles = Tiles::of::<S>(rows);
        tiles.fill(a, inner, in_tiles);
        if inner == 0 {
            // A sum of no terms is still a result.
            sums.fill(0.0);
        }
        for column in (0..columns).step_by(GROUP) {
            let group = column..columns.min(column + GROUP);
            for first_tile in (0..tiles.count()).step_by(TILES) {
                let block = || tiles.each().skip(first_tile).take(TILES);
                let top = block().next().map_or(0, |(start, _)| start);
                let tall: usize = block().map(|(_, rows)| rows).sum();
                for first in (0..inner).step_by(TERMS) {
                    let terms = first..inner.min(first + TERMS);
                    fill_panels::<S>(simd, b, terms.clone(), group.clone(), panels);
                    let panels = panels.chunks_exact(terms.len() * width);
                    let sums = sums.chunks_exact_mut(tall * width);
                    for (panel, sums) in panels.zip(sums).take(group.len().div_ceil(width)) {
                        for (start, rows) in block() {
                            let of_a = &in_tiles[start * inner + first * rows..][..terms.len() * rows];
                            let sums = &mut sums[(start - top) * width..][..rows * width];
                            tile::<S>(simd, rows, first > 0, sums, of_a, panel);
                        }
                    }
                }
                let block = out.as_mut().submatrix_mut(top, group.start, tall, group.len());
                write::<S>(simd, block, accum, sums);
            }
        }
    }
}

/// The rows `terms` and columns `group` of `b` in panels, the last one filled up with zeros.
#[inline(always)]
fn fill_panels<S: Simd>(
    simd: S,
    b: Factor<'_>,
    terms: Range<usize>,
    group: Range<usize>,
    panels: &mut [f32],
) {
    let width = 2 * S::F32_LANES;
    let Factor { lies: Columns { values, stride }, transposed } = b;
    if transposed {
        let panels = panels.chunks_exact_mut(terms.len() * width).take(group.len().div_ceil(width));
        for (number, panel) in panels.enumerate() {
            for lane in 0..width {
                let column = group.start + number * width + lane;
                let places = panel.iter_mut().skip(lane).step_by(width);
                if column < group.end {
                    let from = &values[column * stride..][terms.clone()];
                    places.zip(from).for_each(|(place, value)| *place = *value);
                } else {
                    places.for_each(|place| *place = 0.0);
                }
            }
        }
    } else {
        for (row, term) in terms.clone().enumerate() {
            let from = &values[term * stride..][group.clone()];
            for (number, from) in from.chunks(width).enumerate() {
                let into = &mut panels[(number * terms.len() + row) * width..][..width];
                store_two::<S>(simd, into, load_two::<S>(simd, from));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use faer::{Accum, MatMut};

    use super::*;

    fn numbers(count: usize, rate: f64) -> Vec<f32> {
        (0..count).map(|k| (rate * k as f64 + 0.3).sin() as f32).collect()
    }

    /// The longest vectors that this machine has, and none; factors as they lie and transposed; several blocks of rows, of terms and of columns;
    /// buffers that hold what was there before. Against sums of 64 bits.
    #[test]
    fn products_are_those_of_the_definition() {
        let ways: [fn(Large<'_>); 2] =
            [|work| Arch::new().dispatch(work), |work| pulp::Scalar::new().vectorize(work)];
        for way in ways {
            let mut buffers = Buffers::default();
            for sizes in [
                [3, 5, 7],
                [30, 5, 40],
                [30, 0, 40],
                [1, 200, 33],
                [450, 210, 60],
                [450, 20, 520],
                [20, 385, 1060],
            ] {
                for transposed in [[false, false], [true, false], [false, true], [true, true]] {
                    for accum in [Accum::Replace, Accum::Add] {
                        check(sizes, transposed, accum, &mut buffers, way);
                    }
                }
            }
        }
    }

    fn check(
        sizes: [usize; 3],
        [a_transposed, b_transposed]: [bool; 2],
        accum: Accum,
        buffers: &mut Buffers<f32>,
        way: fn(Large<'_>),
    ) {
        let [rows, inner, columns] = sizes;
        // Rows as they lie, with something between them.
        let lying = |rows, columns, transposed, rate| {
            let (rows, columns) = if transposed { (columns, rows) } else { (rows, columns) };
            (numbers(rows * (columns + 2), rate), columns + 2)
        };
        let (a, a_stride) = lying(rows, inner, a_transposed, 0.7);
        let (b, b_stride) = lying(inner, columns, b_transposed, 1.3);
        let at = |values: &[f32], stride: usize, transposed: bool, row: usize, column: usize| {
            let (row, column) = if transposed { (column, row) } else { (row, column) };
            f64::from(values[row * stride + column])
        };
        let stride = columns + 3;
        let before = numbers(rows * stride, 2.1);
        let mut found = before.clone();
        let task = Task {
            out: MatMut::from_column_major_slice_with_stride_mut(&mut found, columns, rows, stride)
                .transpose_mut(),
            accum,
            a: Factor { lies: Columns { values: &a, stride: a_stride }, transposed: a_transposed },
            b: Factor { lies: Columns { values: &b, stride: b_stride }, transposed: b_transposed },
            inner,
        };
        times_by(task, buffers, way);
        for (place, (found, before)) in found.iter().zip(&before).enumerate() {
            let (row, column) = (place / stride, place % stride);
            if column >= columns {
                assert_eq!(found, before, "beside the product");
                continue;
            }
            let terms = (0..inner)
                .map(|k| at(&a, a_stride, a_transposed, row, k) * at(&b, b_stride, b_transposed, k, column));
            let old = if accum == Accum::Add { f64::from(*before) } else { 0.0 };
            let error = (f64::from(*found) - old - terms.sum::<f64>()).abs();
            assert!(error < 1e-6 * (inner as f64 + 1.0), "{sizes:?}, row {row}, column {column}: {error:e}");
        }
    }
}
