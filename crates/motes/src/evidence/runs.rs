//! What independent runs of a filter say together: the mean of their evidence, and how far it can be off.

use motes_inference::LogMean;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The variance of some numbers; none of one.
pub(super) fn variance(values: &[f64]) -> Option<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.len() > 1).then(|| values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0))
}

/// The logarithm of the mean of `ẑ` over `R` runs, and its standard error. That is the larger one of two, that of the mean, which cannot be above 1 whatever was missed, and
/// `√(v/R + (v/2R)²)` of the variance `v` of `log ẑ`, whose mean is too low by `v/2`; times `t/1.96` with the quantile of Student's t for `R − 1` degrees of freedom, since so few runs hardly know
/// their variance.
pub(super) fn mean_of_runs(logs: &[f64]) -> (f64, Option<f64>) {
    let (mean, count) = (LogMean::of(logs), logs.len() as f64);
    let of_logs = variance(logs).map(|variance| variance / count);
    let of_logs = of_logs.map(|variance| (variance + 0.25 * variance * variance).sqrt());
    let error = mean.standard_error().zip(of_logs).map(|(of_mean, of_logs)| of_mean.max(of_logs));
    (mean.log(), error.map(|error| error * widening(logs.len())))
}

/// The 97.5 % quantile of Student's t for so many runs, as a multiple of the normal one.
fn widening(runs: usize) -> f64 {
    let student = StudentsT::new(0.0, 1.0, (runs - 1).max(1) as f64);
    student.map_or(1.0, |student| student.inverse_cdf(0.975)) / 1.959_964
}
