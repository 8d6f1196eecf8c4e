//! Von Mises' distribution of an angle.

use std::f64::consts::{PI, TAU};

use rand::RngExt;

use crate::Stream;
use crate::equations::family::Score;
use crate::equations::scalar::Scalar;
use crate::gaussian::LN_2PI;

/// From here on the asymptotic series of Bessel functions have all digits.
const LARGE: f64 = 40.0;

/// `log e^{−κ} I₀(κ)`, and the mean cosine `I₁(κ)/I₀(κ)`; NaN below 0.
fn bessel(kappa: f64) -> [f64; 2] {
    if !(0.0..f64::INFINITY).contains(&kappa) {
        return [f64::NAN; 2];
    }
    if kappa < LARGE {
        // Both series have positive terms.
        let square = 0.25 * kappa * kappa;
        let (mut term, mut zeroth, mut first, mut k) = (1.0, 1.0, 1.0, 0.0);
        while term > 1e-17 * zeroth {
            k += 1.0;
            term *= square / (k * k);
            zeroth += term;
            first += term / (k + 1.0);
        }
        return [zeroth.ln() - kappa, 0.5 * kappa * first / zeroth];
    }
    let series = |order: f64| {
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 1..20 {
            let odd = f64::from(2 * k - 1);
            term *= (odd * odd - 4.0 * order * order) / (8.0 * f64::from(k) * kappa);
            sum += term;
        }
        sum
    };
    let zeroth = series(0.0);
    [zeroth.ln() - 0.5 * (LN_2PI + kappa.ln()), series(1.0) / zeroth]
}

/// `log e^{−κ} I₀(κ)`.
fn log_bessel<S: Scalar>(kappa: S) -> S {
    S::custom([kappa], |[kappa]| bessel(kappa)[0], |[kappa], _| [bessel(kappa)[1] - 1.0])
}

/// `κ cos(y − μ) − log 2π I₀(κ)`.
pub(super) fn log_density<S: Scalar>(mu: S, kappa: S, y: S) -> S {
    // What is near μ keeps its digits so.
    let half = ((y - mu) * 0.5).sin();
    kappa * half * half * -2.0 - log_bessel(kappa) - LN_2PI
}

/// What an angle says of `μ`.
pub(super) fn score<S: Scalar>(mu: S, kappa: S, y: S) -> Score<S> {
    let mean_cosine = S::custom([kappa], |[kappa]| bessel(kappa)[1], |_, _| [0.0]);
    Score { location: mu, slope: kappa * (y - mu).sin(), information: kappa * mean_cosine }
}

/// An angle within half a turn of `μ`, by Best's and Fisher's rejection (1979); NaN where a parameter is out of range.
pub(super) fn sample(mu: f64, kappa: f64, stream: &mut Stream) -> f64 {
    if !(0.0..f64::INFINITY).contains(&kappa) || !mu.is_finite() {
        return f64::NAN;
    }
    let angle = if kappa < 1e-8 {
        PI * (2.0 * stream.random::<f64>() - 1.0)
    } else {
        let tau = 1.0 + (1.0 + 4.0 * kappa * kappa).sqrt();
        let rho = (tau - (2.0 * tau).sqrt()) / (2.0 * kappa);
        let r = (1.0 + rho * rho) / (2.0 * rho);
        let cosine = loop {
            let z = (PI * stream.random::<f64>()).cos();
            let f = (1.0 + r * z) / (r + z);
            let c = kappa * (r - f);
            let u = stream.random::<f64>();
            if c * (2.0 - c) > u || (c / u).ln() + 1.0 >= c {
                break f;
            }
        };
        cosine.clamp(-1.0, 1.0).acos().copysign(stream.random::<f64>() - 0.5)
    };
    // Rounding may leave the half turn.
    let drawn = mu + angle;
    if drawn <= mu - PI { drawn + TAU } else { drawn }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The series take turns without a step. The table was computed from the power series with 50 digits.
    #[test]
    fn bessel_functions_are_those_of_a_table() {
        let table =
            [(0.5, -0.438450280814519, 0.242499612580802), (5.0, -1.695318224177466, 0.893383137044085)];
        for (kappa, log, ratio) in table {
            let found = bessel(kappa);
            assert!((found[0] - log).abs() < 1e-14 && (found[1] - ratio).abs() < 1e-14, "{kappa}: {found:?}");
        }
        let [below, above] = [LARGE.next_down(), LARGE].map(bessel);
        assert!(
            (below[0] - above[0]).abs() < 1e-13 && (below[1] - above[1]).abs() < 1e-13,
            "{below:?} {above:?}"
        );
    }
}
