//! Floating-point operations of one training step with `N = 10`, `M = 8`, `T = 12`.
//!
//! Two for each multiplication of the products, which come three times: forward, and backward to inputs and to weights.

use motes_proposals::{FcnnConfig, GnnConfig, RnnConfig};

use crate::folder::BANK_HORIZON;

const N: usize = 10;
const M: usize = 8;

/// Of `multiplications` for each particle at each time.
fn of(multiplications: usize, particles: usize) -> f64 {
    6.0 * (multiplications * particles * BANK_HORIZON) as f64
}

fn cascade(widths: &[usize]) -> usize {
    widths.windows(2).map(|pair| pair[0] * pair[1]).sum()
}

pub(crate) fn fcnn(config: &FcnnConfig, particles: usize) -> f64 {
    of(2 * cascade(&[&[N + M], config.widths.as_slice(), &[N]].concat()), particles)
}

pub(crate) fn rnn(config: &RnnConfig, particles: usize) -> f64 {
    let h = config.hidden;
    of((N + M + h) * 4 * h + 2 * h * N, particles)
}

/// In the basis of the eigenvectors between the hidden layers: one product for each node instead of four, and two changes of
/// basis; forming a matrix for each eigenvalue is not counted.
pub(crate) fn gnn(config: &GnnConfig, particles: usize) -> f64 {
    let layers = [&[2], config.features.as_slice(), &[1]].concat();
    let taps = config.order + 1;
    let multiplications = |pair: &[usize]| match pair[0].min(pair[1]) {
        0..=2 => taps * pair[0] * pair[1],
        _ => pair[0] * pair[1] + N * (pair[0] + pair[1]),
    };
    of(2 * N * layers.windows(2).map(multiplications).sum::<usize>(), particles)
}
