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

    /// Starts `threads` threads, unless one is asked for.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if there is to be none, or the system refuses to start them.
    pub(crate) fn new(threads: usize) -> Result<Self, FilterError> {
        let refuse = |value: String, expected| {
            Err(FilterError::Setting { name: "the number of threads of a bank", value, expected })
        };
        match threads {
            0 => refuse("0".into(), "at least 1"),
            1 => Ok(Workers(None)),
            _ => match ThreadPoolBuilder::new().num_threads(threads).build() {
                Ok(pool) => Ok(Workers(Some(pool))),
                Err(error) => refuse(format!("{threads} ({error})"), "one that the system can start"),
            },
        }
    }

    /// Lets every thread allocate scratch now, of which some might else need it first in the midst of a sequence.
    pub(crate) fn reserve_scratch(&self, len: usize) {
        if let Some(pool) = &self.0 {
            pool.broadcast(|_| reserve_scratch(NESTED, len));
        }
    }

    /// Does all of this on the threads, if it is about particles enough: within, they wait for each other's work awake.
    pub(crate) fn gather(&self, particles: usize, work: impl FnOnce(&Workers) + Send) {
        match &self.0 {
            Some(pool) if particles >= WORTH => pool.install(|| work(self)),
            _ => work(&Workers(None)),
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
