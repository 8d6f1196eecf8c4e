//! The four classical resampling schemes, all unbiased: particle `k` has `K·W_k` offspring in expectation.

use motes_models::batch::with_scratch;
use motes_models::{Stream, fill_standard_exponential, fill_uniform};
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
    /// The number of ancestors may differ from that of the weights. Once a thread has resampled so many particles, doing it again
    /// allocates nothing.
    pub fn draw(self, weights: &[f64], stream: &mut Stream, ancestors: &mut [usize]) {
        let count = ancestors.len();
        match self {
            Resampling::Multinomial => with_scratch(count + 1, |spacings| {
                multinomial(weights, 1.0, stream, spacings, ancestors);
            }),
            Resampling::Systematic => {
                let offset: f64 = stream.random();
                let points = (0..count).map(|k| (k as f64 + offset) / count as f64);
                invert_cumulative(weights, 1.0, points, ancestors);
            }
            Resampling::Stratified => with_scratch(count, |uniforms| {
                fill_uniform(stream, uniforms);
                let points = uniforms.iter().enumerate().map(|(k, u)| (k as f64 + u) / count as f64);
                invert_cumulative(weights, 1.0, points, ancestors);
            }),
            Resampling::Residual => residual(weights, stream, ancestors),
        }
    }
}

/// The index of the weight, times `scale`, whose stretch of the cumulative sum holds each of the increasing `points`.
fn invert_cumulative(
    weights: &[f64],
    scale: f64,
    points: impl Iterator<Item = f64>,
    ancestors: &mut [usize],
) {
    let mut weights = weights.iter().enumerate();
    let (mut chosen, mut cumulative) = (0, 0.0);
    for (ancestor, point) in ancestors.iter_mut().zip(points) {
        // Rounding can leave the whole sum just short of the last point: then the last weight that is not zero wins.
        while cumulative <= point {
            match weights.next() {
                Some((index, &weight)) => {
                    chosen = if weight > 0.0 { index } else { chosen };
                    cumulative += weight * scale;
                }
                None => break,
            }
        }
        *ancestor = chosen;
    }
}

/// Independent draws by weights that sum to `total`; `spacings` is scratch of one place more than there are ancestors.
///
/// The points are sorted uniforms without sorting: sums of `K + 1` exponential spacings, over the whole of them. The weights are scaled
/// by that instead, once.
fn multinomial(
    weights: &[f64],
    total: f64,
    stream: &mut Stream,
    spacings: &mut [f64],
    ancestors: &mut [usize],
) {
    fill_standard_exponential(stream, spacings);
    let whole: f64 = spacings.iter().sum();
    let mut point = 0.0;
    let points = spacings.iter().map(|spacing| {
        point += spacing;
        point
    });
    invert_cumulative(weights, whole / total, points, ancestors);
}

fn residual(weights: &[f64], stream: &mut Stream, ancestors: &mut [usize]) {
    let count = ancestors.len();
    with_scratch(weights.len() + count + 1, |scratch| {
        let (remainders, spacings) = scratch.split_at_mut(weights.len());
        let mut filled = 0;
        for (index, (remainder, weight)) in remainders.iter_mut().zip(weights).enumerate() {
            let expected = weight * count as f64;
            let certain = (expected.floor() as usize).min(count - filled);
            ancestors[filled..filled + certain].fill(index);
            filled += certain;
            *remainder = (expected - certain as f64).max(0.0);
        }
        let left = &mut ancestors[filled..];
        if !left.is_empty() {
            let total = remainders.iter().sum();
            multinomial(remainders, total, stream, &mut spacings[..left.len() + 1], left);
            ancestors.sort_unstable();
        }
    });
}
