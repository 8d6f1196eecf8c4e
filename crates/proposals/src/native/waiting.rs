//! Gradients of matrices that many times share: rows wait until one product is worth its while.

use super::graph::{Eigen, gradient};
use super::products::transposed_times;
use crate::Gradients;
use crate::values::Real;

/// Inputs and derivatives of outputs of the maps with each matrix, waiting to be multiplied.
///
/// `W̄ = Σ_t inputs_tᵀ d_outputs_t` is then one product of many rows instead of a sum of as many matrices.
pub(crate) struct Waiting<T> {
    /// By the index of the matrix.
    matrices: Vec<Pile<T>>,
}

/// What waits for one matrix. The way in which a filter is computed may change with the number of rows: before rows of another kind, those
/// that wait are multiplied.
enum Pile<T> {
    Nothing,
    /// Of an affine map.
    Rows {
        rows: usize,
        widths: [usize; 2],
        inputs: Vec<T>,
        d_outputs: Vec<T>,
    },
    /// Of a graph filter: the same for each eigenvalue.
    Spectral {
        rows: usize,
        shape: crate::gnn::Shape,
        eigenvalues: Vec<T>,
        by_eigenvalue: Vec<(Vec<T>, Vec<T>)>,
    },
}

/// From this many rows on a product is worth its while, and memory stays bounded however long the sequence.
const ENOUGH: usize = 2048;

impl<T: Real> Waiting<T> {
    pub(crate) fn none(matrices: usize) -> Self {
        Waiting { matrices: (0..matrices).map(|_| Pile::Nothing).collect() }
    }

    /// Adds the rows of one affine map.
    pub(super) fn push(
        &mut self,
        index: usize,
        (more, widths): (usize, [usize; 2]),
        new_inputs: &[T],
        new_d_outputs: &[T],
        gradients: &mut Gradients,
    ) {
        let pile = &mut self.matrices[index];
        if !matches!(pile, Pile::Rows { .. }) {
            pile.multiply_if(1, index, gradients);
            *pile = Pile::Rows { rows: 0, widths, inputs: Vec::new(), d_outputs: Vec::new() };
        }
        if let Pile::Rows { rows, inputs, d_outputs, .. } = pile {
            *rows += more;
            inputs.extend_from_slice(new_inputs);
            d_outputs.extend_from_slice(new_d_outputs);
        }
        pile.multiply_if(ENOUGH, index, gradients);
    }

    /// Adds the rows of one graph filter, eigenvalue by eigenvalue.
    pub(super) fn push_spectral(
        &mut self,
        way: &Eigen<'_, T>,
        in_basis: &[T],
        d_in_basis: &[T],
        gradients: &mut Gradients,
    ) {
        let Eigen { of, shape, taps: index, rows: more } = *way;
        let pile = &mut self.matrices[index];
        if !matches!(pile, Pile::Spectral { .. }) {
            pile.multiply_if(1, index, gradients);
            let eigenvalues = of.spectrum.map_or(Vec::new(), |spectrum| spectrum.eigenvalues.to_vec());
            let by_eigenvalue = vec![(Vec::new(), Vec::new()); of.nodes];
            *pile = Pile::Spectral { rows: 0, shape, eigenvalues, by_eigenvalue };
        }
        if let Pile::Spectral { rows, by_eigenvalue, .. } = pile {
            *rows += more;
            let blocks = in_basis.chunks_exact(in_basis.len() / of.nodes);
            let blocks = blocks.zip(d_in_basis.chunks_exact(d_in_basis.len() / of.nodes));
            for ((inputs, d_outputs), (new_inputs, new_d_outputs)) in by_eigenvalue.iter_mut().zip(blocks) {
                inputs.extend_from_slice(new_inputs);
                d_outputs.extend_from_slice(new_d_outputs);
            }
        }
        pile.multiply_if(ENOUGH * of.nodes, index, gradients);
    }

    /// Multiplies what still waits.
    pub(super) fn finish(&mut self, gradients: &mut Gradients) {
        for (index, pile) in self.matrices.iter_mut().enumerate() {
            pile.multiply_if(1, index, gradients);
        }
    }
}

impl<T: Real> Pile<T> {
    /// Forms the gradient if there are at least this many rows; the memory is kept.
    fn multiply_if(&mut self, enough: usize, index: usize, gradients: &mut Gradients) {
        match self {
            Pile::Rows { rows, widths: [width_in, width_out], inputs, d_outputs } if *rows >= enough => {
                let (place, accum) = gradients.place(index);
                transposed_times(place, accum, inputs, d_outputs, [*width_in, *rows, *width_out]);
                *rows = 0;
                inputs.clear();
                d_outputs.clear();
            }
            Pile::Spectral { rows, shape, eigenvalues, by_eigenvalue } if *rows >= enough => {
                let (place, accum) = gradients.place(index);
                gradient(eigenvalues, *shape, by_eigenvalue, place, accum);
                *rows = 0;
                for (inputs, d_outputs) in by_eigenvalue {
                    inputs.clear();
                    d_outputs.clear();
                }
            }
            _ => {}
        }
    }
}
