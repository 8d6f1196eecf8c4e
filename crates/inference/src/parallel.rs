//! Independent pieces of work on the threads of the ambient pool.

use rayon_core::join;

/// What `work` makes of each item and its number, in their order, whatever thread did it: a piece that takes its random numbers from its number gives the same on any
/// number of threads.
///
/// ```
/// use motes_inference::map_on_threads;
///
/// assert_eq!(map_on_threads(&[3, 1, 2], |number, item| number + item), [3, 2, 4]);
/// ```
pub fn map_on_threads<T: Sync, R: Send>(items: &[T], work: impl Fn(usize, &T) -> R + Sync) -> Vec<R> {
    map_from(0, items, &work)
}

/// [`map_on_threads`] of items of which the first has this number.
fn map_from<T: Sync, R: Send>(first: usize, items: &[T], work: &(impl Fn(usize, &T) -> R + Sync)) -> Vec<R> {
    match items {
        [] => Vec::new(),
        [one] => vec![work(first, one)],
        _ => {
            let half = items.len() / 2;
            let (left, right) = items.split_at(half);
            let (mut done, rest) =
                join(|| map_from(first, left, work), || map_from(first + half, right, work));
            done.extend(rest);
            done
        }
    }
}
