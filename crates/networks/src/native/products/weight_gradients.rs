//! Gradients of weights: sums of outer products, formed some rows at a time and handed over while they are in a cache.

use faer::Accum;
use motes_models::batch::by_widest_vectors;
use pulp::{Arch, Simd, WithSimd};

use super::multiply::{Multiply, transposed_times};
use super::outer_products::{OuterProducts, Take, Terms};
use super::tiles::{TALLEST, Tiles, WIDEST, add_products};
use super::vectors::load_two;
use crate::graph::Shape;
use crate::native::buffers::Buffers;
use crate::values::Real;

/// Hands an affine map's sums over in one part.
pub(super) fn whole<T: Multiply>(sums: &OuterProducts<'_, T>, buffers: &mut Buffers<T>, take: Take<'_, T>) {
    let mut product = buffers.take(sums.shape.inputs * sums.shape.outputs);
    add_whole(sums, &mut product, Accum::Replace, buffers);
    take(0, &product);
    buffers.put(product);
}

/// Writes or adds an affine map's sums; nothing if they are no affine map's.
pub(crate) fn add_whole<T: Multiply>(
    sums: &OuterProducts<'_, T>,
    out: &mut [T],
    accum: Accum,
    buffers: &mut Buffers<T>,
) {
    let Shape { inputs, outputs, .. } = sums.shape;
    if let Some(Terms { inputs: rows, d_outputs, .. }) = sums.affine() {
        let sizes = [inputs, rows.len() / inputs, outputs];
        transposed_times(out, accum, rows, d_outputs, sizes, buffers);
    }
}

/// Hands over all rows of the sums, each of them in one part or in several.
pub(super) fn each_row<T: Real>(sums: &OuterProducts<'_, T>, buffers: &mut Buffers<T>, take: Take<'_, T>) {
    let Shape { inputs, outputs, taps } = sums.shape;
    let (mut product, mut of_taps) = (buffers.take(outputs), buffers.take(taps * outputs));
    for row in 0..inputs {
        of_taps.fill(T::ZERO);
        for term in sums.terms {
            product.fill(T::ZERO);
            let rows = term.inputs.iter().skip(row).step_by(inputs).zip(term.d_outputs.chunks_exact(outputs));
            by_widest_vectors(
                #[inline(always)]
                || {
                    for (input, d_outputs) in rows.clone() {
                        product.iter_mut().zip(d_outputs).for_each(|(sum, d)| *sum += *input * *d);
                    }
                    let mut power = T::ONE;
                    for of_tap in of_taps.chunks_exact_mut(outputs) {
                        of_tap.iter_mut().zip(&product).for_each(|(sum, term)| *sum += power * *term);
                        power *= term.eigenvalue;
                    }
                },
            );
        }
        for (tap, of_tap) in of_taps.chunks_exact(outputs).enumerate() {
            take((tap * inputs + row) * outputs, of_tap);
        }
    }
    buffers.put(product);
    buffers.put(of_taps);
}

/// [`each_row`] by tiles of rows, whose sums stay in registers.
pub(super) fn each_tile(sums: &OuterProducts<'_, f32>, buffers: &mut Buffers<f32>, take: Take<'_, f32>) {
    each_tile_by(sums, buffers, take, |work| Arch::new().dispatch(work));
}

fn each_tile_by(
    sums: &OuterProducts<'_, f32>,
    buffers: &mut Buffers<f32>,
    take: Take<'_, f32>,
    dispatch: impl FnOnce(EachTile<'_, '_>),
) {
    let Shape { inputs, outputs, taps } = sums.shape;
    let rows: usize = sums.terms.iter().map(|term| term.inputs.len() / inputs).sum();
    let group = (GROUP / rows.max(1)).clamp(WIDEST, LONGEST) / WIDEST * WIDEST;
    let group = group.min(outputs.next_multiple_of(WIDEST));
    let mut panels = buffers.take(rows * group);
    let mut in_tiles = buffers.take(rows * inputs);
    let mut tile = buffers.take(taps * TALLEST * (group + WIDEST));
    dispatch(EachTile {
        shape: sums.shape,
        terms: sums.terms,
        rows,
        group,
        panels: &mut panels,
        in_tiles: &mut in_tiles,
        tile: &mut tile,
        take,
    });
    for buffer in [panels, in_tiles, tile] {
        buffers.put(buffer);
    }
}

