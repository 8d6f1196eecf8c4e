//! Distributions as transports of the standard normal one.

use super::distribution::Distribution;
use super::tails::{gamma_tails, normal_from_tail, normal_tail, root, student_tail};

/// The tail beyond it is about the smallest number.
const LARGEST: f64 = 37.0;

impl Distribution<f64> {
    /// `T(v) = F⁻¹(Φ(v))`: what a standard normal `v` becomes to have this distribution. Both tails are as exact as the numbers beside the end
    /// of the range are dense, but for the upper one of a gamma distribution beyond `v = 6`. Beyond 37 a tail is smaller than any number: there it is
    /// what it is at 37, unless it is affine.
    ///
    /// NaN for counts, and where a parameter is out of range.
    pub fn from_normal(&self, v: f64) -> f64 {
        let tail = normal_tail(v.abs().min(LARGEST));
        match *self {
            Distribution::Normal { mean, sd } => mean + sd * v,
            Distribution::LogNormal { origin, sign, location, scale } => {
                origin + sign * (location + scale * (sign * v)).exp()
            }
            Distribution::Laplace { location, scale } => {
                let size = -(2.0 * tail).ln() * scale;
                location + if v < 0.0 { -size } else { size }
            }
            Distribution::Exponential { origin, mean } => {
                // Below its origin it is turned around.
                let is_upper = (v > 0.0) == (mean > 0.0);
                origin + mean * if is_upper { -tail.ln() } else { -(-tail).ln_1p() }
            }
            Distribution::Uniform { low, high } => {
                let part = (high - low) * tail;
                if v < 0.0 { low + part } else { high - part }
            }
            Distribution::Gamma { origin, shape, scale } => {
                let is_upper = (v > 0.0) == (scale > 0.0);
                if !(shape > 0.0 && scale.is_finite() && origin.is_finite()) {
                    return f64::NAN;
                }
                origin
                    + scale
                        * root(0.0, f64::INFINITY, |x| {
                            let [lower, upper] = gamma_tails(shape, x);
                            if is_upper { tail - upper } else { lower - tail }
                        })
            }
            Distribution::StudentT { df, location, scale } => {
                if !(df > 0.0 && scale > 0.0 && location.is_finite()) {
                    return f64::NAN;
                }
                let size = scale * root(0.0, f64::INFINITY, |z| tail - student_tail(df, z));
                location + if v < 0.0 { -size } else { size }
            }
            Distribution::Poisson { .. }
            | Distribution::NegativeBinomial { .. }
            | Distribution::Binomial { .. } => f64::NAN,
        }
    }

    /// `T⁻¹(x) = Φ⁻¹(F(x))`, the standard normal number that [`Distribution::from_normal`] makes `x` of; ±∞ at the ends of the range and beyond.
    ///
    /// NaN for counts, and where a parameter is out of range.
    pub fn to_normal(&self, x: f64) -> f64 {
        // By the smaller tail, which is the exact one.
        let by_tails = |lower: f64, upper: f64| match lower < upper {
            true => -normal_from_tail(lower),
            false => normal_from_tail(upper),
        };
        // Of a positive number, which may have been turned around.
        let turned = |v: f64, scale: f64| if scale > 0.0 { v } else { -v };
        match *self {
            Distribution::Normal { mean, sd } => (x - mean) / sd,
            Distribution::LogNormal { origin, sign, location, scale } => {
                let above = (x - origin) * sign;
                let z = if above > 0.0 { above.ln() } else { f64::NEG_INFINITY };
                sign * ((z - location) / scale)
            }
            Distribution::Laplace { location, scale } => {
                let rest = x - location;
                let a = normal_from_tail(0.5 * (-rest.abs() / scale).exp());
                if rest < 0.0 { -a } else { a }
            }
            Distribution::Exponential { origin, mean } => {
                let e = (x - origin) / mean;
                let v = if e > 0.0 { by_tails(-(-e).exp_m1(), (-e).exp()) } else { f64::NEG_INFINITY };
                turned(v, mean)
            }
            Distribution::Uniform { low, high } => {
                let width = high - low;
                by_tails(((x - low) / width).max(0.0), ((high - x) / width).max(0.0))
            }
            Distribution::Gamma { origin, shape, scale } => {
                let g = (x - origin) / scale;
                if shape.is_nan() || shape <= 0.0 || g.is_nan() {
                    return f64::NAN;
                }
                let v = match g > 0.0 {
                    true => {
                        let [lower, upper] = gamma_tails(shape, g);
                        by_tails(lower, upper)
                    }
                    false => f64::NEG_INFINITY,
                };
                turned(v, scale)
            }
            Distribution::StudentT { df, location, scale } => {
                let z = (x - location) / scale;
                if df.is_nan() || df <= 0.0 || z.is_nan() {
                    return f64::NAN;
                }
                let a = normal_from_tail(student_tail(df, z.abs()));
                if z < 0.0 { -a } else { a }
            }
            Distribution::Poisson { .. }
            | Distribution::NegativeBinomial { .. }
            | Distribution::Binomial { .. } => f64::NAN,
        }
    }

    /// Whether [`Distribution::from_normal`] is affine.
    pub(super) fn is_normal(&self) -> bool {
        matches!(self, Distribution::Normal { .. })
    }
}
