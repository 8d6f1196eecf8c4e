//! Numeric derivatives, and how far two vectors are apart.

/// The gradient of `f` at `at` by central differences with step `h`.
pub fn central_differences(at: &[f64], h: f64, mut f: impl FnMut(&[f64]) -> f64) -> Vec<f64> {
    let mut point = at.to_vec();
    (0..at.len())
        .map(|i| {
            point[i] = at[i] + h;
            let above = f(&point);
            point[i] = at[i] - h;
            let below = f(&point);
            point[i] = at[i];
            (above - below) / (2.0 * h)
        })
        .collect()
}

/// `‖values‖`.
pub fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// `‖found − expected‖`.
pub fn distance(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// `‖found − expected‖ / ‖expected‖`.
pub fn relative_distance(found: &[f64], expected: &[f64]) -> f64 {
    distance(found, expected) / norm(expected)
}
