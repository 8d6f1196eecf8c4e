//! How many repetitions points have, where these are not all.

use std::collections::{BTreeMap, BTreeSet};

/// The number of repetitions of each series of points that has the same everywhere, but not `all`: said once. `points` are of a series and its repetitions.
pub(super) fn uniform<S: Ord>(points: impl Iterator<Item = (S, usize)>, all: usize) -> BTreeMap<S, usize> {
    let mut counts: BTreeMap<S, BTreeSet<usize>> = BTreeMap::new();
    for (series, repetitions) in points {
        counts.entry(series).or_default().insert(repetitions);
    }
    let one = |counts: BTreeSet<usize>| match counts.len() {
        1 => counts.first().copied().filter(|repetitions| *repetitions != all),
        _ => None,
    };
    counts.into_iter().filter_map(|(series, counts)| Some((series, one(counts)?))).collect()
}

/// For each x at which several points stand and none has `all` repetitions: the number that most of them have, the larger of two as
/// frequent. One label does for those, and what has another number needs a label of its own. `points` are of x and repetitions.
pub(super) fn shared(points: impl Iterator<Item = (usize, usize)>, all: usize) -> BTreeMap<usize, usize> {
    let mut counts: BTreeMap<usize, BTreeMap<usize, usize>> = BTreeMap::new();
    for (x, repetitions) in points {
        *counts.entry(x).or_default().entry(repetitions).or_default() += 1;
    }
    let most = |counts: BTreeMap<usize, usize>| {
        if counts.contains_key(&all) {
            return None;
        }
        let (repetitions, points) =
            counts.into_iter().max_by_key(|&(repetitions, points)| (points, repetitions))?;
        (points > 1).then_some(repetitions)
    };
    counts.into_iter().filter_map(|(x, counts)| Some((x, most(counts)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::{shared, uniform};

    #[test]
    fn one_label_does_for_what_all_others_have() {
        let points = [
            [(10, 11), (10, 3), (10, 11)].as_slice(), // one has fewer: it is labelled, the others together
            &[(20, 11), (20, 11), (20, 20)],          // what has no label has all repetitions
            &[(30, 4)],
            &[(40, 5), (40, 6)],
        ];
        let found = shared(points.concat().into_iter(), 20);
        assert_eq!(found.into_iter().collect::<Vec<_>>(), [(10, 11)]);
    }

    #[test]
    fn what_is_the_same_everywhere_is_said_once() {
        let points = [("a", 20), ("a", 20), ("b", 5), ("b", 5), ("c", 5), ("c", 20)];
        let found = uniform(points.into_iter(), 20);
        assert_eq!(found.into_iter().collect::<Vec<_>>(), [("b", 5)]);
    }
}
