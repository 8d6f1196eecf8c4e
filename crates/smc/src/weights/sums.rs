//! Passes over weights in vector lanes, in an order that no machine changes.

use motes_models::elementary::exp;
use pulp::{Simd, WithSimd};

/// What one needs to know of weights to normalise them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sums {
    /// The largest log-weight.
    pub(super) largest: f64,
    /// Whether each is a number below +∞.
    pub(super) number: bool,
    /// Of the weights as multiples of the largest.
    pub(super) sum: f64,
    pub(super) sum_of_squares: f64,
}

impl Default for Sums {
    /// Of no weights.
    fn default() -> Self {
        Sums { largest: f64::NEG_INFINITY, number: true, sum: 0.0, sum_of_squares: 0.0 }
    }
}

impl Sums {
    /// Of these weights and others.
    #[inline(always)]
    fn with(self, other: &Sums) -> Sums {
        let largest = self.largest.max(other.largest);
        let (mine, others) = (multiple(self.largest, largest), multiple(other.largest, largest));
        Sums {
            largest,
            number: self.number && other.number,
            sum: mine * self.sum + others * other.sum,
            sum_of_squares: mine * mine * self.sum_of_squares + others * others * other.sum_of_squares,
        }
    }
}

/// What multiples of `part` are to be multiplied by to be multiples of `largest`, both of them logarithms.
#[inline(always)]
fn multiple(part: f64, largest: f64) -> f64 {
    // Where all weights are zero there is nothing to scale.
    if part == largest { 1.0 } else { exp(part - largest) }
}

/// The sums of all blocks, in their order, whoever summed them.
pub(super) struct Together<'a>(pub(super) &'a [Sums]);

impl WithSimd for Together<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Sums {
        match self.0 {
            [] => Sums::default(),
            [first, others @ ..] => {
                let mut sums = *first;
                for other in others {
                    sums = sums.with(other);
                }
                sums
            }
        }
    }
}

/// Adds increments to log-weights, and leaves `exp(log w_k − maxⱼ log w_j)`.
pub(super) struct Update<'a> {
    pub(super) equal: Option<f64>,
    pub(super) log: &'a mut [f64],
    pub(super) weights: &'a mut [f64],
    pub(super) increments: &'a [f64],
}

/// Partial sums that are kept side by side; their number fixes the order of additions on any machine.
pub(crate) const LANES: usize = 32;
/// So many at a time at the end: not fewer, because a compiler that unrolls a loop forgets vectors.
const FEW: usize = 16;

impl WithSimd for Update<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Sums {
        let Update { equal, log, weights, increments } = self;
        let (mut largest, mut number) = ([f64::NEG_INFINITY; LANES], [1.0; LANES]);
        match equal {
            Some(equal) => {
                for (log, increment) in log.iter_mut().zip(increments) {
                    *log = equal + increment;
                }
            }
            None => {
                for (log, increment) in log.iter_mut().zip(increments) {
                    // What has no weight gets none, whatever has become of its state.
                    *log = if *log == f64::NEG_INFINITY { *log } else { *log + increment };
                }
            }
        }
        let (whole, rest) = log.as_chunks::<LANES>();
        let (few, rest) = rest.as_chunks::<FEW>();
        let mut last = [f64::NEG_INFINITY; FEW];
        last[..rest.len()].copy_from_slice(rest);
        for log in whole {
            compare(log, &mut largest, &mut number);
        }
        for log in few {
            compare(log, &mut largest, &mut number);
        }
        compare(&last, &mut largest, &mut number);
        let largest = combined(&largest, |a, b| if a > b { a } else { b });
        let number = number == [1.0; LANES];

