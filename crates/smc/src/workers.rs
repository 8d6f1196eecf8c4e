//! The threads of a bank of filters, and how they share work.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use motes_models::batch::reserve_scratch;
use rayon_core::{ThreadPool, ThreadPoolBuilder};

use crate::FilterError;

/// For fewer particles than this a thread that sleeps takes longer to wake than to help.
const WORTH: usize = 2048;

/// Scratch that a step uses at the same time on one thread.
const NESTED: usize = 5;

/// Threads that wait for work, by how many they are. Started once: banks come and go faster than threads start.
static POOLS: Mutex<BTreeMap<usize, Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());

/// One thread, the caller's, or several.
#[derive(Clone)]
pub(crate) struct Workers {
    pool: Option<Arc<ThreadPool>>,
    /// Whether a step is worth waking them.
    worth: bool,
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
        Workers { pool: None, worth: false }
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
        if threads == 0 {
            return refuse("0".into(), "at least 1");
        }
        if threads == 1 {
            return Ok(Workers::none());
        }
        let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
        let pool = match pools.get(&threads) {
            Some(pool) => Arc::clone(pool),
            None => match ThreadPoolBuilder::new().num_threads(threads).build() {
                Ok(pool) => Arc::clone(pools.entry(threads).or_insert(Arc::new(pool))),
                Err(error) => {
                    return refuse(format!("{threads} ({error})"), "one that the system can start");
                }
            },
        };
        drop(pools);
        pool.broadcast(|_| reserve_scratch(NESTED, scratch));
        Ok(Workers { pool: Some(pool), worth: particles >= WORTH })
    }

    /// Does all of this on the threads: within, they wait for each other's work awake.
    pub(crate) fn together<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Does a step on the threads, if they are awake or it is worth waking them.
    pub(crate) fn step(&self, work: impl FnOnce(&Workers) + Send) {
        match &self.pool {
            Some(pool) if self.worth || pool.current_thread_index().is_some() => {
                pool.install(|| work(self));
            }
            _ => work(&Workers::none()),
        }
    }

    /// Does all pieces, at least `grain` of them at a time, on any thread that has time.
    pub(crate) fn share<P: Pieces>(&self, pieces: P, grain: usize, work: &(impl Fn(P) + Sync)) {
        match &self.pool {
            Some(pool) if pieces.count() >= 2 * grain.max(1) => {
                let half = pieces.count() / 2;
                let (left, right) = pieces.split(half);
                pool.join(|| self.share(left, grain, work), || self.share(right, grain, work));
            }
            _ => work(pieces),
        }
    }
}
