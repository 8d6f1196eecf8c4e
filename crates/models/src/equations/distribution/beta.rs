//! The beta distribution, and its distribution function for parameters of any size.
//!
//! Quantiles are said in `u = log z/(1 − z)`, whose density `zᵃ (1 − z)ᵇ/B(a, b)` is log-concave whatever `a` and `b` are.

use rand_distr::Distribution as _;

use crate::Stream;
use crate::equations::draw::{Needs, Rejection, Source, Try, UNDECIDED};
use crate::equations::family::{Family, above_zero, parameters, zero_or_nan};
use crate::equations::quantile::{Quantile, normal, root, sign_of, transported};
use crate::equations::scalar::Scalar;
use crate::gaussian::LN_2PI;

parameters! {
    /// `origin + scale·B` of a standard beta `B`, between 0 and 1: [`beta`](super::distributions::beta).
    Beta {
        /// The end of its range that is 0 of `B`.
        origin,
        /// The distance of the other end; below 0 where it lies below its origin.
        scale,
        /// Its first shape, above 0: the power of `B`.
        a,
        /// Its second shape, above 0: the power of `1 − B`.
        b,
    }
}

impl<S: Scalar> Beta<S> {
    #[inline(always)]
    pub(super) fn new(a: S, b: S) -> Self {
        Beta { origin: S::from(0.0), scale: S::from(1.0), a, b }.guarded()
    }
}

impl<S: Scalar> Family<S> for Beta<S> {
    #[inline(always)]
    fn guarded(self) -> Self {
        Beta { a: above_zero(self.a), b: above_zero(self.b), ..self }
    }

    #[inline(always)]
    fn affine(self, shift: S, scale: S, size: S) -> Self {
        let origin = self.origin * scale + shift;
        Beta { origin, scale: self.scale * scale + zero_or_nan(size), ..self }
    }

    #[inline(always)]
    fn log_density(self, x: S, _: impl FnOnce() -> S) -> S {
        let Beta { origin, scale, a, b } = self;
        let z = (x - origin) / scale;
        let rest = -z + 1.0;
        let density = (a - 1.0) * z.ln() + (b - 1.0) * rest.ln() + (a + b).ln_gamma()
            - a.ln_gamma()
            - b.ln_gamma()
            - scale.abs().ln();
        z.min(rest).where_positive(density, S::from(f64::NEG_INFINITY)) + zero_or_nan(a) + zero_or_nan(b)
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        self.origin + self.scale * source.by::<StandardBeta>(self.a, self.b)
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        let Beta { origin, scale, a, b } = self;
        let sum = a + b;
        [origin + scale * a / sum, scale * scale * a * b / (sum * sum * (sum + 1.0))]
    }

    fn to_normal(self, x: S) -> S {
        let Beta { origin, scale, a, b } = self;
        let zero = S::from(0.0);
        let z = ((x - origin) / scale).max(zero);
        // What is near the upper end is measured from there.
        let rest = ((origin + scale - x) / scale).max(zero);
        let density = |[z, a, b]: [f64; 3]| Beta { origin: 0.0, scale: 1.0, a, b }.log_density(z, || z);
        let below = transported([z, a, b], |[z, a, b]| lower_to_normal(a, b, z), density);
        let above = transported([rest, b, a], |[z, a, b]| lower_to_normal(a, b, z), density);
        sign_of(scale) * (rest - z).where_positive(below, -above)
    }
}

impl Quantile for Beta<f64> {
    fn transport(self, v: f64) -> [f64; 2] {
        let Beta { origin, scale, a, b } = self;
        let v = v * scale.signum();
        // Each tail from its own end.
        let u = if v > 0.0 { -from_normal(b, a, -v) } else { from_normal(a, b, v) };
        let [log, log_rest] = logs(u);
        let x = if u < 0.0 { origin + scale * log.exp() } else { origin + scale - scale * log_rest.exp() };
        let density = a * log + b * log_rest - log_beta(a, b);
        [x, normal::log_density(v) - density + log + log_rest + scale.abs().ln()]
    }

    fn ends(self) -> [f64; 2] {
        let [one, other] = [self.origin, self.origin + self.scale];
        [one.min(other), one.max(other)]
    }
}

/// Draws from 0 to 1, one by one.
struct StandardBeta;

impl Rejection for StandardBeta {
    const NEEDS: Needs = Needs::NOTHING;

    #[inline(always)]
    fn quick<const W: usize>(_: &[f64; W], _: &[f64; W], _: &Try<&[f64; W]>, drawn: &mut [f64; W]) {
        *drawn = [UNDECIDED; W];
    }

    fn draw(a: f64, b: f64, _: Try<f64>, stream: &mut Stream) -> f64 {
        rand_distr::Beta::new(a, b).map_or(f64::NAN, |beta| beta.sample(stream))
    }
}

/// From here on Stirling's series has all digits.
const LARGE: f64 = 10.0;

/// What `log Γ(x)` is beyond `(x − ½) log x − x + ½ log 2π`, for a large `x`.
fn beyond_stirling(x: f64) -> f64 {
    let w = 1.0 / (x * x);
    (1.0 / 12.0 - w * (1.0 / 360.0 - w * (1.0 / 1260.0 - w * (1.0 / 1680.0 - w / 1188.0)))) / x
}

