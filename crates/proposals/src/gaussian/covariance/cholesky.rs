//! Cholesky factorisation in place, with its scratch space kept.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltRegularization, cholesky_in_place, cholesky_in_place_scratch};
use faer::{MatMut, Par, Spec};

/// The scratch space for factoring matrices of one size.
pub(super) struct Cholesky {
    scratch: MemBuffer,
}

impl Cholesky {
    pub(super) fn new(width: usize) -> Self {
        let needed = cholesky_in_place_scratch::<f64>(width, Par::Seq, Spec::default());
        Cholesky { scratch: MemBuffer::new(needed) }
    }

    /// Replaces a symmetric matrix (its lower triangle is read) by its lower factor, zeros above the diagonal.
    pub(super) fn factor_in_place(&mut self, mut matrix: MatMut<'_, f64>) -> Result<(), String> {
        let n = matrix.nrows();
        if (0..n).any(|j| (j..n).any(|i| !matrix[(i, j)].is_finite())) {
            return Err("the network's output is not finite".into());
        }
        let stack = MemStack::new(&mut self.scratch);
        let regularization = LltRegularization::default();
        cholesky_in_place(matrix.as_mut(), regularization, Par::Seq, stack, Spec::default())
            .map_err(|_| "it is not positive definite".to_string())?;
        for j in 1..n {
            for i in 0..j {
                matrix[(i, j)] = 0.0;
            }
        }
        Ok(())
    }
}
