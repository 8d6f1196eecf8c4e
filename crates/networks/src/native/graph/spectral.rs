//! A graph filter in the basis of the eigenvectors of its symmetric matrix.

use faer::Accum;

use crate::gradients::Gradients;
use crate::graph::{GraphOf, Shape};
use crate::native::buffers::Buffers;
use crate::native::gradient_accumulator::GradientAccumulator;
use crate::native::products::{EigenProducts, Multiply, times};
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
    let nodes = of.nodes;
    let mut in_basis = buffers.take(values.len());
    let wide = values.len() / nodes;
    times(&mut in_basis, Accum::Replace, spectrum.basis_transposed, values, [nodes, nodes, wide], buffers);
    let mut out_in_basis = buffers.take(out.len());
    let products = EigenProducts {
        taps,
        shape,
        transposed: false,
        eigenvalues: spectrum.eigenvalues,
        a: &in_basis,
        out: &mut out_in_basis,
    };
    T::by_eigenvalue(products, buffers);
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
    (accumulator, gradients): (&mut GradientAccumulator<T>, &mut Gradients),
    buffers: &mut Buffers<T>,
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
    let mut d_input_in_basis = buffers.take(in_basis.len());
    let products = EigenProducts {
        taps: weights.get(taps),
        shape,
        transposed: true,
        eigenvalues: spectrum.eigenvalues,
        a: &d_in_basis,
        out: &mut d_input_in_basis,
    };
    T::by_eigenvalue(products, buffers);
    let mut d_input = buffers.take(in_basis.len());
    let sizes = [nodes, nodes, in_basis.len() / nodes];
    times(&mut d_input, Accum::Replace, spectrum.basis, &d_input_in_basis, sizes, buffers);
    buffers.put(d_in_basis);
    buffers.put(d_input_in_basis);
    d_input
}
