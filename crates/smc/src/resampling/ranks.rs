//! From cumulative weights to ancestors, without a branch that depends on chance.
//!
//! Walking points and weights side by side costs a mispredicted branch for almost every particle, more than all arithmetic. Here
//! each cumulative weight is asked for its rank among the points, which says where its offspring ends.

/// Places that are written at once; more offspring than that is rare.
const RUN: usize = 8;

/// Writes `value` to the places from `start` to `end`, and perhaps to some behind them.
#[inline(always)]
fn run<T: Copy>(places: &mut [T], start: usize, end: usize, value: T) {
    match places[start..].first_chunk_mut::<RUN>() {
        Some(near) => {
            *near = [value; RUN];
            if end > start + RUN {
                places[start + RUN..end].fill(value);
            }
        }
        None => places[start..end].fill(value),
    }
}

/// Fills `ancestors` with increasing numbers of weights, the first of which has the number `first`, so that `k` descends from the
/// first weight whose cumulative sum, from `before` on, has a rank above `k`; `rank` must increase.
pub(super) fn descend(
    weights: &[f64],
    first: usize,
    before: f64,
    rank: impl Fn(f64) -> usize,
    ancestors: &mut [usize],
) {
    let (mut cumulative, mut start) = (before, 0);
    for (number, weight) in (first..).zip(weights) {
        cumulative += weight;
        let end = rank(cumulative).min(ancestors.len()).max(start);
        run(ancestors, start, end, number);
        start = end;
    }
    // Rounding can leave the whole sum just short of the last point: then the last weight that is not zero goes on.
    if start < ancestors.len() {
        let last = weights.iter().rposition(|weight| *weight > 0.0).unwrap_or_default();
        ancestors[start..].fill(first + last);
    }
}

/// The integer part of a number that is not negative.
#[inline(always)]
fn floor(value: f64) -> usize {
    // Through i64, which is one instruction on any machine.
    value as i64 as usize
}

/// How many of the points `k + offset` lie below `value`, for `k` from 0 to `count − 1`.
#[inline(always)]
pub(super) fn among_regular(value: f64, offset: f64, count: usize) -> usize {
    let above = (value - offset).max(0.0);
    let whole = floor(above);
    (whole + usize::from((whole as f64) < above)).min(count)
}

/// How many of the points `k + offsets[k]` lie below `value`, with offsets in `[0, 1)`.
#[inline(always)]
pub(super) fn among_strata(value: f64, offsets: &[f64]) -> usize {
    let whole = floor(value);
    match offsets.get(whole) {
        Some(offset) => whole + usize::from(*offset < value - whole as f64),
        None => offsets.len(),
    }
}

/// The integer nearest to a number from 0 to 2³².
#[inline(always)]
fn nearest(value: f64) -> usize {
    // Adding 2⁵² leaves the integer in the lowest bits, without the checks of a conversion.
    (value + (1_u64 << 52) as f64).to_bits() as u32 as usize
}

/// Sorted points in `[0, count]`, one in each unit on average, that can be asked for ranks.
pub(super) struct SortedPoints<'a> {
    /// The points, and behind them as many infinite ones as a comparison may reach.
    points: &'a [f64],
    /// For each integer, how many points are nearer to a smaller one.
    below: &'a [f64],
    count: usize,
}

/// Infinite points behind the others.
const SENTINELS: usize = 4;

impl<'a> SortedPoints<'a> {
    /// Numbers of scratch for `count` points.
    pub(super) fn scratch(count: usize) -> usize {
        2 * count + SENTINELS + 2
    }

    /// Takes `count` increasing points at the start of scratch.
    pub(super) fn new(scratch: &'a mut [f64], count: usize) -> Self {
        let (points, below) = scratch[..SortedPoints::scratch(count)].split_at_mut(count + SENTINELS);
        points[count..].fill(f64::INFINITY);
        let mut start = 0;
        for (index, point) in points[..count].iter().enumerate() {
            // The integers up to the nearest one have no more than the points before.
            let end = (nearest(*point).min(count) + 1).max(start);
            run(below, start, end, index as f64);
            start = end;
        }
        below[start..].fill(count as f64);
        SortedPoints { points, below, count }
    }

    /// How many points lie below `value`.
    #[inline(always)]
    pub(super) fn rank(&self, value: f64) -> usize {
        let start = nearest(self.below[nearest(value).min(self.count)]);
        // One point on average is nearest to an integer: three comparisons, and a loop that hardly ever runs.
        let near = &self.points[start..start + 3];
        let mut rank = near.iter().map(|point| usize::from(*point < value)).sum::<usize>();
        if rank == 3 {
            rank += self.points[start + 3..].iter().take_while(|point| **point < value).count();
        }
        start + rank
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motes_models::{Seed, fill_uniform};

    #[test]
    fn ranks_are_those_of_counting() {
        let mut stream = Seed::from_u64(30).stream();
        for count in [1, 2, 7, 40, 300] {
            let (mut scratch, mut offsets) = (vec![0.0; SortedPoints::scratch(count)], vec![0.0; count]);
            fill_uniform(&mut stream, &mut offsets);
            let mut points: Vec<f64> = offsets.iter().map(|u| u * u * count as f64).collect();
            points.sort_by(f64::total_cmp);
            scratch[..count].copy_from_slice(&points);
            let sorted = SortedPoints::new(&mut scratch, count);
            let mut values = vec![0.0; 1000];
            fill_uniform(&mut stream, &mut values);
            values.iter_mut().for_each(|value| *value *= count as f64);
            values.extend(points.iter().chain(&[0.0, count as f64, count as f64 * (1.0 + 1e-15)]));
            for value in values {
                assert_eq!(sorted.rank(value), points.iter().filter(|point| **point < value).count());
                let strata = offsets.iter().enumerate().filter(|(k, u)| *k as f64 + **u < value);
                assert_eq!(among_strata(value, &offsets), strata.count());
                let regular = (0..count).filter(|k| *k as f64 + offsets[0] < value);
                assert_eq!(among_regular(value, offsets[0], count), regular.count());
            }
        }
    }

    #[test]
    fn offspring_ends_at_ranks() {
        let weights = [0.0, 0.5, 0.0, 0.25, 0.25, 0.0];
        for (count, expected) in
            [(1, vec![8]), (4, vec![8, 8, 10, 11]), (30, [[8; 15].as_slice(), &[10; 8], &[11; 7]].concat())]
        {
            let mut ancestors = vec![0; count];
            let rank = |sum: f64| among_regular((sum - 3.0) * count as f64, 0.4, count);
            descend(&weights, 7, 3.0, rank, &mut ancestors);
            assert_eq!(ancestors, expected);
            // Weights that fall short.
            descend(&[0.1, 0.1, 0.0], 7, 0.0, |sum| among_regular(sum, 0.5, count), &mut ancestors);
            assert_eq!(ancestors, vec![8; count]);
        }
    }
}
