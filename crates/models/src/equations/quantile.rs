//! Distributions as transports of a standard normal number: `x = T(v) = F⁻¹(Φ(v))`.

mod count;
mod gamma;
mod normal;
mod root;
mod student;

use std::f64::consts::LN_2;

use super::distribution::Distribution;
use super::scalar::Scalar;

impl<S: Scalar> Distribution<S> {
    /// `T(v)` and `log T′(v)` of the families that are formulas of a normal number, and nothing of others.
    #[inline(always)]
    pub(super) fn formula(&self, v: S) -> Option<[S; 2]> {
        match *self {
            Distribution::Normal { mean, sd } => Some([mean + sd * v, sd.ln()]),
            Distribution::LogNormal { origin, sign, location, scale } => {
                let log = location + sign * scale * v;
                Some([origin + sign * log.exp(), log + scale.ln()])
            }
            _ => None,
        }
    }

    /// `T⁻¹(x)` of the same families.
    #[inline(always)]
    pub(super) fn inverse_formula(&self, x: S) -> Option<S> {
        match *self {
            Distribution::Normal { mean, sd } => Some((x - mean) / sd),
            Distribution::LogNormal { origin, sign, location, scale } => {
                let size = ((x - origin) * sign).max(S::from(0.0));
                Some(sign * (size.ln() - location) / scale)
            }
            _ => None,
        }
    }
}

impl Distribution<f64> {
    /// `T(v) = F⁻¹(Φ(v))`: what has this distribution where `v` is standard normal. It grows with `v`.
    ///
    /// Of counts it is the smallest whose distribution function reaches `Φ(v)`. NaN where a parameter is out of range. Each tail is computed from its own end of the
    /// range, so neither loses digits.
    ///
    /// ```
    /// use motes_models::equations::{Distribution, exponential, normal};
    ///
    /// let [position, delay]: [Distribution<f64>; 2] = [normal(1.0, 0.5), exponential(2.0)];
    /// assert_eq!(position.from_normal(-3.0), -0.5);
    /// // The median of the exponential distribution is log 2 of its mean.
    /// assert!((delay.from_normal(0.0) - 2.0 * 2.0_f64.ln()).abs() < 1e-15);
    /// ```
    pub fn from_normal(&self, v: f64) -> f64 {
        if self.is_discrete() { count::from_normal(self, v) } else { self.transport(v)[0] }
    }

    /// `T⁻¹(x)`: the standard normal quantile of `x`; −∞ and +∞ at and beyond the ends of the range.
    ///
    /// NaN for counts, and where a parameter is out of range.
    pub fn to_normal(&self, x: f64) -> f64 {
        if let Some(v) = self.inverse_formula(x) {
            return v;
        }
        match *self {
            Distribution::StudentT { df, location, scale } => student::to_normal(df, (x - location) / scale),
            Distribution::Laplace { location, scale } => {
                let z = (x - location) / scale;
                normal::from_log_upper(-z.abs() - LN_2).copysign(z)
            }
            Distribution::Exponential { origin, mean } => {
                let z = Scalar::max((x - origin) / mean, 0.0);
                mean.signum() * normal::from_log_upper(-z)
            }
            Distribution::Gamma { origin, shape, scale } => {
                scale.signum() * gamma::to_normal(shape, (x - origin) / scale)
            }
            Distribution::Uniform { low, high } => {
                let (below, above) = ((x - low) / (high - low), (high - x) / (high - low));
                let log_upper = |share: f64| Scalar::max(share, 0.0).ln();
                if below < above {
                    -normal::from_log_upper(log_upper(below))
                } else {
                    normal::from_log_upper(log_upper(above))
                }
            }
            // Counts; the others are formulas.
            _ => f64::NAN,
        }
    }

    /// `T(v)` and `log T′(v)`.
    pub(super) fn transport(&self, v: f64) -> [f64; 2] {
        if let Some(found) = self.formula(v) {
            return found;
        }
        match *self {
            Distribution::StudentT { df, location, scale } => {
                let [t, log_slope] = student::from_normal(df, v);
                [location + scale * t, log_slope + scale.ln()]
            }
            Distribution::Laplace { location, scale } => {
                let depth = normal::depth(v.abs());
                let log_slope = normal::log_density(v) + depth + LN_2 + scale.ln();
                [location + scale * depth.copysign(v), log_slope]
            }
            Distribution::Exponential { origin, mean } => {
                let v = v * mean.signum();
                let z = -normal::log_upper(v);
                [origin + mean * z, normal::log_density(v) + z + mean.abs().ln()]
            }
            Distribution::Gamma { origin, shape, scale } => {
                let [log, log_slope] = gamma::from_normal(shape, v * scale.signum());
                [origin + scale * log.exp(), log_slope + scale.abs().ln()]
            }
            Distribution::Uniform { low, high } => {
                let share = (high - low) * normal::upper(v.abs());
                let x = if v < 0.0 { low + share } else { high - share };
                [x, normal::log_density(v) + (high - low).ln()]
            }
            // Counts; the others are formulas.
            _ => [f64::NAN; 2],
        }
    }
}
