//! What a filter at one draw of the posterior is run with.

use motes_models::Seed;
use rand::Rng;

use crate::options::FilterOptions;

/// The options of the filter at the draw of this number: random numbers of its own, and nothing beside it.
pub(crate) fn options_of_draw(options: &FilterOptions, number: usize) -> FilterOptions {
    let seed = Seed::from_u64(options.seed).child("draws").nth(number as u64).stream().next_u64();
    FilterOptions { check: false, seed, ..options.clone() }
}
