//! The threads of a unit: one, or several where there are fewer units than threads.

use rayon_core::{ThreadPoolBuilder, current_num_threads, current_thread_index};

use motes_cli::status;

/// How many of `jobs` threads each of the workers has that evaluate `units` units.
pub(crate) fn of_workers(jobs: usize, units: usize) -> impl Iterator<Item = usize> {
    let workers = jobs.min(units);
    (0..workers).map(move |worker| (jobs + worker) / workers)
}

/// Does the work in a pool of so many threads, which filters and large products find; the calling one is the first of them for good. If the
/// system refuses to start it, says so and does the work where it is.
pub(crate) fn on<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    match ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build() {
        Ok(pool) => pool.install(work),
        Err(error) => {
            status(&format!("a unit has no threads of its own, {threads} were asked for: {error}"));
            work()
        }
    }
}

/// How many threads the calling one can share work with, itself included.
pub(crate) fn here() -> usize {
    current_thread_index().map_or(1, |_| current_num_threads())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workers_have_all_threads_as_evenly_as_can_be() {
        for (jobs, units, expected) in [
            (1, 1, vec![1]),
            (2, 1, vec![2]),
            (2, 9, vec![1, 1]),
            (8, 3, vec![2, 3, 3]),
            (3, 2, vec![1, 2]),
            (2, 0, vec![]),
        ] {
            assert_eq!(
                of_workers(jobs, units).collect::<Vec<_>>(),
                expected,
                "{jobs} threads, {units} units"
            );
        }
    }

    #[test]
    fn work_finds_its_threads() {
        // A thread belongs to its first pool for good.
        for threads in [1, 3] {
            let found = std::thread::spawn(move || on(threads, here)).join().unwrap();
            assert_eq!(found, threads);
        }
    }
}
