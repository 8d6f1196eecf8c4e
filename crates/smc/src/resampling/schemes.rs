//! The four classical resampling schemes, all unbiased: particle `k` has `K·W_k` offspring in expectation.

use motes_models::batch::with_scratch;
use motes_models::{Stream, fill_standard_exponential, fill_uniform};
use rand::RngExt;

use super::ranks::{SortedPoints, among_regular, among_strata, descend};

/// How ancestors are drawn. Each scheme holds the cumulative weights against `K` increasing points, in time linear in `K`.
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
        let scale = count as f64;
        match self {
            Resampling::Multinomial => with_scratch(SortedPoints::scratch(count), |scratch| {
                multinomial(weights, 1.0, stream, scratch, ancestors);
            }),
            Resampling::Systematic => {
                let offset: f64 = stream.random();
                descend(weights, |sum| among_regular(sum * scale, offset, count), ancestors);
            }
            Resampling::Stratified => with_scratch(count, |offsets| {
                fill_uniform(stream, offsets);
                descend(weights, |sum| among_strata(sum * scale, offsets), ancestors);
            }),
            Resampling::Residual => residual(weights, stream, ancestors),
        }
    }
}

/// Independent draws by weights that sum to `total`, with scratch for the points.
fn multinomial(
    weights: &[f64],
    total: f64,
    stream: &mut Stream,
    scratch: &mut [f64],
    ancestors: &mut [usize],
) {
    let count = ancestors.len();
    fill_standard_exponential(stream, &mut scratch[..=count]);
    let points = SortedPoints::from_spacings(&mut scratch[..SortedPoints::scratch(count)], count);
    let scale = count as f64 / total;
    descend(weights, |sum| points.rank(sum * scale), ancestors);
}

fn residual(weights: &[f64], stream: &mut Stream, ancestors: &mut [usize]) {
    let count = ancestors.len();
    with_scratch(weights.len() + SortedPoints::scratch(count), |scratch| {
        let (remainders, scratch) = scratch.split_at_mut(weights.len());
        let mut filled = 0;
        for (index, (remainder, weight)) in remainders.iter_mut().zip(weights).enumerate() {
            let expected = weight * count as f64;
            let certain = (expected as usize).min(count - filled);
            ancestors[filled..filled + certain].fill(index);
            filled += certain;
            *remainder = (expected - certain as f64).max(0.0);
        }
        if filled < count {
            let total = remainders.iter().sum();
            multinomial(remainders, total, stream, scratch, &mut ancestors[filled..]);
            ancestors.sort_unstable();
        }
    });
}
