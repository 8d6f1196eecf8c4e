//! The threads of a unit: one, or several where there are fewer units than threads.

use rayon_core::ThreadPoolBuilder;

/// How many of `jobs` threads each of the workers has that evaluate `units` units.
pub(crate) fn of_workers(jobs: usize, units: usize) -> impl Iterator<Item = usize> {
    let workers = jobs.min(units);
    (0..workers).map(move |worker| (jobs + worker) / workers)
}

/// Does the work on so many threads: those of a pool, which large products find. Without a pool, if the system refuses to start it, it takes longer.
pub(crate) fn on<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads).build().ok()).flatten();
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
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
        let found = || rayon_core::current_thread_index().map(|_| rayon_core::current_num_threads());
        assert_eq!(on(1, found), None);
        assert_eq!(on(3, found), Some(3));
    }
}