        let (mut sum, mut sum_of_squares) = ([0.0; LANES], [0.0; LANES]);
        let (whole_weights, rest_weights) = weights.as_chunks_mut::<LANES>();
        let (few_weights, rest_weights) = rest_weights.as_chunks_mut::<FEW>();
        for (log, weights) in whole.iter().zip(whole_weights) {
            exponentiate(log, largest, weights, &mut sum, &mut sum_of_squares);
        }
        for (log, weights) in few.iter().zip(few_weights) {
            exponentiate(log, largest, weights, &mut sum, &mut sum_of_squares);
        }
        let mut last_weights = [0.0; FEW];
        exponentiate(&last, largest, &mut last_weights, &mut sum, &mut sum_of_squares);
        rest_weights.copy_from_slice(&last_weights[..rest_weights.len()]);
        let (sum, sum_of_squares) = (combined(&sum, |a, b| a + b), combined(&sum_of_squares, |a, b| a + b));
        Sums { largest, number, sum, sum_of_squares }
    }
}

/// All lanes in one, in few steps that wait for each other.
#[inline(always)]
pub(crate) fn combined(lanes: &[f64; LANES], with: impl Fn(f64, f64) -> f64) -> f64 {
    let mut few = [0.0; 8];
    for i in 0..8 {
        few[i] = with(with(lanes[i], lanes[i + 8]), with(lanes[i + 16], lanes[i + 24]));
    }
    let [a, b, c, d, e, f, g, h] = few;
    with(with(with(a, e), with(b, f)), with(with(c, g), with(d, h)))
}

#[inline(always)]
fn compare<const L: usize>(log: &[f64; L], largest: &mut [f64; LANES], number: &mut [f64; LANES]) {
    for i in 0..L {
        largest[i] = if log[i] > largest[i] { log[i] } else { largest[i] };
        number[i] = if log[i] < f64::INFINITY { number[i] } else { 0.0 };
    }
}

#[inline(always)]
fn exponentiate<const L: usize>(
    log: &[f64; L],
    largest: f64,
    weights: &mut [f64; L],
    sum: &mut [f64; LANES],
    sum_of_squares: &mut [f64; LANES],
) {
    for i in 0..L {
        let weight = exp(log[i] - largest);
        weights[i] = weight;
        sum[i] += weight;
        sum_of_squares[i] = weight.mul_add(weight, sum_of_squares[i]);
    }
}

/// Makes multiples of a block's largest weight normalised ones.
pub(super) struct Shift<'a> {
    pub(super) log: &'a mut [f64],
    pub(super) weights: &'a mut [f64],
    pub(super) log_sum: f64,
    pub(super) sums: &'a Sums,
    pub(super) whole: &'a Sums,
}

impl WithSimd for Shift<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for log in self.log {
            *log -= self.log_sum;
        }
        let scale = multiple(self.sums.largest, self.whole.largest) / self.whole.sum;
        for weight in self.weights {
            *weight *= scale;
        }
    }
}

/// `Σ_k W_k x_k`.
pub(super) struct Mean<'a> {
    pub(super) weights: &'a [f64],
    pub(super) states: &'a [f64],
    pub(super) mean: &'a mut [f64],
}

impl WithSimd for Mean<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let width = self.mean.len();
        self.mean.fill(0.0);
        let (weights, last_weights) = self.weights.as_chunks::<4>();
        let mut rows = self.states.chunks_exact(4 * width);
        // Four particles at a time, so that the mean is not read and written for each.
        for (weights, rows) in weights.iter().zip(&mut rows) {
            let (a, rest) = rows.split_at(width);
            let (b, rest) = rest.split_at(width);
            let (c, d) = rest.split_at(width);
            for i in 0..width {
                let first = weights[0].mul_add(a[i], weights[1] * b[i]);
                let second = weights[2].mul_add(c[i], weights[3] * d[i]);
                self.mean[i] += first + second;
            }
        }
        for (weight, row) in last_weights.iter().zip(rows.remainder().chunks_exact(width)) {
            for (mean, value) in self.mean.iter_mut().zip(row) {
                *mean = weight.mul_add(*value, *mean);
            }
        }
    }
}
