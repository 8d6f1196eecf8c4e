//! The threads of a bank of filters, and how they share work.

use std::sync::{Arc, Mutex, PoisonError};

use motes_models::batch::reserve_scratch;
use rayon_core::{ThreadPool, ThreadPoolBuilder};

use crate::FilterError;

/// For fewer particles than this a thread that sleeps takes longer to wake than to help.
const WORTH_WAKING: usize = 2048;

/// Scratch that a step uses at the same time on one thread.
const NESTED: usize = 5;

/// Threads that no bank has at present: banks come and go faster than threads start.
static IDLE: Mutex<Vec<ThreadPool>> = Mutex::new(Vec::new());

/// Threads that one bank has, until it is dropped.
struct Lent(Option<ThreadPool>);

impl Lent {
    /// So many threads that nobody else has.
    fn take(threads: usize) -> Result<Self, rayon_core::ThreadPoolBuildError> {
        let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
        let found = idle.iter().position(|pool| pool.current_num_threads() == threads);
        if let Some(found) = found {
            return Ok(Lent(Some(idle.swap_remove(found))));
        }
        drop(idle);
        ThreadPoolBuilder::new().num_threads(threads).build().map(|pool| Lent(Some(pool)))
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        IDLE.lock().unwrap_or_else(PoisonError::into_inner).extend(self.0.take());
    }
}

/// One thread, the caller's, or several.
#[derive(Clone)]
pub(crate) struct Workers {
    lent: Option<Arc<Lent>>,
    /// Whether a step is worth waking them.
    worth_waking: bool,
}

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
        Workers { lent: None, worth_waking: false }
    }

    /// `threads` threads for that many particles. Each allocates `scratch` numbers now, because it might otherwise need them first in the
    /// midst of a sequence.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if there is to be none, or the system refuses to start them.
    pub(crate) fn new(threads: usize, particles: usize, scratch: usize) -> Result<Self, FilterError> {
        let refuse = |value: String, expected| {
            Err(FilterError::Setting { name: "the number of threads of a bank", value, expected })
        };
        match threads {
            0 => refuse("0".into(), "at least 1"),
            1 => Ok(Workers::none()),
            _ => match Lent::take(threads) {
                Ok(lent) => {
                    let workers =
                        Workers { lent: Some(Arc::new(lent)), worth_waking: particles >= WORTH_WAKING };
                    if let Some(pool) = workers.pool() {
                        pool.broadcast(|_| reserve_scratch(NESTED, scratch));
                    }
                    Ok(workers)
                }
                Err(error) => refuse(format!("{threads} ({error})"), "one that the system can start"),
            },
        }
    }

    fn pool(&self) -> Option<&ThreadPool> {
        self.lent.as_ref().and_then(|lent| lent.0.as_ref())
    }

    /// Allocates `scratch` numbers on the thread that calls, for the reason that [`Workers::new`] gives.
    pub(crate) fn reserve(scratch: usize) {
        reserve_scratch(NESTED, scratch);
    }

    /// Does all of this on the threads: within, they wait for each other's work awake.
    pub(crate) fn together<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match self.pool() {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Does a step on the threads, if they are awake or it is worth waking them.
    pub(crate) fn step(&self, work: impl FnOnce(&Workers) + Send) {
        match self.pool() {
            Some(pool) if self.worth_waking || pool.current_thread_index().is_some() => {
                pool.install(|| work(self));
            }
            _ => work(&Workers::none()),
        }
    }

    /// Does all pieces, at least `grain` of them at a time, on any thread that has time.
    pub(crate) fn share<P: Pieces>(&self, pieces: P, grain: usize, work: &(impl Fn(P) + Sync)) {
        match self.pool() {
            Some(pool) if pieces.count() >= 2 * grain.max(1) => {
                let half = pieces.count() / 2;
                let (left, right) = pieces.split(half);
                pool.join(|| self.share(left, grain, work), || self.share(right, grain, work));
            }
            _ => work(pieces),
        }
    }
}
