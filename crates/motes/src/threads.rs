//! Work on a number of threads.

use motes_models::ModelError;

use crate::error::MotesError;

/// Does the work on so many threads, or on all that the machine has. Results are the same by any number.
///
/// # Errors
/// [`MotesError`] if the system does not start so many.
pub fn on_threads<R: Send>(threads: Option<usize>, work: impl FnOnce() -> R + Send) -> Result<R, MotesError> {
    Ok(thread_pool(threads)?.install(work))
}

/// A pool of so many threads, or of all that the machine has: for who keeps one over many calls.
///
/// # Errors
/// [`MotesError`] if the system does not start so many.
pub fn thread_pool(threads: Option<usize>) -> Result<rayon_core::ThreadPool, MotesError> {
    let count = threads.or_else(|| std::thread::available_parallelism().ok().map(usize::from)).unwrap_or(1);
    rayon_core::ThreadPoolBuilder::new().num_threads(count).build().map_err(|error| {
        let expected = "as many as the system starts";
        let value = format!("{count} ({error})");
        MotesError::from(ModelError::Parameter { name: "the number of threads", value, expected })
    })
}
