//! Where a smooth function is 0, by Halley's method.

/// More steps than any tail takes; a bound for what never settles.
const MOST_STEPS: usize = 60;

/// A last step of this size, beside the unit, leaves an error of its cube.
const SMALL: f64 = 1e-5;

/// The root of `g` near `start`, for a `g` that is concave and strictly monotone; a step is small when it is small beside `unit`.
///
/// `at` gives `g`, `g′` and `g″/g′` at a point. Logarithms of tails are concave where densities are log-concave, so that Newton's steps cannot run away;
/// the second derivative makes them fewer.
pub(in crate::equations) fn root(start: f64, unit: f64, at: impl Fn(f64) -> [f64; 3]) -> f64 {
    let mut x = start;
    for _ in 0..MOST_STEPS {
        let [value, slope, bend] = at(x);
        let newton = value / slope;
        let step = newton / (1.0 - 0.5 * newton * bend).clamp(0.5, 2.0);
        x -= step;
        if step.is_nan() || step.abs() <= SMALL * unit {
            break;
        }
    }
    x
}
