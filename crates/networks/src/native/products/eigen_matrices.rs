//! Products with a matrix for each eigenvalue of a graph, each of which is formed before it is multiplied by.

use faer::Accum;
use motes_models::batch::by_widest_vectors;

use super::eigen_products::EigenProducts;
use super::matrix::{Columns, ColumnsMut, Product};
use super::multiply::Multiply;
use crate::graph::Shape;
use crate::native::buffers::Buffers;
use crate::values::Real;

/// How many numbers of all taps are worked on at a time: what stays in a core's own cache while every eigenvalue takes its turn.
const PANEL: usize = 128 * 1024;

/// Forms some rows of each matrix and multiplies by them.
pub(super) fn one_by_one<T: Multiply>(products: EigenProducts<'_, T>, buffers: &mut Buffers<T>) {
    let [rows, inner, columns] = products.sizes();
    let EigenProducts { taps, shape, transposed, eigenvalues, a, out, .. } = products;
    let Shape { inputs, outputs, taps: count } = shape;
    let panel_rows = (PANEL / (count * outputs)).clamp(8, inputs.max(8)).min(inputs);
    for first in (0..inputs).step_by(panel_rows) {
        let panel = panel_rows.min(inputs - first);
        let mut matrix = buffers.take(panel * outputs);
        let of_eigenvalues = a.chunks_exact(rows * inner).zip(out.chunks_exact_mut(rows * columns));
        for (&eigenvalue, (from, into)) in eigenvalues.iter().zip(of_eigenvalues) {
            combine(taps, shape, (first, panel), eigenvalue, &mut matrix);
            if transposed {
                let out = ColumnsMut { values: &mut into[first..], stride: inputs };
                let a = Columns { values: from, stride: outputs };
                let sizes = [rows, outputs, panel];
                T::times_transposed(Product { out, accum: Accum::Replace, a, b: &matrix, sizes }, buffers);
            } else {
                let accum = if first == 0 { Accum::Replace } else { Accum::Add };
                let out = ColumnsMut { values: into, stride: outputs };
                let a = Columns { values: &from[first..], stride: inputs };
                T::times(Product { out, accum, a, b: &matrix, sizes: [rows, panel, outputs] }, buffers);
            }
        }
        buffers.put(matrix);
    }
}

/// Some rows of `W(λ)`, from the last tap inwards, so that no power is formed.
fn combine<T: Real>(
    taps: &[T],
    Shape { inputs, outputs, taps: count }: Shape,
    (first, panel): (usize, usize),
    eigenvalue: T,
    matrix: &mut [T],
) {
    by_widest_vectors(
        #[inline(always)]
        || {
            for (row, out) in matrix.chunks_exact_mut(outputs).take(panel).enumerate() {
                let tap = |tap: usize| &taps[(tap * inputs + first + row) * outputs..][..outputs];
                out.copy_from_slice(tap(count - 1));
                for d in (0..count - 1).rev() {
                    out.iter_mut().zip(tap(d)).for_each(|(sum, term)| *sum = *sum * eigenvalue + *term);
                }
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::super::eigen_panels;
    use super::*;

    fn numbers<T: Real>(count: usize, rate: f64) -> Vec<T> {
        (0..count).map(|k| T::of((rate * k as f64 + 0.3).sin())).collect()
    }

    /// Both directions, in one block and in several, by every way, against sums of 64 bits.
    fn check<T: Multiply>(way: fn(EigenProducts<'_, T>, &mut Buffers<T>), tolerance: f64) {
        let mut buffers = Buffers::default();
        for ([inputs, outputs, taps], rows, count) in [
            ([1, 1, 1], 1, 1),
            ([5, 70, 4], 10, 3),
            ([33, 64, 2], 14, 2),
            ([70, 37, 4], 50, 10),
            ([64, 100, 5], 29, 4),
            ([300, 600, 4], 3, 2),
        ] {
            let shape = Shape { inputs, outputs, taps };
            let of_taps = numbers::<T>(taps * inputs * outputs, 0.7);
            let eigenvalues: Vec<T> = (0..count).map(|i| T::of(0.9 - 0.3 * i as f64)).collect();
            for transposed in [false, true] {
                let [inner, columns] = if transposed { [outputs, inputs] } else { [inputs, outputs] };
                let a = numbers::<T>(count * rows * inner, 1.3);
                let mut out = vec![T::of(f64::NAN); count * rows * columns];
                let (taps, eigenvalues) = (of_taps.as_slice(), eigenvalues.as_slice());
                let products = EigenProducts { taps, shape, transposed, eigenvalues, a: &a, out: &mut out };
                way(products, &mut buffers);
                for (at, found) in out.iter().enumerate() {
                    let (row, column) = (at / columns, at % columns);
                    let (mut expected, mut size) = (0.0, 1.0);
                    for k in 0..inner {
                        let (i, o) = if transposed { (column, k) } else { (k, column) };
                        for d in 0..shape.taps {
                            let power = eigenvalues[row / rows].wide().powi(d as i32);
                            let weight = taps[(d * inputs + i) * outputs + o].wide();
                            let term = a[row * inner + k].wide() * power * weight;
                            expected += term;
                            size += term.abs();
                        }
                    }
                    let error = (found.wide() - expected).abs();
                    assert!(error <= tolerance * size, "{shape:?}, {rows} rows, entry {at}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn products_are_those_of_the_definition() {
        check::<f64>(one_by_one, 1e-14);
        check::<f32>(one_by_one, 1e-6);
        check::<f32>(eigen_panels::times, 1e-6);
        check::<f32>(eigen_panels::times_without_vectors, 1e-6);
    }
}
