//! Properties that hold for any input, and parsers that panic on none: inputs are drawn anew, by a fixed seed.
//!
//! `PROPTEST_CASES` says how many; `cargo xtask ci --thorough` asks for more than the default.

mod covariance;
mod proposals;
mod resampling;
mod resumed;
mod saved;
mod weights;

use proptest::test_runner::{Config, RngSeed};

/// The same inputs at every run.
fn cases() -> Config {
    Config { rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Config::default() }
}
