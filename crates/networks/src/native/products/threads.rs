//! Large products on several threads, each of which computes some columns of the result.

use rayon_core::{current_num_threads, join};

use super::matrix::Task;
use super::tiles::WIDEST;
use crate::native::buffers::Buffers;

/// The fewest multiplications for each thread: they take it most of a millisecond, and waking it a few hundredths of that.
const FOR_EACH: usize = 1 << 25;

/// What computes a task; a column may not depend on which others it is computed with.
pub(super) type Kernel = fn(Task<'_>, &mut Buffers<f32>);

/// Computes a task on the calling thread, or, if there is enough to do, on all threads of the rayon pool that it is in, or of the global one.
/// As with any `join`, a thread of a pool may do other work of the pool while it waits.
pub(super) fn share(task: Task<'_>, kernel: Kernel, buffers: &mut Buffers<f32>) {
    let worthwhile = task.sizes().into_iter().fold(1_usize, usize::saturating_mul) / FOR_EACH;
    let parts = if worthwhile > 1 { worthwhile.min(current_num_threads()) } else { 1 };
    in_parts(parts, task, kernel, buffers);
}

/// Computes a task in so many parts, as wide as each other but for whole panels: half a panel costs as much as a whole one.
fn in_parts(parts: usize, task: Task<'_>, kernel: Kernel, buffers: &mut Buffers<f32>) {
    let half = parts / 2;
    let columns = task.out.ncols() * half / parts.max(1) / WIDEST * WIDEST;
    if columns == 0 {
        return kernel(task, buffers);
    }
    let [left, right] = task.split(columns);
    let mut others = buffers.take_others();
    join(|| in_parts(half, left, kernel, buffers), || in_parts(parts - half, right, kernel, &mut others));
    buffers.put_others(others);
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::{Duration, Instant};

    use faer::{Accum, MatMut};
    use rayon_core::ThreadPoolBuilder;

    use super::super::matrix::{Columns, Factor, row};
    use super::*;

    /// What a kernel writes into the first row of a product that so many threads share.
    fn first_row(threads: usize, sizes: [usize; 3], kernel: Kernel) -> Vec<f32> {
        let [rows, inner, columns] = sizes;
        let mut out = vec![0.0; rows * columns];
        let b = vec![0.0; columns];
        let of = |values| Factor { lies: Columns { values, stride: columns }, transposed: false };
        let out_rows = MatMut::from_row_major_slice_mut(&mut out, rows, columns);
        let task = Task { out: out_rows, accum: Accum::Replace, a: of(&[]), b: of(&b), inner };
        let work = || share(task, kernel, &mut Buffers::default());
        ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work);
        out.truncate(columns);
        out
    }

    /// The widths of parts.
    fn parts(threads: usize, sizes: [usize; 3]) -> Vec<usize> {
        let told = first_row(threads, sizes, |mut task, _| {
            let columns = task.out.ncols() as f32;
            row(&mut task.out, 0).fill(columns);
        });
        let (mut widths, mut column) = (Vec::new(), 0);
        while column < told.len() {
            widths.push(told[column] as usize);
            column += told[column] as usize;
        }
        widths
    }

    #[test]
    fn threads_of_a_pool_share_what_is_worth_it() {
        let large = [100, 1024, 1000];
        assert_eq!(parts(1, large), [1000]);
        assert_eq!(parts(2, large), [480, 520]);
        assert_eq!(parts(3, large), [320, 320, 360]);
        assert_eq!(parts(3, [63, 1024, 1024]), [1024], "too little for two");
        assert_eq!(parts(3, [100_000, 100, 40]), [40], "too few columns for two");
    }

    #[test]
    fn parts_are_computed_at_the_same_time() {
        static ARRIVED: AtomicUsize = AtomicUsize::new(0);
        let met = first_row(3, [100, 1024, 1000], |mut task, _| {
            ARRIVED.fetch_add(1, Ordering::SeqCst);
            let start = Instant::now();
            while ARRIVED.load(Ordering::SeqCst) < 3 && start.elapsed() < Duration::from_secs(20) {
                std::thread::yield_now();
            }
            let met = ARRIVED.load(Ordering::SeqCst) as f32;
            row(&mut task.out, 0).fill(met);
        });
        assert_eq!(met, [3.0; 1000]);
    }
}
