//! Masses of intervals under the standard normal distribution without branches, so that a loop over them becomes vector instructions.

use crate::elementary;

/// Further out than any number that is drawn; its square is a number.
const FARTHEST: f64 = 1e100;

/// `log(1 − Φ(v)) + ½v²` for `0 ≤ v ≤ 1e100`, within 1e-15.
///
/// With `t = 1/(1 + v/4)` it is `log t` plus a function that is smooth on all of `0 < t ≤ 1`, here its Chebyshev series in `2t − 1` by powers.
#[inline(always)]
fn log_scaled_tail(v: f64) -> f64 {
    const SERIES: [f64; 26] = [
        -1.6669543059673455,
        0.804_857_155_915_768_3,
        0.188_673_672_801_757_62,
        0.008_203_119_400_934_97,
        -0.023_031_821_531_500_945,
        -0.009_219_441_071_696_127,
        0.002_065_589_619_510_461,
        0.002_751_855_700_385_16,
        0.000_192_183_033_025_327_6,
        -0.000_669_561_753_945_232,
        -0.000_193_535_454_660_444_65,
        0.000_141_980_059_379_250_56,
        7.700083341743191e-05,
        -2.5323924096623544e-05,
        -2.4020798287887366e-05,
        3.1452396144391564e-06,
        6.450209904842211e-06,
        7.650357596935222e-08,
        -1.503059638566358e-06,
        -2.1538944037930046e-07,
        2.914905221331001e-07,
        8.250300634885846e-08,
        -4.191265196817514e-08,
        -1.8248163293199162e-08,
        3.2936931884441067e-09,
        1.946986206023636e-09,
    ];
    let t = 1.0 / (0.25 * v + 1.0);
    let u = 2.0 * t - 1.0;
    let mut series = SERIES[25];
    for coefficient in SERIES[..25].iter().rev() {
        series = u.mul_add(series, *coefficient);
    }
    series + elementary::ln(t)
}

/// `log(Φ(high) − Φ(low))` for `low < high`, which may be infinite.
///
/// Where both lie on one side of 0 the digits are those of the smaller tail. Of a narrow interval about one digit is lost for each power of ten that it is narrower than 1.
#[inline(always)]
pub(super) fn log_mass(low: f64, high: f64) -> f64 {
    let (low, high) = (low.max(-FARTHEST), high.min(FARTHEST));
    let is_below = low + high < 0.0;
    let (near, far) = if is_below { (-high, -low) } else { (low, high) };
    // The far end is no nearer to 0 than the near one.
    let size = near.abs();
    let tail = log_scaled_tail(size);
    let of_far = log_scaled_tail(far) - tail - 0.5 * (far - size) * (far + size);
    // The tail beyond the far end over that beyond the near one's size, less 1.
    let less_one = elementary::exp_m1(of_far);
    let log_tail = tail - 0.5 * size * size;
    let beyond = elementary::exp(if log_tail < 0.0 { log_tail } else { 0.0 });
    let is_one_sided = near >= 0.0;
    let share = if is_one_sided { -less_one } else { 1.0 - beyond * (2.0 + less_one) };
    let log = elementary::ln(if share > 1e-300 { share } else { 1e-300 });
    if is_one_sided { log + log_tail } else { log }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equations::quantile::normal;

    /// Catches a coefficient that is off, and a side that is taken for the other.
    #[test]
    fn masses_are_those_of_the_exact_tails() {
        let ends =
            [f64::NEG_INFINITY, -60.0, -37.0, -9.0, -2.5, -1.0, -0.2, 0.0, 1e-3, 0.7, 1.9, 6.0, 20.0, 50.0];
        for (i, low) in ends.iter().enumerate() {
            for high in ends[i + 1..].iter().copied().chain([f64::INFINITY]) {
                let (found, right) = (log_mass(*low, high), normal::log_mass(*low, high));
                assert!(
                    (found - right).abs() <= 1e-12 * right.abs().max(1.0),
                    "{low} to {high}: {found}, not {right}"
                );
            }
        }
    }

    #[test]
    fn narrow_intervals_have_the_density_of_their_middle() {
        for middle in [-30.0, -3.0, -0.4, 0.0, 1.2, 8.0] {
            for width in [1e-3, 1e-6] {
                let found = log_mass(middle - 0.5 * width, middle + 0.5 * width);
                let right = normal::log_density(middle) + width.ln();
                let curved = (middle * middle - 1.0) * width * width / 24.0;
                assert!(
                    (found - right - curved).abs() < 1e-14 / width * (1.0 + middle * middle) + 1e-9,
                    "{middle}, {width}: {found}, not {right}"
                );
            }
        }
    }
}
