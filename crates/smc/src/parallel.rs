//! Work shared by the threads of the ambient rayon pool: the one that the caller is in, or the global one.
//!
//! Who wants a filter on one thread, or on two, calls it in a pool of as many. Nothing here decides by a clock, and no result depends on threads.

use motes_models::batch::reserve_scratch;
use rayon_core::{current_num_threads, current_thread_index, join, scope};

/// For fewer particles than this a thread that sleeps takes longer to wake than to help.
const WORTH_WAKING: usize = 2048;

/// Scratch that a step uses at the same time on one thread.
const NESTED: usize = 5;

/// Consecutive pieces of work that do not depend on each other.
pub(crate) trait Pieces: Send + Sized {
    /// How many there are.
    fn count(&self) -> usize;

    /// The first `pieces` of them, and the others.
    fn split(self, pieces: usize) -> (Self, Self);
}

/// Whether work may be shared.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Threads {
    /// The calling one does all of it.
    One,
    /// Those of the pool that the calling one is in.
    OfPool,
}

impl Threads {
    /// Does all pieces, at least `grain` of them at a time, on any thread that has time.
    pub(crate) fn share<P: Pieces>(self, pieces: P, grain: usize, work: &(impl Fn(P) + Sync)) {
        if self == Threads::OfPool && pieces.count() >= grain.max(1).saturating_mul(2) {
            let half = pieces.count() / 2;
            let (left, right) = pieces.split(half);
            join(|| self.share(left, grain, work), || self.share(right, grain, work));
        } else {
            work(pieces);
        }
    }
}

/// Does a step of `particles` particles: on the threads of the pool if the caller is in one, or if it is worth waking them.
pub(crate) fn step(particles: usize, work: impl FnOnce(Threads) + Send) {
    let is_outside = current_thread_index().is_none();
    if (is_outside && particles < WORTH_WAKING) || current_num_threads() < 2 {
        work(Threads::One);
    } else if is_outside {
        scope(|_| work(Threads::OfPool));
    } else {
        work(Threads::OfPool);
    }
}

/// Does a whole sequence of steps in the pool, whose threads then wait for each other's work awake.
pub(crate) fn sequence<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    if current_thread_index().is_some() || current_num_threads() < 2 { work() } else { scope(|_| work()) }
}

/// Allocates `scratch` numbers on the calling thread, because it might otherwise need them first in the midst of a sequence. Other threads allocate
/// theirs when they first help: to wait for them could be to wait for work that waits for this.
pub(crate) fn reserve(scratch: usize) {
    reserve_scratch(NESTED, scratch);
}
