//! Long work: on threads of its own, without Python's lock, and until somebody presses Ctrl-C.

use std::any::Any;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use motes::thread_pool;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon_core::{ThreadPool, current_thread_index};

use crate::errors::to_python;

/// How often signals are looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Whether work was asked to stop. Clones say the same.
#[derive(Clone, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Whether it was.
    pub(crate) fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Takes it back, once work has ended.
    pub(crate) fn withdraw(&self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

/// Does `work` on so many threads, all that there are if `None`, and sets `stop` when somebody presses Ctrl-C.
///
/// Within other such work, which a function of a model can do, it is done where it is: a pool whose threads wait for each other would wait for ever.
///
/// # Errors
/// What a signal handler raised, as `KeyboardInterrupt`; `RuntimeError` where the work panicked, which is a defect of ours.
pub(crate) fn without_lock<R: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    stop: &Stop,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    if current_thread_index().is_some() {
        return py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| defect(&*panic));
    }
    let pool = pool(threads)?;
    let (done, raised) = py.detach(|| {
        let (sender, receiver) = channel();
        pool.in_place_scope(|scope| {
            scope.spawn(move |_| {
                // Nobody listens any more only if this scope is gone.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
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
        (None, Some(Err(panic))) => Err(defect(&*panic)),
        (None, None) => Err(PyRuntimeError::new_err("a defect of motes: the work ended without a result")),
    }
}

/// A panic, with its words.
fn defect(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    PyRuntimeError::new_err(format!("a defect of motes: {}", text.unwrap_or("a panic without words")))
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
