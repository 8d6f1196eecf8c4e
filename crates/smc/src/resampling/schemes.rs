//! The four classical resampling schemes, all unbiased: particle `k` has `K·W_k` offspring in expectation.

use motes_models::batch::with_scratch;
use motes_models::{Stream, fill_uniform};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::descent::{Points, Spacings, draw};
use crate::parallel::Threads;

/// How ancestors are drawn. Each scheme holds the cumulative weights against `K` increasing points, in time linear in `K`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
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
        self.draw_rows(weights, 0, stream, ancestors, Threads::One);
    }

    /// [`Resampling::draw`] on several threads, of particles the first of which is row `first`.
    pub(crate) fn draw_rows(
        self,
        weights: &[f64],
        first: usize,
        stream: &mut Stream,
        ancestors: &mut [usize],
        threads: Threads,
    ) {
        match self {
            Resampling::Multinomial => {
                multinomial(weights, first, stream, ancestors, ancestors.len(), threads);
            }
            Resampling::Systematic => {
                draw(weights, first, Points::Regular { offset: stream.random() }, ancestors, threads);
            }
            Resampling::Stratified => with_scratch(ancestors.len(), |offsets| {
                fill_uniform(stream, offsets);
                draw(weights, first, Points::Strata { offsets }, ancestors, threads);
            }),
            Resampling::Residual => residual(weights, first, stream, ancestors),
        }
    }
}

/// Independent draws, with scratch for up to `most` of them.
fn multinomial(
    weights: &[f64],
    first: usize,
    stream: &mut Stream,
    ancestors: &mut [usize],
    most: usize,
    threads: Threads,
) {
    let count = ancestors.len();
    with_scratch(Spacings::scratch(most), |scratch| {
        let spacings = Spacings::draw(count, stream, scratch, threads);
        draw(weights, first, Points::Sorted { spacings, most }, ancestors, threads);
    });
}

/// What weights are rounded by, and more.
const ROUNDING: f64 = 1e-12;

fn residual(weights: &[f64], first: usize, stream: &mut Stream, ancestors: &mut [usize]) {
    let count = ancestors.len();
    with_scratch(weights.len(), |remainders| {
        let mut filled = 0;
        for (index, (remainder, weight)) in remainders.iter_mut().zip(weights).enumerate() {
            let expected = weight * count as f64;
            // Not one less where rounding leaves a whole number a hair short, as it does 49 times the weight 1/49.
            let certain = ((expected * (1.0 + ROUNDING)) as usize).min(count - filled);
            ancestors[filled..filled + certain].fill(first + index);
            filled += certain;
            *remainder = (expected - certain as f64).max(0.0);
        }
        if filled < count {
            // As much scratch as if all were left, so that asking again allocates nothing.
            multinomial(remainders, first, stream, &mut ancestors[filled..], count, Threads::One);
            ancestors.sort_unstable();
        }
    });
}
