//! The threads of a bank of filters, and how they share work.

use motes_models::batch::reserve_scratch;
use rayon_core::{ThreadPool, ThreadPoolBuilder};

use crate::FilterError;

/// For fewer particles than this another thread takes longer to wake than to help.
const WORTH: usize = 2048;

/// Scratch that a step uses at the same time on one thread.
const NESTED: usize = 5;

/// One thread, the caller's, or several that wait for work.
pub(crate) struct Workers(Option<ThreadPool>);

/// Consecutive pieces of work that do not depend on each other.
pub(crate) trait Pieces: Send + Sized {
    /// How many there are.
    fn count(&self) -> usize;

    /// The first `pieces` of them, and the others.
    fn split(self, pieces: usize) -> (Self, Self);
}

impl Workers {
    /// Work stays on the thread that asks for it.
    pub(crate) fn none() -> Self {
        Workers(None)
    }

    /// Starts `threads` threads, unless one is asked for or there are fewer particles than are worth another. Each allocates `scratch`
    /// numbers now, because it might otherwise need them first in the midst of a sequence.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if there is to be none, or the system refuses to start them.
    pub(crate) fn new(threads: usize, particles: usize, scratch: usize) -> Result<Self, FilterError> {
        let refuse = |value: String, expected| {
            Err(FilterError::Setting { name: "the number of threads of a bank", value, expected })
        };
        match threads {
            0 => refuse("0".into(), "at least 1"),
            _ if threads == 1 || particles < WORTH => Ok(Workers(None)),
            _ => match ThreadPoolBuilder::new().num_threads(threads).build() {
                Ok(pool) => {
                    pool.broadcast(|_| reserve_scratch(NESTED, scratch));
                    Ok(Workers(Some(pool)))
                }
                Err(error) => refuse(format!("{threads} ({error})"), "one that the system can start"),
            },
        }
    }

    /// Does all of this on the threads: within, they wait for each other's work awake.
    pub(crate) fn gather(&self, work: impl FnOnce(&Workers) + Send) {
        match &self.0 {
            Some(pool) => pool.install(|| work(self)),
            None => work(self),
        }
    }

    /// Does all pieces, at least `grain` of them at a time, on any thread that has time.
    pub(crate) fn share<P: Pieces>(&self, pieces: P, grain: usize, work: &(impl Fn(P) + Sync)) {
        match &self.0 {
            Some(pool) if pieces.count() >= 2 * grain.max(1) => {
                let half = pieces.count() / 2;
                let (left, right) = pieces.split(half);
                pool.join(|| self.share(left, grain, work), || self.share(right, grain, work));
            }
            _ => work(pieces),
        }
    }
}
