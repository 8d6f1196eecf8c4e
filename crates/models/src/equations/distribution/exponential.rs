//! The exponential distribution.

use crate::equations::draw::{Needs, Source};
use crate::equations::family::{Family, above_zero, inside, parameters, zero_or_nan};
use crate::equations::quantile::{Quantile, beyond, normal, sign_of, transported};
use crate::equations::scalar::Scalar;

parameters! {
    /// `origin + mean·E` of a standard exponential `E`: [`exponential`](super::distributions::exponential).
    Exponential {
        /// The end of its range.
        origin,
        /// The distance of its mean from there; below 0 where it lies below its origin.
        mean,
    }
}

impl<S: Scalar> Exponential<S> {
    #[inline(always)]
    pub(super) fn new(mean: S) -> Self {
        Exponential { origin: S::from(0.0), mean }.guarded()
    }
}

impl<S: Scalar> Family<S> for Exponential<S> {
    const NEEDS: Needs = Needs::EXPONENTIAL;

    #[inline(always)]
    fn guarded(self) -> Self {
        Exponential { origin: self.origin, mean: above_zero(self.mean) }
    }

    #[inline(always)]
    fn affine(self, shift: S, scale: S, size: S) -> Self {
        Exponential { origin: self.origin * scale + shift, mean: self.mean * scale + zero_or_nan(size) }
    }

    #[inline(always)]
    fn log_density(self, x: S, _: impl FnOnce() -> S) -> S {
        let z = (x - self.origin) / self.mean;
        inside(z, -z - self.mean.abs().ln())
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        self.origin + self.mean * source.exponential()
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        [self.origin + self.mean, self.mean * self.mean]
    }

    fn to_normal(self, x: S) -> S {
        let z = ((x - self.origin) / self.mean).max(S::from(0.0));
        sign_of(self.mean) * transported([z], |[z]| normal::from_log_upper(-z), |[z]| -z)
    }
}

impl Quantile for Exponential<f64> {
    fn transport(self, v: f64) -> [f64; 2] {
        let v = v * self.mean.signum();
        let z = -normal::log_upper(v);
        [self.origin + self.mean * z, normal::log_density(v) + z + Scalar::ln(self.mean.abs())]
    }

    fn ends(self) -> [f64; 2] {
        beyond(self.origin, self.mean)
    }
}
