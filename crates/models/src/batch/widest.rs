//! Work compiled for the widest vectors that the machine has.

use pulp::{Simd, WithSimd};

/// What `work` gives, compiled once for each width of vectors: of what it calls, all that the compiler puts in line. Mark the closure
/// `#[inline(always)]`.
///
/// Nothing is fused or reordered that is not so written, so the numbers are the same by any width.
#[inline(always)]
pub fn by_widest_vectors<R>(work: impl FnMut() -> R) -> R {
    pulp::Arch::new().dispatch(Work(work))
}

/// A closure that is called by reference. What one is called by value through would be a function of its own, not compiled for vectors.
struct Work<F>(F);

impl<R, F: FnMut() -> R> WithSimd for Work<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) -> R {
        (self.0)()
    }
}
