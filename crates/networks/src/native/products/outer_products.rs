//! Sums of outer products: what the gradient of a matrix of weights is.

use crate::graph::Shape;

/// Rows of inputs and of derivatives of outputs of maps with the same matrix, one after another.
#[derive(Debug, Clone, Default)]
pub(crate) struct Terms<T> {
    /// Of a graph filter in the basis of its eigenvectors; of an affine map any.
    pub(crate) eigenvalue: T,
    pub(crate) inputs: Vec<T>,
    pub(crate) d_outputs: Vec<T>,
}

/// `W̄_d = Σ_i λ_i^d X_iᵀ Ȳ_i` for each tap `d`, on top of each other; the matrix of an affine map has one tap and one `i`.
pub(crate) struct OuterProducts<'a, T> {
    pub(crate) shape: Shape,
    pub(crate) terms: &'a [Terms<T>],
}

impl<T> OuterProducts<'_, T> {
    /// The term, if these are the sums of an affine map.
    pub(crate) fn affine(&self) -> Option<&Terms<T>> {
        match self.terms {
            [term] if self.shape.taps == 1 => Some(term),
            _ => None,
        }
    }
}

/// What takes parts of a matrix: where a part begins, and the numbers from there on.
pub(crate) type Take<'a, T> = &'a mut dyn FnMut(usize, &[T]);
