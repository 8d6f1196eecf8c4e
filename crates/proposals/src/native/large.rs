//! Products of which no factor fits into a cache: hundreds of rows with a matrix of many millions of weights, and the gradient of such a matrix.
//!
//! Everything is copied once into the order in which it is used, block by block: a panel of one factor stays in the nearest cache, a block
//! of both and of their sums in the next one. Rows of matrices that are a power of two apart push each other out of both.

use std::ops::Range;

use faer::Accum;
use pulp::{Arch, Simd, WithSimd};

use super::Buffers;
use super::panels::{TALLEST, Tiles, tile};
use super::products::ColumnsMut;
use super::vectors::{load_two, store_two};

/// Terms of the sums at a time: a panel of the one factor and a tile of the other have this many, and together fit into the nearest cache.
const TERMS: usize = 192;
/// Columns of sums at a time, ...
const GROUP: usize = 512;
/// ... and tiles of rows of them: a block of these fits into a core's own cache, with what it is made of.
const TILES: usize = 28;

/// A factor of a product.
#[derive(Clone, Copy)]
pub(super) struct Factor<'a> {
    pub(super) values: &'a [f32],
    /// From one row in memory to the next.
    pub(super) stride: usize,
    /// Whether the factor is the transpose of what lies in memory.
    pub(super) transposed: bool,
}

/// `out = a b`, or `out += a b`: `rows×inner` times `inner×columns`.
pub(super) fn times(
    out: ColumnsMut<'_, f32>,
    accum: Accum,
    [a, b]: [Factor<'_>; 2],
    sizes: [usize; 3],
    buffers: &mut Buffers<f32>,
) {
    let [rows, inner, _] = sizes;
    let mut in_tiles = buffers.take(rows * inner);
    let mut panels = buffers.take(TERMS * GROUP);
    let mut sums = buffers.take((TILES * TALLEST).min(rows) * GROUP);
    let large =
        Large { out, accum, a, b, sizes, in_tiles: &mut in_tiles, panels: &mut panels, sums: &mut sums };
    Arch::new().dispatch(large);
    for buffer in [in_tiles, panels, sums] {
        buffers.put(buffer);
    }
}

struct Large<'a> {
    out: ColumnsMut<'a, f32>,
    accum: Accum,
    a: Factor<'a>,
    b: Factor<'a>,
    sizes: [usize; 3],
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
        let Large { out, accum, a, b, sizes: [rows, inner, columns], in_tiles, panels, sums } = self;
        let width = 2 * S::F32_LANES;
        let tiles = Tiles::of::<S>(rows);
        for (start, tall) in tiles.each() {
            fill_tile(a, start, tall, &mut in_tiles[start * inner..(start + tall) * inner]);
        }
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
                let into = ColumnsMut { values: &mut out.values[top * out.stride..], stride: out.stride };
                write::<S>(simd, into, accum, tall, group.clone(), sums);
            }
        }
    }
}

/// Rows of `a` from `start` on, their columns one after another.
#[inline(always)]
fn fill_tile(a: Factor<'_>, start: usize, rows: usize, tile: &mut [f32]) {
    let inner = tile.len() / rows;
    if a.transposed {
        for (column, from) in tile.chunks_exact_mut(rows).zip(a.values.chunks(a.stride)) {
            column.copy_from_slice(&from[start..start + rows]);
        }
    } else {
        for row in 0..rows {
            let from = &a.values[(start + row) * a.stride..][..inner];
            for (column, value) in tile.chunks_exact_mut(rows).zip(from) {
                column[row] = *value;
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
    if b.transposed {
        for (number, panel) in panels.chunks_exact_mut(terms.len() * width).enumerate() {
            for lane in 0..width {
                let column = group.start + number * width + lane;
                let places = panel.iter_mut().skip(lane).step_by(width);
                if column < group.end {
                    let from = &b.values[column * b.stride..][terms.clone()];
                    places.zip(from).for_each(|(place, value)| *place = *value);
                } else if column < group.end.next_multiple_of(width) {
                    places.for_each(|place| *place = 0.0);
                }
            }
        }
    } else {
        for (row, term) in terms.clone().enumerate() {
            let from = &b.values[term * b.stride..][group.clone()];
            for (number, from) in from.chunks(width).enumerate() {
                let into = &mut panels[(number * terms.len() + row) * width..][..width];
                store_two::<S>(simd, into, load_two::<S>(simd, from));
            }
        }
    }
}

/// Writes or adds a block of sums to the columns `group` of `out`.
#[inline(always)]
fn write<S: Simd>(
    simd: S,
    out: ColumnsMut<'_, f32>,
    accum: Accum,
    rows: usize,
    group: Range<usize>,
    sums: &[f32],
) {
    let width = 2 * S::F32_LANES;
    for row in 0..rows {
        let into = &mut out.values[row * out.stride..][group.clone()];
        for (number, into) in into.chunks_mut(width).enumerate() {
            let mut found = load_two::<S>(simd, &sums[(number * rows + row) * width..][..width]);
            if accum == Accum::Add {
                let before = load_two::<S>(simd, into);
                found = [simd.add_f32s(found[0], before[0]), simd.add_f32s(found[1], before[1])];
            }
            store_two::<S>(simd, into, found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, rate: f64) -> Vec<f32> {
        (0..count).map(|k| (rate * k as f64 + 0.3).sin() as f32).collect()
    }

    /// Factors as they are and transposed, more and fewer than a block of everything, against sums of 64 bits.
    #[test]
    fn products_are_those_of_the_definition() {
        for sizes in [[3, 5, 7], [30, 0, 40], [1, 200, 33], [450, 210, 60], [20, 385, 1060]] {
            let [rows, inner, columns] = sizes;
            for [of_a, of_b] in [[false, false], [true, false], [false, true], [true, true]] {
                let factor = |[rows, columns]: [usize; 2], rate, transposed| {
                    let (rows, columns) = if transposed { (columns, rows) } else { (rows, columns) };
                    (numbers(rows * (columns + 2), rate), columns + 2)
                };
                let (a, of_row) = factor([rows, inner], 0.7, of_a);
                let (b, of_term) = factor([inner, columns], 1.3, of_b);
                let at = |values: &[f32], stride: usize, transposed: bool, row: usize, column: usize| {
                    let (row, column) = if transposed { (column, row) } else { (row, column) };
                    f64::from(values[row * stride + column])
                };
                let stride = columns + 3;
                let before = numbers(rows * stride, 2.1);
                for accum in [Accum::Replace, Accum::Add] {
                    let mut found = before.clone();
                    let factors = [
                        Factor { values: &a, stride: of_row, transposed: of_a },
                        Factor { values: &b, stride: of_term, transposed: of_b },
                    ];
                    let out = ColumnsMut { values: &mut found, stride };
                    times(out, accum, factors, sizes, &mut Buffers::default());
                    for (place, (found, before)) in found.iter().zip(&before).enumerate() {
                        let (row, column) = (place / stride, place % stride);
                        if column >= columns {
                            assert_eq!(found, before, "beside the product");
                            continue;
                        }
                        let sum: f64 = (0..inner)
                            .map(|k| at(&a, of_row, of_a, row, k) * at(&b, of_term, of_b, k, column))
                            .sum();
                        let sum = if accum == Accum::Add { sum + f64::from(*before) } else { sum };
                        let error = (f64::from(*found) - sum).abs();
                        assert!(error < 1e-6 * (inner as f64 + 1.0), "row {row}, column {column}: {error:e}");
                    }
                }
            }
        }
    }
}
