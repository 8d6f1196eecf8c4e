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

/// `‖found − expected‖ / ‖expected‖`.
pub fn relative_distance(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let difference = norm(&mut found.iter().zip(expected).map(|(a, b)| a - b));
    difference / norm(&mut expected.iter().copied())
}
