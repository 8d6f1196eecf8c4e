//! A graph filter in the basis of the eigenvectors of its symmetric matrix.

use faer::Accum;
use motes_models::batch::by_widest_vectors;

use crate::gradients::Gradients;
use crate::graph::{GraphOf, Shape};
use crate::native::buffers::Buffers;
use crate::native::gradient_accumulator::GradientAccumulator;
use crate::native::products::{Columns, ColumnsMut, Multiply, Product, times};
use crate::parameters::Matrices;

/// A filter in this basis on its way back.
pub(super) struct Eigen<'a, T> {
    pub(super) of: GraphOf<'a, T>,
    pub(super) shape: Shape,
    /// The index of its taps.
    pub(super) taps: usize,
    /// Rows of all nodes.
    pub(super) rows: usize,
}

/// How many numbers of all taps are worked on at a time: what stays in a core's own cache while every eigenvalue takes its turn.
const PANEL: usize = 128 * 1024;

/// How many rows of each tap are worked on at a time.
fn panel_rows(Shape { inputs, outputs, taps }: Shape) -> usize {
    (PANEL / (taps * outputs)).clamp(8, inputs.max(8)).min(inputs)
}

/// `Y = U Ŷ` with `Ŷ_i = X̂_i Σ_d λ_i^d W_d` and `X̂ = Uᵀ X`, which is returned.
pub(super) fn forward<T: Multiply>(
    of: GraphOf<'_, T>,
    values: &[T],
    taps: &[T],
    shape: Shape,
    out: &mut [T],
    buffers: &mut Buffers<T>,
) -> Vec<T> {
    let Some(spectrum) = of.spectrum else { panic!("this way is taken where there is a spectrum") };
    let (nodes, Shape { inputs, outputs, .. }) = (of.nodes, shape);
    let mut in_basis = buffers.take(values.len());
    let wide = values.len() / nodes;
    times(&mut in_basis, Accum::Replace, spectrum.basis_transposed, values, [nodes, nodes, wide], buffers);
    let rows = wide / inputs;
    let mut out_in_basis = buffers.take(out.len());
    each_panel(shape, |first, panel| {
        let mut matrix = buffers.take(panel * outputs);
        for (i, &eigenvalue) in spectrum.eigenvalues.iter().enumerate() {
            combine(taps, shape, (first, panel), eigenvalue, &mut matrix);
            let from = &in_basis[i * rows * inputs..(i + 1) * rows * inputs];
            let into = &mut out_in_basis[i * rows * outputs..(i + 1) * rows * outputs];
            let accum = if first == 0 { Accum::Replace } else { Accum::Add };
            let some = Columns { values: &from[first..], stride: inputs };
            let into = ColumnsMut { values: into, stride: outputs };
            let sizes = [rows, panel, outputs];
            T::times(Product { out: into, accum, a: some, b: &matrix, sizes }, buffers);
        }
        buffers.put(matrix);
    });
    let sizes = [nodes, nodes, out.len() / nodes];
    times(out, Accum::Replace, spectrum.basis, &out_in_basis, sizes, buffers);
    buffers.put(out_in_basis);
    in_basis
}

/// The derivative with respect to the input, from that with respect to the output before its activation.
pub(super) fn backward<T: Multiply>(
    way: &Eigen<'_, T>,
    weights: Matrices<'_, T>,
    in_basis: &[T],
    d: &[T],
    (buffers, accumulator, gradients): (&mut Buffers<T>, &mut GradientAccumulator<T>, &mut Gradients),
) -> Vec<T> {
    let &Eigen { of, shape, taps, rows } = way;
    let Some(spectrum) = of.spectrum else { panic!("this way is taken where there is a spectrum") };
    let (nodes, Shape { inputs, outputs, .. }) = (of.nodes, shape);
    let rows = rows / nodes;
    let mut d_in_basis = buffers.take(d.len());
    let sizes = [nodes, nodes, d.len() / nodes];
    times(&mut d_in_basis, Accum::Replace, spectrum.basis_transposed, d, sizes, buffers);
    // `W̄_d = Σ_i λ_i^d X̂_iᵀ dŶ_i`.
    let by_eigenvalue = in_basis.chunks_exact(rows * inputs).zip(d_in_basis.chunks_exact(rows * outputs));
    let by_eigenvalue = spectrum.eigenvalues.iter().zip(by_eigenvalue).map(|(value, (x, d))| (*value, x, d));
    accumulator.push_all(taps, shape, by_eigenvalue, buffers, gradients);
    let matrix_of_taps = weights.get(taps);
    let mut d_input_in_basis = buffers.take(in_basis.len());
    each_panel(shape, |first, panel| {
        let mut matrix = buffers.take(panel * outputs);
        for (i, &eigenvalue) in spectrum.eigenvalues.iter().enumerate() {
            combine(matrix_of_taps, shape, (first, panel), eigenvalue, &mut matrix);
            let from = &d_in_basis[i * rows * outputs..(i + 1) * rows * outputs];
            let into = &mut d_input_in_basis[i * rows * inputs..(i + 1) * rows * inputs];
            let some = ColumnsMut { values: &mut into[first..], stride: inputs };
            let from = Columns { values: from, stride: outputs };
            let (accum, sizes) = (Accum::Replace, [rows, outputs, panel]);
            T::times_transposed(Product { out: some, accum, a: from, b: &matrix, sizes }, buffers);
        }
        buffers.put(matrix);
    });
    let mut d_input = buffers.take(in_basis.len());
    let sizes = [nodes, nodes, in_basis.len() / nodes];
    times(&mut d_input, Accum::Replace, spectrum.basis, &d_input_in_basis, sizes, buffers);
    buffers.put(d_in_basis);
    buffers.put(d_input_in_basis);
    d_input
}

/// Visits all rows of the taps, some at a time.
fn each_panel(shape: Shape, mut visit: impl FnMut(usize, usize)) {
    let mut first = 0;
    while first < shape.inputs {
        let rows = panel_rows(shape).min(shape.inputs - first);
        visit(first, rows);
        first += rows;
    }
}

/// `Σ_d λ^d W_d`, some rows of it.
fn combine<T: Multiply>(
    taps: &[T],
    Shape { inputs, outputs, taps: count }: Shape,
    (first, panel): (usize, usize),
    eigenvalue: T,
    out: &mut [T],
) {
    by_widest_vectors(
        #[inline(always)]
        || {
            for (row, out) in out.chunks_exact_mut(outputs).take(panel).enumerate() {
                let tap = |tap: usize| {
                    let at = (tap * inputs + first + row) * outputs;
                    &taps[at..at + outputs]
                };
                // From the last tap inwards, so that no power is formed; the usual number of taps in one pass.
                if count == 4 {
                    let taps = tap(0).iter().zip(tap(1)).zip(tap(2).iter().zip(tap(3)));
                    for (out, ((w0, w1), (w2, w3))) in out.iter_mut().zip(taps) {
                        *out = *w0 + eigenvalue * (*w1 + eigenvalue * (*w2 + eigenvalue * *w3));
                    }
                    continue;
                }
                out.copy_from_slice(tap(count - 1));
                for d in (0..count - 1).rev() {
                    out.iter_mut().zip(tap(d)).for_each(|(sum, term)| *sum = *sum * eigenvalue + *term);
                }
            }
        },
    );
}