/// Numbers of the derivatives of outputs that every tile uses again: what a core's own cache holds beside weights, unless there are so
/// many rows that already the narrowest panel has more.
const GROUP: usize = 128 * 1024;
/// The most columns at a time: a page of memory.
const LONGEST: usize = 1024;

struct EachTile<'a, 'b> {
    shape: Shape,
    terms: &'a [Terms<f32>],
    /// Of all terms.
    rows: usize,
    /// Columns at a time.
    group: usize,
    /// Derivatives of outputs in panels of two vectors of columns, each with its rows one after another.
    panels: &'a mut [f32],
    /// All inputs in tiles of columns, each with its rows one after another.
    in_tiles: &'a mut [f32],
    /// Of each tap, the sums of some rows and columns.
    tile: &'a mut [f32],
    take: Take<'b, f32>,
}

impl WithSimd for EachTile<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let EachTile { shape, terms, rows: count, group, panels, in_tiles, tile, take } = self;
        let Shape { inputs, outputs, taps } = shape;
        let width = 2 * S::F32_LANES;
        let tiles = Tiles::of::<S>(inputs);
        let rows = terms.iter().flat_map(|term| term.inputs.chunks_exact(inputs));
        for (number, row) in rows.enumerate() {
            for (start, tall) in tiles.each() {
                let at = start * count + number * tall;
                in_tiles[at..at + tall].copy_from_slice(&row[start..start + tall]);
            }
        }
        let mut first = 0;
        while first < outputs {
            let some = group.min(outputs - first);
            // Rows that begin a page apart would push each other out of the nearest cache.
            let stride = some.next_multiple_of(width) + width;
            let rows = || terms.iter().flat_map(|term| term.d_outputs.chunks_exact(outputs));
            let mut places = panels.chunks_exact_mut(width);
            for column in (0..some).step_by(width) {
                let last = (column + width).min(some);
                for (row, place) in rows().zip(places.by_ref()) {
                    let (place, _) = S::as_mut_simd_f32s(place);
                    place.copy_from_slice(&load_two::<S>(simd, &row[first + column..first + last]));
                }
            }
            for (start, tall) in tiles.each() {
                let columns = &in_tiles[start * count..(start + tall) * count];
                for (number, panel) in
                    panels.chunks_exact(count * width).take(some.div_ceil(width)).enumerate()
                {
                    let factors = Factors { terms, inputs, columns, panel };
                    let into = SumsOfTaps { values: &mut tile[number * width..], stride, taps };
                    tile_of_panel::<S>(simd, tall, factors, into);
                }
                for tap in 0..taps {
                    let at = (tap * inputs + start) * outputs + first;
                    let rows = &tile[tap * tall * stride..(tap + 1) * tall * stride];
                    for (row, values) in rows.chunks_exact(stride).enumerate() {
                        take(at + row * outputs, &values[..some]);
                    }
                }
            }
            first += some;
        }
    }
}

/// What a tile's sums are made of.
struct Factors<'a> {
    /// Their eigenvalues and numbers of rows.
    terms: &'a [Terms<f32>],
    /// The width of a row of inputs.
    inputs: usize,
    columns: &'a [f32],
    panel: &'a [f32],
}

/// Where the sums of a panel go.
struct SumsOfTaps<'a> {
    values: &'a mut [f32],
    stride: usize,
    taps: usize,
}

#[inline(always)]
fn tile_of_panel<S: Simd>(simd: S, rows: usize, factors: Factors<'_>, into: SumsOfTaps<'_>) {
    macro_rules! of_rows {
        ($($rows:literal)*) => {
            match rows {
                $($rows => sized::<S, $rows>(simd, factors, into),)*
                _ => unreachable!("a tile has as many rows as fit into registers"),
            }
        };
    }
    of_rows!(1 2 3 4 5 6 7 8 9 10 11 12 13 14)
}

