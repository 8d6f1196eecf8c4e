//! Means, medians, quantiles and deviations.

/// `‖a − b‖²`.
pub(crate) fn squared_error(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// `‖a‖²`.
pub(crate) fn squared_norm(a: &[f64]) -> f64 {
    a.iter().map(|a| a * a).sum()
}

/// The arithmetic mean; NaN of nothing.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The middle value, or the mean of the two middle values; NaN of nothing.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => values[count / 2],
        count => 0.5 * (values[count / 2 - 1] + values[count / 2]),
    }
}

/// The values below which a quarter and three quarters of `values` lie, linear between two of them; NaN of nothing.
pub(crate) fn quartiles(values: &[f64]) -> (f64, f64) {
    quantiles(values, [0.25, 0.75]).into()
}

/// The values below which the given fractions of `values` lie, linear between two of them; NaN of nothing.
pub(crate) fn quantiles<const COUNT: usize>(values: &[f64], fractions: [f64; COUNT]) -> [f64; COUNT] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    fractions.map(|fraction| {
        let place = fraction * sorted.len().saturating_sub(1) as f64;
        let (low, high) = (sorted.get(place.floor() as usize), sorted.get(place.ceil() as usize));
        low.zip(high).map_or(f64::NAN, |(low, high)| low + (high - low) * place.fract())
    })
}

/// The sample standard deviation, over `n − 1`; 0 of one value.
pub(crate) fn standard_deviation(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return 0.0;
    }
    let mean = mean(values);
    let sum: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (sum / (values.len() - 1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worked_by_hand() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!((standard_deviation(&[1.0, 2.0, 3.0, 4.0]) - (5.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(standard_deviation(&[7.0]), 0.0);
        assert_eq!(quartiles(&[4.0, 1.0, 3.0, 2.0, 5.0]), (2.0, 4.0));
        assert_eq!(quartiles(&[0.0, 1.0]), (0.25, 0.75));
    }
}
