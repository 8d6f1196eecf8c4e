//! Sites averaged over smoothed states: how well look-ahead filters know the evidence where measurements are skewed.

use motes_models::equations::Equations;

use crate::common::{evidence_of_runs, moments, rows};
use crate::models::{Counts, Volatility};

/// The variance of the log-evidence by 50 particles.
fn variance(model: &impl Equations, seed: u64) -> f64 {
    let rows = rows(model, 200, seed);
    moments(&evidence_of_runs(model, &rows, 50, 100, Some(0.0))).1
}

/// Catches sites at the most likely states, by which the variances are 0.097 and 0.018.
#[test]
fn skewed_measurements_leave_little_to_weights() {
    let volatility = variance(&Volatility { sd: 0.3 }, 1);
    assert!(volatility < 0.015, "{volatility}");
    let counts = variance(&Counts { sd: 0.2 }, 2);
    assert!(counts < 0.007, "{counts}");
}
