//! The normal distribution.

use crate::equations::draw::{Needs, Source};
use crate::equations::family::{Family, above_zero, parameters};
use crate::equations::quantile::Quantile;
use crate::equations::scalar::Scalar;
use crate::gaussian::LN_2PI;

parameters! {
    /// The parameters of [`normal`](super::distributions::normal).
    Normal {
        /// Its mean.
        mean,
        /// Its standard deviation, above 0.
        sd,
    }
}

impl<S: Scalar> Normal<S> {
    #[inline(always)]
    pub(super) fn new(mean: S, sd: S) -> Self {
        Normal { mean, sd }.guarded()
    }
}

impl<S: Scalar> Family<S> for Normal<S> {
    const NEEDS: Needs = Needs::NORMAL;

    #[inline(always)]
    fn guarded(self) -> Self {
        Normal { mean: self.mean, sd: above_zero(self.sd) }
    }

    #[inline(always)]
    fn affine(self, shift: S, scale: S, size: S) -> Self {
        Normal { mean: self.mean * scale + shift, sd: self.sd * size }
    }

    #[inline(always)]
    fn log_density(self, x: S, _: impl FnOnce() -> S) -> S {
        let z = (x - self.mean) / self.sd;
        z * z * -0.5 - self.sd.ln() - 0.5 * LN_2PI
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        self.mean + self.sd * source.normal()
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        [self.mean, self.sd * self.sd]
    }

    #[inline(always)]
    fn spread(self) -> Option<[S; 2]> {
        Some([self.sd.ln(), S::from(2.0)])
    }

    #[inline(always)]
    fn formula(self, v: S) -> Option<[S; 2]> {
        Some([self.mean + self.sd * v, self.sd.ln()])
    }

    #[inline(always)]
    fn to_normal(self, x: S) -> S {
        (x - self.mean) / self.sd
    }
}

impl Quantile for Normal<f64> {}
