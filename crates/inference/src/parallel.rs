//! Independent pieces of work on the threads of the ambient pool.

use rayon_core::join;

/// What `work` makes of each item, in their order, whatever thread did it.
pub(crate) fn map<T: Sync, R: Send>(items: &[T], work: &(impl Fn(&T) -> R + Sync)) -> Vec<R> {
    match items {
        [] => Vec::new(),
        [one] => vec![work(one)],
        _ => {
            let (left, right) = items.split_at(items.len() / 2);
            let (mut done, rest) = join(|| map(left, work), || map(right, work));
            done.extend(rest);
            done
        }
    }
}
