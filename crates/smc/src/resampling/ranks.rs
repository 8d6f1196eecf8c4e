//! From cumulative weights to ancestors, without a branch that depends on chance.
//!
//! Walking points and weights side by side costs a mispredicted branch for almost every particle, more than all arithmetic. Here
//! each cumulative weight is asked for its rank among the points, which says where its offspring ends.

use std::hint::select_unpredictable;

/// Fills `ancestors` with increasing indices of `weights` so that `k` descends from the first weight whose cumulative sum has a
/// rank above `k`; `rank` must increase, from 0 to the number of ancestors.
pub(super) fn descend(weights: &[f64], mut rank: impl FnMut(f64) -> usize, ancestors: &mut [usize]) {
    ancestors.fill(0);
    let (mut cumulative, mut last) = (0.0, 0);
    for (index, weight) in weights.iter().enumerate() {
        cumulative += weight;
        last = if *weight > 0.0 { index } else { last };
        // Where this weight's offspring ends the next one's may begin; of several that end here the last one stays.
        if let Some(next) = ancestors.get_mut(rank(cumulative)) {
            *next = index + 1;
        }
    }
    // Rounding can leave the whole sum just short of the last point: then the last weight that is not zero goes on.
    let mut index = 0;
    for ancestor in ancestors {
        index = select_unpredictable(*ancestor > index, *ancestor, index);
        *ancestor = select_unpredictable(index < last, index, last);
    }
}

/// The integer part of a number that is not negative.
#[inline]
fn floor(value: f64) -> usize {
    // Through i64, which is one instruction on any machine.
    value as i64 as usize
}

/// How many of the points `k + offset` lie below `value`, for `k` from 0 to `count − 1`.
#[inline]
pub(super) fn among_regular(value: f64, offset: f64, count: usize) -> usize {
    let above = (value - offset).max(0.0);
    let whole = floor(above);
    (whole + usize::from((whole as f64) < above)).min(count)
}

/// How many of the points `k + offsets[k]` lie below `value`, with offsets in `[0, 1)`.
#[inline]
pub(super) fn among_strata(value: f64, offsets: &[f64]) -> usize {
    let whole = floor(value);
    match offsets.get(whole) {
        Some(offset) => whole + usize::from(*offset < value - whole as f64),
        None => offsets.len(),
    }
}

/// The integer nearest to a number from 0 to 2³².
#[inline]
fn nearest(value: f64) -> usize {
    // Adding 2⁵² leaves the integer in the lowest bits, without the checks of a conversion.
    (value + (1_u64 << 52) as f64).to_bits() as u32 as usize
}

/// Sorted points on `[0, count]` that can be asked for ranks.
pub(super) struct SortedPoints<'a> {
    /// The points, and behind them as many infinite ones as a comparison may reach.
    points: &'a [f64],
    /// For each integer, how many points are nearer to a smaller one.
    below: &'a [f64],
}

/// Infinite points behind the others.
const SENTINELS: usize = 4;

impl<'a> SortedPoints<'a> {
    /// Numbers of scratch for `count` points.
    pub(super) fn scratch(count: usize) -> usize {
        2 * count + SENTINELS + 2
    }

    /// Takes `count + 1` positive spacings at the start of scratch: their partial sums but for the last, in units of the whole sum over
    /// `count`, are points distributed as `count` sorted uniforms on `[0, count]` if the spacings are exponential.
    pub(super) fn from_spacings(scratch: &'a mut [f64], count: usize) -> Self {
        let (points, below) = scratch.split_at_mut(count + SENTINELS);
        let whole: f64 = points[..=count].iter().sum();
        let scale = count as f64 / whole;
        below.fill(0.0);
        let mut sum = 0.0;
        for (index, point) in points[..count].iter_mut().enumerate() {
            sum += *point;
            *point = sum * scale;
            below[nearest(*point).min(count) + 1] = (index + 1) as f64;
        }
        points[count..].fill(f64::INFINITY);
        let mut largest = 0.0;
        for below in below.iter_mut() {
            largest = if *below > largest { *below } else { largest };
            *below = largest;
        }
        SortedPoints { points, below }
    }

    /// How many points lie below `value`.
    #[inline]
    pub(super) fn rank(&self, value: f64) -> usize {
        let count = self.points.len() - SENTINELS;
        let start = nearest(self.below[nearest(value).min(count)]);
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
    use motes_models::{Seed, fill_standard_exponential, fill_uniform};

    #[test]
    fn ranks_are_those_of_counting() {
        let mut stream = Seed::from_u64(30).stream();
        for count in [1, 2, 7, 40, 300] {
            let (mut scratch, mut offsets) = (vec![0.0; SortedPoints::scratch(count)], vec![0.0; count]);
            fill_standard_exponential(&mut stream, &mut scratch[..=count]);
            fill_uniform(&mut stream, &mut offsets);
            let sorted = SortedPoints::from_spacings(&mut scratch, count);
            let points = sorted.points[..count].to_vec();
            assert!(points.is_sorted() && points[0] >= 0.0 && points[count - 1] <= count as f64);
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
}
