//! The error of a log-evidence with its bias.

/// The root of the mean square error of `log Ẑ` (nats) where it has the variance `v` (nats²) and is too low by `v/2` in the mean: `√(v + v²/4)`.
pub fn error_of_variance(variance: f64) -> f64 {
    (variance + 0.25 * variance * variance).sqrt()
}

/// The variance that an [`error_of_variance`] is of.
pub fn variance_of_error(error: f64) -> f64 {
    // 2(√(1 + s²) − 1), without its cancellation.
    2.0 * error * error / ((1.0 + error * error).sqrt() + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_has_the_variance_that_it_is_of() {
        for variance in [0.0, 1e-12, 0.01, 1.0, 9.0, 400.0] {
            let back = variance_of_error(error_of_variance(variance));
            assert!((back - variance).abs() <= 1e-14 * variance, "{back} for {variance}");
        }
        assert!((error_of_variance(4.0) - 8.0_f64.sqrt()).abs() < 1e-15);
    }
}
