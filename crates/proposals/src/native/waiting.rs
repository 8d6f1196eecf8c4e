//! Gradients of matrices that many times share: rows wait until one product is worth its while.

use faer::Accum;

use super::Buffers;
use super::outer::{OuterProducts, Take, Terms};
use crate::Gradients;
use crate::gnn::Shape;
use crate::values::Real;

/// Inputs and derivatives of outputs of the maps with each matrix, waiting to be multiplied.
///
/// `W̄ = Σ_t inputs_tᵀ d_outputs_t` is then one product of many rows instead of a sum of as many matrices, and is formed when somebody
/// wants it, who may have it piece by piece.
pub(crate) struct Waiting<T> {
    /// By the index of the matrix.
    matrices: Vec<Pile<T>>,
}

/// What waits for one matrix.
struct Pile<T> {
    shape: Shape,
    /// A term for each eigenvalue; a single one for an affine map.
    terms: Vec<Terms<T>>,
}

/// From this many rows on a product is worth its while, and memory stays bounded however long the sequence.
const ENOUGH: usize = 2048;

impl<T: Real> Waiting<T> {
    pub(crate) fn none(matrices: usize) -> Self {
        let nothing = || Pile { shape: Shape { inputs: 0, outputs: 0, taps: 0 }, terms: Vec::new() };
        Waiting { matrices: (0..matrices).map(|_| nothing()).collect() }
    }

    /// Adds the rows of one affine map.
    pub(super) fn push(
        &mut self,
        index: usize,
        [inputs, outputs]: [usize; 2],
        (of_inputs, d_outputs): (&[T], &[T]),
        buffers: &mut Buffers<T>,
        gradients: &mut Gradients,
    ) {
        let shape = Shape { inputs, outputs, taps: 1 };
        self.push_all(index, shape, std::iter::once((T::ONE, of_inputs, d_outputs)), buffers, gradients);
    }

    /// Adds the rows of maps that differ by their eigenvalues: each of these with what comes in and the derivative of what goes out.
    pub(super) fn push_all<'a>(
        &mut self,
        index: usize,
        shape: Shape,
        new: impl Iterator<Item = (T, &'a [T], &'a [T])>,
        buffers: &mut Buffers<T>,
        gradients: &mut Gradients,
    ) {
        let pile = &mut self.matrices[index];
        // The way in which a filter is computed may change with the number of rows.
        if pile.shape != shape {
            pile.multiply_if(1, index, buffers, gradients);
            *pile = Pile { shape, terms: Vec::new() };
        }
        for (number, (eigenvalue, inputs, d_outputs)) in new.enumerate() {
            if number == pile.terms.len() {
                pile.terms.push(Terms { eigenvalue, inputs: Vec::new(), d_outputs: Vec::new() });
            }
            pile.terms[number].inputs.extend_from_slice(inputs);
            pile.terms[number].d_outputs.extend_from_slice(d_outputs);
        }
        pile.multiply_if(ENOUGH, index, buffers, gradients);
    }

    /// Multiplies all that waits.
    pub(crate) fn multiply(&mut self, buffers: &mut Buffers<T>, gradients: &mut Gradients) {
        for index in 0..self.matrices.len() {
            self.multiply_one(index, buffers, gradients);
        }
    }

    /// Multiplies what waits for a matrix.
    pub(crate) fn multiply_one(&mut self, index: usize, buffers: &mut Buffers<T>, gradients: &mut Gradients) {
        self.matrices[index].multiply_if(1, index, buffers, gradients);
    }

    /// Multiplies what waits for a matrix and hands the product over in parts.
    pub(crate) fn hand_over(&mut self, index: usize, buffers: &mut Buffers<T>, take: Take<'_, T>) {
        let pile = &mut self.matrices[index];
        if pile.rows() > 0 {
            T::outer(&OuterProducts { shape: pile.shape, terms: &pile.terms }, buffers, take);
            pile.clear();
        }
    }

    /// Forgets all that waits.
    pub(crate) fn clear(&mut self) {
        self.matrices.iter_mut().for_each(Pile::clear);
    }
}

impl<T: Real> Pile<T> {
    /// Of each term.
    fn rows(&self) -> usize {
        self.terms.first().map_or(0, |term| term.inputs.len() / self.shape.inputs)
    }

    /// The memory is kept.
    fn clear(&mut self) {
        for term in &mut self.terms {
            term.inputs.clear();
            term.d_outputs.clear();
        }
    }

    /// Adds to the gradient if there are at least this many rows.
    fn multiply_if(
        &mut self,
        enough: usize,
        index: usize,
        buffers: &mut Buffers<T>,
        gradients: &mut Gradients,
    ) {
        if self.rows() < enough {
            return;
        }
        let (place, accum) = gradients.place::<T>(index);
        T::outer(&OuterProducts { shape: self.shape, terms: &self.terms }, buffers, &mut |at, values| {
            let place = &mut place[at..at + values.len()];
            match accum {
                Accum::Replace => place.copy_from_slice(values),
                Accum::Add => place.iter_mut().zip(values).for_each(|(sum, term)| *sum += *term),
            }
        });
        self.clear();
    }
}
