//! Tails of distributions, and where a tail of a given size begins.

use special::{Beta, Error, Gamma};

/// `Φ(−a)`, the tail of the standard normal distribution beyond `a`.
pub(super) fn normal_tail(a: f64) -> f64 {
    0.5 * (a * std::f64::consts::FRAC_1_SQRT_2).compl_error()
}

/// `log φ(v)`.
pub(super) fn log_normal_density(v: f64) -> f64 {
    -0.5 * (v * v + std::f64::consts::TAU.ln())
}

/// The `a ≥ 0` whose normal tail is `tail` (at most ½).
pub(super) fn normal_from_tail(tail: f64) -> f64 {
    if tail >= 0.5 {
        return 0.0;
    }
    if tail <= 0.0 {
        return f64::INFINITY;
    }
    let target = tail.ln();
    // The logarithm of the tail is concave: from the right, Newton's steps do not cross the root.
    let mut a = (-2.0 * target).sqrt();
    for _ in 0..MOST_STEPS {
        let found = normal_tail(a);
        if found <= 0.0 {
            a *= 0.99;
            continue;
        }
        let step = (found.ln() - target) * found / log_normal_density(a).exp();
        a = (a + step).max(0.0);
        if step.abs() <= 1e-15 * (1.0 + a) {
            break;
        }
    }
    a
}

/// Newton's steps, which take about five.
const MOST_STEPS: usize = 60;

/// The lower and the upper tail of a gamma distribution with scale 1 at `x > 0`. Of the smaller ones the upper one is right to 1e−16 of 1 only.
pub(super) fn gamma_tails(shape: f64, x: f64) -> [f64; 2] {
    let lower = x.inc_gamma(shape).clamp(0.0, 1.0);
    [lower, 1.0 - lower]
}

/// The tail of Student's t beyond `z ≥ 0`.
pub(super) fn student_tail(df: f64, z: f64) -> f64 {
    let (a, b) = (0.5 * df, 0.5);
    let log_beta = a.ln_beta(b);
    let square = z * z;
    // Two forms, each of which is exact where the other cancels.
    match square < df {
        true => 0.5 * (1.0 - (square / (df + square)).inc_beta(b, a, log_beta)),
        false => 0.5 * (df / (df + square)).inc_beta(a, b, log_beta),
    }
}

/// The `x` in `[low, high]` at which a function that does not decrease passes 0; `high` may be infinite.
///
/// Ends in the last bits of `x`, whatever the function looks like.
pub(super) fn root(mut low: f64, high: f64, function: impl Fn(f64) -> f64) -> f64 {
    let mut high = if high.is_finite() {
        high
    } else {
        let mut end = low + 1.0;
        while end.is_finite() && function(end) < 0.0 {
            low = end;
            end *= 2.0;
        }
        end
    };
    for _ in 0..200 {
        // Between numbers of different sizes, half way in their logarithms.
        let middle = match low > 0.0 && high > 4.0 * low {
            true => (low * high).sqrt(),
            false => 0.5 * (low + high),
        };
        if middle <= low || middle >= high {
            break;
        }
        if function(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
        if high - low <= 4.0 * f64::EPSILON * high.abs() {
            break;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_tails_are_those_of_tables() {
        // Abramowitz and Stegun, tables 26.1 and 26.2.
        for (a, tail) in [
            (0.0, 0.5),
            (1.0, 0.158_655_253_931_457),
            (3.0, 1.349_898_031_630_09e-3),
            (8.0, 6.220_960_574_271_78e-16),
        ] {
            assert!((normal_tail(a) / tail - 1.0).abs() < 1e-13, "{a}");
            assert!((normal_from_tail(tail) - a).abs() < 1e-13, "{a}");
        }
        assert_eq!(normal_from_tail(0.0), f64::INFINITY);
    }

    #[test]
    fn students_tails_are_those_of_tables() {
        // The quantile 0.975, and a Cauchy distribution.
        for (df, z) in
            [(1.0, 12.706_204_736_174_7), (4.0, 2.776_445_105_197_79), (30.0, 2.042_272_456_301_24)]
        {
            assert!((student_tail(df, z) - 0.025).abs() < 1e-13, "{df}: {}", student_tail(df, z));
        }
        let cauchy = |z: f64| 0.5 - z.atan() / std::f64::consts::PI;
        for z in [0.0, 0.3, 2.0] {
            assert!(
                (student_tail(1.0, z) - cauchy(z)).abs() < 1e-14,
                "{z}: {}",
                student_tail(1.0, z) - cauchy(z)
            );
        }
        assert!((student_tail(1.0, 1e8) * std::f64::consts::PI * 1e8 - 1.0).abs() < 1e-12);
    }
}
