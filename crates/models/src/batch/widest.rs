//! Work compiled for the widest vectors that the machine has.

use pulp::{Simd, WithSimd};

/// Does `work`, compiled once for each width of vectors: of what it calls, all that the compiler puts in line.
///
/// Nothing is fused or reordered that is not so written, so the numbers are the same by any width.
#[inline(always)]
pub(crate) fn by_widest_vectors(work: impl FnMut()) {
    pulp::Arch::new().dispatch(Work(work));
}

/// A closure that is called by reference: what a closure is called by value through would not be compiled for vectors.
struct Work<F>(F);

impl<F: FnMut()> WithSimd for Work<F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) {
        (self.0)();
    }
}
