//! Long work: on threads of its own, without Python's lock, and until somebody presses Ctrl-C.

use std::any::Any;
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use motes::thread_pool;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon_core::ThreadPool;

use crate::errors::to_python;

/// How often signals are looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Whether work was asked to stop.
pub(crate) struct Stop(AtomicBool);

impl Stop {
    /// What a function of `motes` is told when it asks whether to go on.
    pub(crate) fn asked(&self) -> ControlFlow<()> {
        match self.0.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

/// Does `work` on so many threads, all that there are if `None`.
///
/// # Errors
/// What a signal handler raised, as `KeyboardInterrupt`; `RuntimeError` where the work panicked, which is a defect of ours.
pub(crate) fn without_lock<R: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce(&Stop) -> R + Send,
) -> PyResult<R> {
    let pool = pool(threads)?;
    let stop = Stop(AtomicBool::new(false));
    let (done, raised) = py.detach(|| {
        let (sender, receiver) = channel();
        let stop = &stop;
        pool.in_place_scope(|scope| {
            scope.spawn(move |_| {
                // Nobody listens any more only if this scope is gone.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(stop))));
            });
            let mut raised = None;
            loop {
                match receiver.recv_timeout(LOOK_EVERY) {
                    Ok(done) => return (Some(done), raised),
                    Err(RecvTimeoutError::Disconnected) => return (None, raised),
                    // Only Python's main thread has signals; in others this finds none.
                    Err(RecvTimeoutError::Timeout) if raised.is_none() => {
                        if let Err(error) = Python::attach(|py| py.check_signals()) {
                            raised = Some(error);
                            stop.0.store(true, Ordering::Relaxed);
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                }
            }
        })
    });
    match (raised, done) {
        (Some(error), _) => Err(error),
        (None, Some(Ok(result))) => Ok(result),
        (None, Some(Err(panic))) => {
            Err(PyRuntimeError::new_err(format!("a defect of motes: {}", said(&*panic))))
        }
        (None, None) => Err(PyRuntimeError::new_err("a defect of motes: the work ended without a result")),
    }
}

/// The words of a panic.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without words")
}

/// Pools by their number of threads, and the process that has those threads.
type Pools = (u32, HashMap<Option<usize>, Arc<ThreadPool>>);

static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// A pool of so many threads, kept for later calls.
fn pool(threads: Option<usize>) -> PyResult<Arc<ThreadPool>> {
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    // A process that was forked has none of its parent's threads.
    let process = std::process::id();
    let of_process = match &mut *pools {
        Some((owner, pools)) if *owner == process => pools,
        other => {
            // Pools of a parent are left alone: to drop them would be to wait for threads that are not there.
            std::mem::forget(other.take());
            &mut other.insert((process, HashMap::new())).1
        }
    };
    if let Some(pool) = of_process.get(&threads) {
        return Ok(Arc::clone(pool));
    }
    let pool = Arc::new(thread_pool(threads).map_err(to_python)?);
    of_process.insert(threads, Arc::clone(&pool));
    Ok(pool)
}