/// `log B(a, b)`. The logarithms of gamma functions of large numbers would cancel each other.
fn log_beta(a: f64, b: f64) -> f64 {
    let (a, b) = if a < b { (a, b) } else { (b, a) };
    let sum = a + b;
    if b < LARGE {
        return Scalar::ln_gamma(a) + Scalar::ln_gamma(b) - Scalar::ln_gamma(sum);
    }
    // log Γ(b) − log Γ(a + b) + a log(a + b).
    let quotient = a - (b - 0.5) * (a / b).ln_1p() + beyond_stirling(b) - beyond_stirling(sum);
    if a < LARGE {
        return Scalar::ln_gamma(a) + quotient - a * sum.ln();
    }
    a * (a / sum).ln() - 0.5 * a.ln() - a + 0.5 * LN_2PI + beyond_stirling(a) + quotient
}

/// `log z` and `log(1 − z)` of `u`.
fn logs(u: f64) -> [f64; 2] {
    let small = (-u.abs()).exp().ln_1p();
    if u < 0.0 { [u - small, -small] } else { [-small, -u - small] }
}

/// Terms that a continued fraction may take: about as many as the root of the larger parameter.
const MOST_TERMS: usize = 200_000;

/// The continued fraction of the incomplete beta function at `z` and `rest`, which is `1 − z` (DiDonato and Morris, 1992): `zᵃ (1 − z)ᵇ/B(a, b)` over it is
/// `P(B < z)`. It converges soon for `z` below `(a + 1)/(a + b + 2)`; NaN where it takes too long.
fn fraction(a: f64, b: f64, [z, rest]: [f64; 2]) -> f64 {
    let upper = |n: f64| (a + n) * (a * rest - b * z + 1.0 + n * (1.0 + rest)) / (a + 2.0 * n + 1.0);
    // Its other part is 0 at n = 0, where an a of 1 would divide by 0.
    let whole = |n: f64| n + n * (b - n) * z / (a + 2.0 * n - 1.0) + upper(n);
    let mut found = upper(0.0);
    let (mut c, mut d) = (found, 0.0);
    for term in 1..MOST_TERMS {
        let n = term as f64;
        let part = (a + n - 1.0) * (a + b + n - 1.0) * n * (b - n) * (z / (a + 2.0 * n - 1.0)).powi(2);
        let own = whole(n);
        d = 1.0 / (own + part * d);
        c = own + part / c;
        found *= c * d;
        if (c * d - 1.0).abs() < 2.0 * f64::EPSILON {
            return found;
        }
    }
    f64::NAN
}

/// `log P(B < z)` of a standard beta `B`, for the logarithms of `z` and of `1 − z`; `constant` is [`log_beta`].
fn log_lower(a: f64, b: f64, constant: f64, [log, log_rest]: [f64; 2]) -> f64 {
    let density = a * log + b * log_rest - constant;
    let [z, rest] = [log, log_rest].map(f64::exp);
    if z * (a + b + 2.0) <= a + 1.0 {
        density - fraction(a, b, [z, rest]).ln()
    } else {
        let upper = density - fraction(b, a, [rest, z]).ln();
        // Rounding may leave nothing below.
        (-upper.exp().min(1.0)).ln_1p()
    }
}

fn are_shapes(a: f64, b: f64) -> bool {
    a > 0.0 && a < f64::INFINITY && b > 0.0 && b < f64::INFINITY
}

/// The standard normal `v` of a standard beta `z` in the lower half of its range, or near there.
fn lower_to_normal(a: f64, b: f64, z: f64) -> f64 {
    if !are_shapes(a, b) || z.is_nan() {
        return f64::NAN;
    }
    if z <= 0.0 || z >= 1.0 {
        return if z <= 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    }
    let (logs, constant) = ([z.ln(), (-z).ln_1p()], log_beta(a, b));
    let lower = log_lower(a, b, constant, logs);
    if lower < -std::f64::consts::LN_2 {
        -normal::from_log_upper(lower)
    } else {
        normal::from_log_upper(log_lower(b, a, constant, [logs[1], logs[0]]))
    }
}

/// The `u` of a standard normal `v` that is not above 0; NaN for shapes that are out of range.
fn from_normal(a: f64, b: f64, v: f64) -> f64 {
    if !are_shapes(a, b) || v.is_nan() {
        return f64::NAN;
    }
    let (target, constant) = (normal::log_upper(-v), log_beta(a, b));
    if target == f64::NEG_INFINITY {
        return target;
    }
    // The tail is about zᵃ/(a B), and above it for b below 1; nearer to the centre the logit is about normal.
    let log = (target + a.ln() + constant) / a;
    let far = if log < 0.0 { log - (-log.exp()).ln_1p() } else { f64::NEG_INFINITY };
    let near = (a / b).ln() + v * (1.0 / a + 1.0 / b).sqrt();
    let start = if a < 1.0 { far.max(-1e300) } else { near.max(far) };
    let unit = 1.0 / (1.0 + (a * b / (a + b)).sqrt());
    root(if start.is_finite() { start } else { near }, unit, |u| {
        let logs = logs(u);
        let tail = log_lower(a, b, constant, logs);
        let hazard = (a * logs[0] + b * logs[1] - constant - tail).exp();
        [tail - target, hazard, a * logs[1].exp() - b * logs[0].exp() - hazard]
    })
}
