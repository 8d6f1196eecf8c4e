//! When a higher log-evidence says that a filter misses mass.
//!
//! `ẑ` is unbiased and positive, so that it is above the evidence by `c` nats with a probability of at most `e^{−c}`: one that is much higher than another is right, whatever the errors of both.

/// A log-evidence that is higher by so much (nats) says it by itself.
pub(crate) const MISSED: f64 = 3.0;

/// What noise may explain of a difference of log-evidences with this standard error: twice the error, and no more than [`MISSED`], since a large error says that the lower one is too low.
pub(crate) fn noise_of(error: f64) -> f64 {
    (2.0 * error).min(MISSED)
}

/// [`noise_of`] where an error may not be known.
pub(crate) fn noise(error: Option<f64>) -> f64 {
    error.map_or(0.0, noise_of)
}
