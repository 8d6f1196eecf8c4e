//! Products with a matrix for each eigenvalue of a graph, `W(λ) = Σ_d λ^d W_d`.

use crate::graph::Shape;

/// `out_i = a_i W(λ_i)`, or `out_i = a_i W(λ_i)ᵀ`, where rows of each eigenvalue come after those of the one before.
pub(crate) struct EigenProducts<'a, T> {
    /// `W_d` on top of each other.
    pub(crate) taps: &'a [T],
    pub(crate) shape: Shape,
    /// Whether `W(λ_i)` is transposed.
    pub(crate) transposed: bool,
    pub(crate) eigenvalues: &'a [T],
    pub(crate) a: &'a [T],
    pub(crate) out: &'a mut [T],
}

impl<T> EigenProducts<'_, T> {
    /// Rows of each eigenvalue, terms of a sum, columns of a result.
    pub(super) fn sizes(&self) -> [usize; 3] {
        let Shape { inputs, outputs, .. } = self.shape;
        let [inner, columns] = if self.transposed { [outputs, inputs] } else { [inputs, outputs] };
        [self.a.len() / self.eigenvalues.len() / inner, inner, columns]
    }
}
