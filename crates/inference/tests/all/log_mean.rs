//! Means of numbers by their logarithms.

use motes_inference::LogMean;

#[test]
fn a_mean_is_that_of_the_numbers_themselves() {
    let numbers = [0.3_f64, 2.0, 0.05, 1.1];
    let logs = numbers.map(|number| number.ln() - 5000.0);
    let mean = LogMean::of(&logs);
    let (count, sum) = (numbers.len() as f64, numbers.iter().sum::<f64>());
    assert!((mean.log() + 5000.0 - (sum / count).ln()).abs() < 1e-11);
    let variance = numbers.iter().map(|number| (number - sum / count).powi(2)).sum::<f64>() / (count - 1.0);
    let expected = (variance / count).sqrt() / (sum / count);
    assert!((mean.standard_error().expect("there are four") - expected).abs() < 1e-11);
    let squares: f64 = numbers.iter().map(|number| number * number).sum();
    assert!((mean.effective() - sum * sum / squares).abs() < 1e-11);
}

/// Catches a mean that is no number where all are 0, and an error of what nobody knows.
#[test]
fn nothing_has_a_mean_too() {
    let nothing = LogMean::of(&[f64::NEG_INFINITY; 4]);
    assert_eq!((nothing.log(), nothing.standard_error()), (f64::NEG_INFINITY, None));
    assert_eq!(nothing.shares(), [0.25; 4]);
    let one = LogMean::of(&[-3.0, f64::NEG_INFINITY]);
    assert_eq!((one.shares(), one.effective()), (&[1.0, 0.0][..], 1.0));
    assert!((one.standard_error().expect("there are two") - 1.0).abs() < 1e-12);
    assert_eq!(LogMean::of(&[-3.0]).standard_error(), None);
    assert!(LogMean::of(&[]).log().is_nan() && LogMean::of(&[f64::NAN, 0.0]).log().is_nan());
    assert!(LogMean::of(&[f64::NAN]).log().is_nan());
}
