//! Standard normal variates in bulk.

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::Stream;

/// Fills `out` with independent standard normal variates.
pub fn fill_standard_normal(stream: &mut Stream, out: &mut [f64]) {
    out.fill_with(|| stream.sample(StandardNormal));
}
