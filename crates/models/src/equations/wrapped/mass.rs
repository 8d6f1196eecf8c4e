//! The probability of an interval, by logarithms: neither tail loses digits.

use super::Wrapped;
use super::logs::log_sum;
use crate::equations::scalar::Scalar;

impl<S: Scalar> Wrapped<'_, S> {
    /// `log P(low < Y ≤ high)`; NaN where there is no distribution function.
    pub(super) fn log_mass(&self, low: S, high: S) -> S {
        let (nothing, everything) = (S::from(f64::NEG_INFINITY), S::from(f64::INFINITY));
        match *self {
            Wrapped::Plain(distribution) => distribution.log_mass(low, high),
            Wrapped::Rounded(of) => of.log_mass(low.floor() + 0.5, high.floor() + 0.5),
            Wrapped::Censored { low: first, high: last, of } => {
                // All that lies below the first number counts where this one does, and so for the last.
                let from = beyond(first, low).where_positive(nothing, low);
                let to = beyond(last, high).where_positive(high, everything);
                let mass = of.log_mass(from, to);
                let is_some = beyond(first, high).where_positive(nothing, mass);
                beyond(last, low).where_positive(is_some, nothing)
            }
            Wrapped::Truncated { low: first, high: last, of } => {
                let before = of.before(first);
                of.log_mass(low.max(before), high.min(last)) - of.log_mass(before, last)
            }
            Wrapped::ZeroInflated { p, of } => {
                let others = (-p + 1.0).ln() + of.log_mass(low, high);
                let with_zero = log_sum(p.ln(), others);
                (-low).where_positive((-high).where_positive(others, with_zero), others)
            }
            Wrapped::Mixture { weight, first, second } => {
                let masses = [first, second].map(|of| of.log_mass(low, high));
                log_sum(weight.ln() + masses[0], (-weight + 1.0).ln() + masses[1])
            }
            Wrapped::Floored { .. }
            | Wrapped::VonMises { .. }
            | Wrapped::Categorical(_)
            | Wrapped::LogDensity(_) => S::from(f64::NAN),
        }
    }
}

/// Above 0 where `a` lies above `b`, infinite as they may be.
fn beyond<S: Scalar>(a: S, b: S) -> S {
    let [a, b] = [a, b].map(|end| end.max(S::from(f64::MIN)).min(S::from(f64::MAX)));
    a - b
}
