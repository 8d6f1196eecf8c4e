//! Initial weights, from our own streams and no other.

use motes_models::Stream;
use rand::RngExt;

/// `count` values uniform on `±bound`.
pub(crate) fn uniform(count: usize, bound: f64, stream: &mut Stream) -> Vec<f64> {
    (0..count).map(|_| bound * (2.0 * stream.random::<f64>() - 1.0)).collect()
}

/// `1/√fan_in`, the bound of a layer's weights and biases.
pub fn fan_in_bound(fan_in: usize) -> f64 {
    1.0 / (fan_in as f64).sqrt()
}
