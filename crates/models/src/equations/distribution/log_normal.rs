//! The log-normal distribution.

use crate::equations::draw::{Needs, Source};
use crate::equations::family::{Family, Score, above_zero, parameters, zero_or_nan};
use crate::equations::quantile::{Quantile, beyond};
use crate::equations::scalar::Scalar;
use crate::gaussian::LN_2PI;

parameters! {
    /// `origin + sign·e^z` of a normal `z`: [`log_normal`](super::distributions::log_normal).
    LogNormal {
        /// The end of its range.
        origin,
        /// 1, or −1 where it lies below its origin.
        sign,
        /// The mean of `z`.
        location,
        /// The standard deviation of `z`, above 0.
        scale,
    }
}

impl<S: Scalar> LogNormal<S> {
    #[inline(always)]
    pub(super) fn new(location: S, scale: S) -> Self {
        LogNormal { origin: S::from(0.0), sign: S::from(1.0), location, scale }.guarded()
    }
}

impl<S: Scalar> Family<S> for LogNormal<S> {
    const NEEDS: Needs = Needs::NORMAL;

    #[inline(always)]
    fn guarded(self) -> Self {
        LogNormal { scale: above_zero(self.scale), ..self }
    }

    #[inline(always)]
    fn affine(self, shift: S, scale: S, size: S) -> Self {
        LogNormal {
            origin: self.origin * scale + shift,
            sign: self.sign * (scale / size),
            location: self.location + size.ln(),
            scale: self.scale,
        }
    }

    #[inline(always)]
    fn log_density(self, x: S, _: impl FnOnce() -> S) -> S {
        let size = (x - self.origin) * self.sign;
        let log = size.ln();
        let z = (log - self.location) / self.scale;
        let density = z * z * -0.5 - self.scale.ln() - log - 0.5 * LN_2PI;
        // At its origin the density is 0, which the logarithm of 0 does not give.
        size.where_positive(density, S::from(f64::NEG_INFINITY)) + zero_or_nan(self.scale)
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        self.origin + self.sign * (self.location + self.scale * source.normal()).exp()
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        let square = self.scale * self.scale;
        let mean = (self.location + square * 0.5).exp();
        [self.origin + self.sign * mean, (square.exp() - 1.0) * mean * mean]
    }

    /// The location is that of the logarithm.
    #[inline(always)]
    fn score(self, y: S) -> Score<S> {
        let information = S::from(1.0) / (self.scale * self.scale);
        let location = self.location - ((y - self.origin) * self.sign).ln();
        Score { location, slope: -location * information, information }
    }

    #[inline(always)]
    fn spread(self) -> Option<[S; 2]> {
        Some([self.scale.ln(), S::from(2.0)])
    }

    #[inline(always)]
    fn formula(self, v: S) -> Option<[S; 2]> {
        let log = self.location + self.sign * self.scale * v;
        Some([self.origin + self.sign * log.exp(), log + self.scale.ln()])
    }

    #[inline(always)]
    fn to_normal(self, x: S) -> S {
        let size = ((x - self.origin) * self.sign).max(S::from(0.0));
        self.sign * (size.ln() - self.location) / self.scale
    }
}

impl Quantile for LogNormal<f64> {
    fn ends(self) -> [f64; 2] {
        beyond(self.origin, self.sign)
    }
}
