//! The four classical resampling schemes, all unbiased: particle `k` has `K·W_k` offspring in expectation.

use motes_models::Stream;
use rand::RngExt;

/// How ancestors are drawn. Each scheme walks the cumulative weights once with `K` increasing points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Resampling {
    /// `K` independent draws: offspring counts are multinomial. The paper's choice.
    #[default]
    Multinomial,
    /// Points `(k + u)/K` with one uniform `u`: counts are `⌊KW⌋` or `⌈KW⌉`.
    Systematic,
    /// Points `(k + u_k)/K` with a uniform each: counts within 1 of `⌊KW⌋ … ⌈KW⌉`.
    Stratified,
    /// `⌊KW⌋` offspring for certain, the rest multinomial on the remainders: counts are at least `⌊KW⌋`.
    Residual,
}

impl Resampling {
    /// Draws `ancestors.len()` ancestors for particles of the given normalised weights, in increasing order.
    ///
    /// The number of ancestors may differ from that of the weights. Nothing is allocated but by
    /// [`Resampling::Residual`].
    pub fn draw(
        self,
        weights: impl ExactSizeIterator<Item = f64>,
        stream: &mut Stream,
        ancestors: &mut [usize],
    ) {
        let count = ancestors.len();
        match self {
            Resampling::Multinomial => {
                invert_cumulative(weights, SortedUniforms::new(count, stream), ancestors)
            }
            Resampling::Systematic => {
                let offset: f64 = stream.random();
                let points = (0..count).map(|k| (k as f64 + offset) / count as f64);
                invert_cumulative(weights, points, ancestors);
            }
            Resampling::Stratified => {
                let points = (0..count).map(|k| (k as f64 + stream.random::<f64>()) / count as f64);
                invert_cumulative(weights, points, ancestors);
            }
            Resampling::Residual => residual(weights, stream, ancestors),
        }
    }
}

/// The index of the weight whose stretch of the cumulative sum holds each of the increasing `points`.
fn invert_cumulative(
    weights: impl ExactSizeIterator<Item = f64>,
    points: impl Iterator<Item = f64>,
    ancestors: &mut [usize],
) {
    let mut weights = weights.enumerate();
    let (mut chosen, mut cumulative) = (0, 0.0);
    for (ancestor, point) in ancestors.iter_mut().zip(points) {
        // Rounding can leave the whole sum just short of the last point: then the last weight that is not zero wins.
        while cumulative <= point {
            match weights.next() {
                Some((index, weight)) if weight > 0.0 => {
                    chosen = index;
                    cumulative += weight;
                }
                Some(_) => {}
                None => break,
            }
        }
        *ancestor = chosen;
    }
}

/// `count` sorted uniforms, smallest first, one at a time: the order statistics built from the top,
/// `U_(k) = U_(k+1) V^{1/k}`, mirrored.
struct SortedUniforms<'a> {
    left: usize,
    log_rest: f64,
    stream: &'a mut Stream,
}

impl<'a> SortedUniforms<'a> {
    fn new(count: usize, stream: &'a mut Stream) -> Self {
        SortedUniforms { left: count, log_rest: 0.0, stream }
    }
}

impl Iterator for SortedUniforms<'_> {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        // 1 − U is uniform on (0, 1], whose logarithm is finite.
        let uniform: f64 = 1.0 - self.stream.random::<f64>();
        self.log_rest += uniform.ln() / self.left as f64;
        self.left = self.left.checked_sub(1)?;
        Some(-self.log_rest.exp_m1())
    }
}

fn residual(weights: impl ExactSizeIterator<Item = f64>, stream: &mut Stream, ancestors: &mut [usize]) {
    let count = ancestors.len();
    let mut remainders: Vec<f64> = weights.map(|weight| weight * count as f64).collect();
    let mut filled = 0;
    for (index, remainder) in remainders.iter_mut().enumerate() {
        let certain = (remainder.floor() as usize).min(count - filled);
        ancestors[filled..filled + certain].fill(index);
        filled += certain;
        *remainder = (*remainder - certain as f64).max(0.0);
    }
    let rest: f64 = remainders.iter().sum();
    let left = count - filled;
    if left > 0 {
        let points = SortedUniforms::new(left, stream);
        invert_cumulative(remainders.iter().map(|value| value / rest), points, &mut ancestors[filled..]);
        ancestors.sort_unstable();
    }
}