#[inline(always)]
fn sized<S: Simd, const R: usize>(simd: S, factors: Factors<'_>, into: SumsOfTaps<'_>) {
    let Factors { terms, inputs, columns, panel } = factors;
    let (mut columns, _) = columns.as_chunks::<R>();
    let (panel, _) = S::as_simd_f32s(panel);
    let (mut panel, _) = panel.as_chunks::<2>();
    for (number, term) in terms.iter().enumerate() {
        let count = term.inputs.len() / inputs;
        let (a, later_columns) = columns.split_at(count);
        let (b, later_panel) = panel.split_at(count);
        let mut sums = [[simd.splat_f32s(0.0); 2]; R];
        add_products::<S, R>(simd, &mut sums, a, b);
        let mut power = 1.0;
        for tap in 0..into.taps {
            let by = simd.splat_f32s(power);
            for (row, sums) in sums.iter().enumerate() {
                let at = (tap * R + row) * into.stride;
                let (places, _) = S::as_mut_simd_f32s(&mut into.values[at..at + 2 * S::F32_LANES]);
                // An array, because a loop over a slice, whose length the compiler does not know, would keep the sums in memory.
                let Some(places) = places.first_chunk_mut::<2>() else { return };
                *places = match number {
                    0 => [simd.mul_f32s(by, sums[0]), simd.mul_f32s(by, sums[1])],
                    _ => [
                        simd.mul_add_e_f32s(by, sums[0], places[0]),
                        simd.mul_add_e_f32s(by, sums[1], places[1]),
                    ],
                };
            }
            power *= term.eigenvalue;
        }
        (columns, panel) = (later_columns, later_panel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, rate: f64) -> Vec<f32> {
        (0..count).map(|k| (rate * k as f64 + 0.3).sin() as f32).collect()
    }

    /// Every way and every rest of a tile, against sums of 64 bits; each place is handed over once.
    #[test]
    fn sums_are_those_of_the_definition() {
        let shape = |inputs, outputs, taps| Shape { inputs, outputs, taps };
        for (shape, rows, eigenvalues) in [
            (shape(1, 1, 1), 1, 1),
            (shape(18, 64, 1), 10, 1),
            (shape(33, 70, 1), 111, 1),
            (shape(5, 1100, 1), 50, 1),
            (shape(20, 96, 1), 2000, 1),
            (shape(15, 64, 4), 10, 10),
            (shape(29, 37, 3), 7, 5),
            (shape(3, 100, 2), 600, 3),
        ] {
            let terms: Vec<Terms<f32>> = (0..eigenvalues)
                .map(|i| Terms {
                    eigenvalue: 0.9 - 0.3 * i as f32,
                    inputs: numbers(rows * shape.inputs, 0.7 + i as f64),
                    d_outputs: numbers(rows * shape.outputs, 1.3 + i as f64),
                })
                .collect();
            let sums = OuterProducts { shape, terms: &terms };
            let mut buffers = Buffers::default();
            let without_vectors: fn(&OuterProducts<'_, f32>, &mut Buffers<f32>, Take<'_, f32>) =
                |sums, buffers, take| {
                    each_tile_by(sums, buffers, take, |work| pulp::Scalar::new().vectorize(work))
                };
            for way in [each_tile, without_vectors, each_row::<f32>] {
                let mut found = vec![f32::NAN; shape.taps * shape.inputs * shape.outputs];
                way(&sums, &mut buffers, &mut |at, values| {
                    let places = &mut found[at..at + values.len()];
                    assert!(places.iter().all(|place| place.is_nan()));
                    places.copy_from_slice(values);
                });
                check(&found, &sums, rows);
            }
        }
    }

    fn check(found: &[f32], sums: &OuterProducts<'_, f32>, rows: usize) {
        let Shape { inputs, outputs, .. } = sums.shape;
        for (at, found) in found.iter().enumerate() {
            let (row, column) = (at / outputs, at % outputs);
            let (tap, row) = (row / inputs, row % inputs);
            let (mut expected, mut size) = (0.0, 0.0);
            for term in sums.terms {
                let power = f64::from(term.eigenvalue).powi(tap as i32);
                for k in 0..rows {
                    let (x, y) = (term.inputs[k * inputs + row], term.d_outputs[k * outputs + column]);
                    expected += power * f64::from(x) * f64::from(y);
                    size += (power * f64::from(x) * f64::from(y)).abs();
                }
            }
            let error = (f64::from(*found) - expected).abs();
            assert!(error <= 1e-5 * size, "entry {at}: {found} for {expected}");
        }
    }
}
