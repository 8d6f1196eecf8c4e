//! Large products on several threads, each of which computes some columns of the result.

use faer::{Accum, MatMut};
use rayon_core::{current_num_threads, current_thread_index, join};

use super::Buffers;
use super::panels::WIDEST;
use super::products::{Columns, Factor};

/// The fewest multiplications for each thread: they take it most of a millisecond, and waking it a few hundredths of that.
const FOR_EACH: usize = 1 << 25;

/// `out = a b`, or `out += a b`, of single precision and not of few rows.
pub(super) struct Task<'a> {
    /// Each row is contiguous.
    pub(super) out: MatMut<'a, f32>,
    pub(super) accum: Accum,
    pub(super) a: Factor<'a>,
    pub(super) b: Factor<'a>,
    /// The terms of each sum.
    pub(super) inner: usize,
}

impl<'a> Task<'a> {
    /// `[rows, terms of each sum, columns of the result]`.
    pub(super) fn sizes(&self) -> [usize; 3] {
        [self.out.nrows(), self.inner, self.out.ncols()]
    }

    /// The first `columns` of the result, and the others.
    fn split(self, columns: usize) -> [Self; 2] {
        let Task { out, accum, a, b, inner } = self;
        let Factor { lies: Columns { values, stride }, transposed } = b;
        let (left, right) = out.split_at_col_mut(columns);
        let first = if transposed { columns * stride } else { columns };
        let others = Factor { lies: Columns { values: &values[first..], stride }, transposed };
        [Task { out: left, accum, a, b, inner }, Task { out: right, accum, a, b: others, inner }]
    }
}

/// A row of what a task is to write.
#[inline(always)]
pub(super) fn row<'a>(out: &'a mut MatMut<'_, f32>, row: usize) -> &'a mut [f32] {
    let row = out.as_mut().row_mut(row).try_as_row_major_mut();
    row.expect("each row of a task is contiguous").as_slice_mut()
}

/// What computes a task; a column may not depend on which others it is computed with.
pub(super) type Kernel = fn(Task<'_>, &mut Buffers<f32>);

/// Computes a task on the calling thread, or, if that is one of a rayon pool and there is enough to do, on all threads of the pool.
pub(super) fn share(task: Task<'_>, kernel: Kernel, buffers: &mut Buffers<f32>) {
    let threads = if current_thread_index().is_some() { current_num_threads() } else { 1 };
    let multiplications = task.sizes().into_iter().fold(1_usize, usize::saturating_mul);
    in_parts(threads.min(multiplications / FOR_EACH), task, kernel, buffers);
}

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
    use std::thread::sleep;
    use std::time::Duration;

    use rayon_core::ThreadPoolBuilder;

    use super::*;

    /// Writes how many columns it was asked for into the first number of each, and its thread into the second.
    fn tell(mut task: Task<'_>, _: &mut Buffers<f32>) {
        let columns = task.out.ncols() as f32;
        row(&mut task.out, 0).fill(columns);
        row(&mut task.out, 1).fill(current_thread_index().map_or(-1.0, |index| index as f32));
        // Long enough for the others to come.
        sleep(Duration::from_millis(100));
    }

    /// The widths of parts, and how many threads they were on.
    fn parts(threads: Option<usize>, [rows, inner, columns]: [usize; 3]) -> (Vec<usize>, usize) {
        let mut out = vec![0.0; rows * columns];
        let mut work = || {
            let nothing = Factor { lies: Columns { values: &[], stride: 0 }, transposed: false };
            let out = MatMut::from_row_major_slice_mut(&mut out, rows, columns);
            let b = vec![0.0; columns];
            let b = Factor { lies: Columns { values: &b, stride: columns }, transposed: false };
            let task = Task { out, accum: Accum::Replace, a: nothing, b, inner };
            share(task, tell, &mut Buffers::default());
        };
        match threads {
            Some(threads) => ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work),
            None => work(),
        }
        let (mut widths, mut column) = (Vec::new(), 0);
        while column < columns {
            widths.push(out[column] as usize);
            column += out[column] as usize;
        }
        let mut seen = out[columns..2 * columns].to_vec();
        seen.sort_by(f32::total_cmp);
        seen.dedup();
        (widths, seen.len())
    }

    #[test]
    fn threads_of_a_pool_share_what_is_worth_it() {
        let large = [100, 1024, 1000];
        assert_eq!(parts(None, large), (vec![1000], 1), "outside of a pool");
        assert_eq!(parts(Some(1), large), (vec![1000], 1));
        assert_eq!(parts(Some(2), large), (vec![480, 520], 2));
        assert_eq!(parts(Some(3), large), (vec![320, 320, 360], 3));
        assert_eq!(parts(Some(3), [63, 1024, 1024]), (vec![1024], 1), "too little for two");
        assert_eq!(parts(Some(3), [100_000, 100, 40]), (vec![40], 1), "too few columns for two");
    }
}
