//! What a family of distributions is: its density, how it is drawn, its moments, and how normal noise becomes it.

use super::draw::{Needs, Source};
use super::scalar::Scalar;

/// What an observation says of a distribution's location `θ`: the mean of counts and of positive numbers, the mean of the logarithm where that
/// is normal, the centre elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score<S> {
    /// `θ`, up to a constant that no state changes.
    pub location: S,
    /// `∂ log p(y | θ) / ∂θ`.
    pub slope: S,
    /// The Fisher information of `θ`; the inverse variance where the end of the range moves with `θ`, and it has none. Of heavy tails it is at most `s/(y − θ)` of the slope `s`: a normal
    /// distribution of that slope has this information, and one of more would hold the state where it is, as if an outlier said so.
    pub information: S,
}

/// A family with its parameters: all that a distribution of one number is asked. Each has a file of its own beside `distribution.rs`, which lists them.
///
/// What is out of range is NaN: in parameters, and in all that follows from them.
pub(in crate::equations) trait Family<S: Scalar>: Copy {
    /// Whether it is one of counts, which can be neither shifted nor scaled.
    const IS_DISCRETE: bool = false;

    /// What a draw takes of the numbers that are drawn in bulk.
    const NEEDS: Needs = Needs::NOTHING;

    /// The same with parameters that are NaN where they are out of range.
    fn guarded(self) -> Self;

    /// That of `shift + scale·x`, where `size` is `|scale|`, and NaN for a scale of 0. Of counts a parameter becomes NaN.
    fn affine(self, shift: S, scale: S, size: S) -> Self;

    /// `log p(x)`; −∞ outside the support. `log_factorial` is `log x!`, for who needs it.
    fn log_density(self, x: S, log_factorial: impl FnOnce() -> S) -> S;

    /// A draw.
    fn draw(self, source: &mut impl Source<S>) -> S;

    /// Mean and variance; location and squared scale where the variance is infinite.
    fn moments(self) -> [S; 2];

    /// What the observation `y` says of the location, which is the mean here.
    #[inline(always)]
    fn score(self, y: S) -> Score<S> {
        let [mean, variance] = self.moments();
        let information = S::from(1.0) / variance;
        Score { location: mean, slope: (y - mean) * information, information }
    }

    /// The logarithm of a scale that does not change the location, and its Fisher information; none of families whose scale follows from the location.
    #[inline(always)]
    fn spread(self) -> Option<[S; 2]> {
        None
    }

    /// `T(v) = F⁻¹(Φ(v))` and `log T′(v)` where these are formulas of `v`; none of others.
    #[inline(always)]
    fn formula(self, _v: S) -> Option<[S; 2]> {
        None
    }

    /// `log P(low < X ≤ high)` of counts; NaN for what has quantiles.
    fn count_mass(self, _low: S, _high: S) -> S {
        S::from(f64::NAN)
    }

    /// `T⁻¹(x)`, the standard normal quantile of `x`: infinite at and beyond the ends of the range. NaN for counts.
    fn to_normal(self, x: S) -> S;
}

/// Declares a family's parameters, and how they become parameters of another kind.
macro_rules! parameters {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $parameter:ident,)+ }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name<S> {
            $($(#[$doc])* pub $parameter: S,)+
        }

        impl<S> $name<S> {
            #[inline(always)]
            pub(in crate::equations) fn map<T>(&self, of: impl Fn(&S) -> T) -> $name<T> {
                $name { $($parameter: of(&self.$parameter),)+ }
            }
        }
    };
}

pub(in crate::equations) use parameters;

/// NaN where `value` is not above 0.
#[inline(always)]
pub(super) fn above_zero<S: Scalar>(value: S) -> S {
    value.where_positive(value, S::from(f64::NAN))
}

/// 0, or NaN where `value` is NaN.
#[inline(always)]
pub(super) fn zero_or_nan<S: Scalar>(value: S) -> S {
    value.where_positive(S::from(0.0), S::from(0.0))
}

/// `density` where `depth` is at least 0, else −∞.
#[inline(always)]
pub(super) fn inside<S: Scalar>(depth: S, density: S) -> S {
    (-depth).where_positive(S::from(f64::NEG_INFINITY), density)
}

/// `factor·log value`, and 0 for a factor of 0 whatever the logarithm is; NaN for a value below 0.
#[inline(always)]
pub(super) fn times_log<S: Scalar>(factor: S, value: S) -> S {
    let zero = value.max(S::from(0.0)) - value;
    factor.abs().where_positive(factor * value.ln(), zero.where_positive(S::from(f64::NAN), S::from(0.0)))
}

/// From where on a size, or a number of trials, is so large beside what is `expected` and counted that a distribution is nearly that of its limit: what is left out of two terms of the
/// expansion is below a millionth, as are digits that logarithms of gamma functions lose below.
#[inline(always)]
pub(super) fn first_large<S: Scalar>(expected: S) -> S {
    (expected * expected.max(S::from(0.0)).sqrt() * 1e3).max(S::from(1e8))
}

/// `density` where `count` is 0, 1, 2, …, else −∞.
#[inline(always)]
pub(super) fn at_count<S: Scalar>(count: S, density: S) -> S {
    let off = (count - count.floor()).abs();
    let density = off.where_positive(S::from(f64::NEG_INFINITY), density);
    inside(count, density)
}

/// Larger means of counts are taken for this one, which no sum overflows with.
pub(super) const MOST_EXPECTED: f64 = 1e300;
