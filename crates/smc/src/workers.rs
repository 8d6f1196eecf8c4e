//! The threads of a bank of filters.

use rayon_core::{ThreadPool, ThreadPoolBuilder};

use crate::FilterError;

/// One thread, the caller's, or several that wait for work.
pub(crate) struct Workers(Option<ThreadPool>);

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

    /// How many threads work at once.
    pub(crate) fn threads(&self) -> usize {
        self.0.as_ref().map_or(1, ThreadPool::current_num_threads)
    }

    /// Does both, the second on another thread if one is idle.
    pub(crate) fn join(&self, a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
        match &self.0 {
            None => {
                a();
                b();
            }
            Some(pool) => {
                pool.join(a, b);
            }
        }
    }
}
