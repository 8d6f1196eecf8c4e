//! Settings of resampling as arguments.

use motes::smc::Resampling;
use motes_cli::one_of;

/// A number above 0 and at most 1.
pub(super) fn fraction(text: &str) -> Result<f64, String> {
    let fraction = text.parse().ok().filter(|fraction| *fraction > 0.0 && *fraction <= 1.0);
    fraction.ok_or_else(|| "it must be a number above 0 and at most 1".into())
}

/// A scheme by its name.
pub(super) fn resampling(text: &str) -> Result<Resampling, String> {
    match text {
        "multinomial" => Ok(Resampling::Multinomial),
        "systematic" => Ok(Resampling::Systematic),
        "stratified" => Ok(Resampling::Stratified),
        "residual" => Ok(Resampling::Residual),
        other => Err(one_of(other, ["multinomial", "systematic", "stratified", "residual"])),
    }
}

/// A number of seconds above 0.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| *seconds > 0.0 && seconds.is_finite());
    seconds.ok_or_else(|| "it must be a number above 0".into())
}
