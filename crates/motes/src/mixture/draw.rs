//! What a filter at one draw of the posterior is run with.

use motes_models::Seed;
use rand::Rng;

use crate::options::FilterOptions;
use crate::quantiles::Quantiles;

/// The options of the filter at the draw of this number: random numbers of its own, nothing beside it, and the quantiles that stand for what it
/// expects of a measurement.
pub(crate) fn options_of_draw(options: &FilterOptions, number: usize) -> FilterOptions {
    let seed = Seed::from_u64(options.seed).child("draws").nth(number as u64).stream().next_u64();
    FilterOptions { check: false, seed, quantiles: Quantiles::default(), ..options.clone() }
}
