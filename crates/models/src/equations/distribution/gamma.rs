//! The gamma distribution.

use crate::equations::draw::{Needs, Rejection, Source, StandardGamma};
use crate::equations::family::{Family, above_zero, parameters, zero_or_nan};
use crate::equations::quantile::{Quantile, beyond, gamma, sign_of, transported};
use crate::equations::scalar::Scalar;

parameters! {
    /// `origin + scale·G` of a standard gamma `G`: [`gamma`](super::distributions::gamma).
    Gamma {
        /// The end of its range.
        origin,
        /// Its shape, above 0.
        shape,
        /// Its scale; below 0 where it lies below its origin.
        scale,
    }
}

impl<S: Scalar> Gamma<S> {
    #[inline(always)]
    pub(super) fn new(shape: S, scale: S) -> Self {
        Gamma { origin: S::from(0.0), shape, scale }.guarded()
    }
}

impl<S: Scalar> Family<S> for Gamma<S> {
    const NEEDS: Needs = StandardGamma::NEEDS;

    #[inline(always)]
    fn guarded(self) -> Self {
        Gamma { origin: self.origin, shape: above_zero(self.shape), scale: above_zero(self.scale) }
    }

    #[inline(always)]
    fn affine(self, shift: S, scale: S, size: S) -> Self {
        Gamma {
            origin: self.origin * scale + shift,
            shape: self.shape,
            scale: self.scale * scale + zero_or_nan(size),
        }
    }

    #[inline(always)]
    fn log_density(self, x: S, _: impl FnOnce() -> S) -> S {
        let Gamma { origin, shape, scale } = self;
        let z = (x - origin) / scale;
        let density = (shape - 1.0) * z.ln() - z - shape.ln_gamma() - scale.abs().ln();
        z.where_positive(density, S::from(f64::NEG_INFINITY)) + zero_or_nan(shape)
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        self.origin + self.scale * source.by::<StandardGamma>(self.shape, self.shape)
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        [self.origin + self.shape * self.scale, self.shape * self.scale * self.scale]
    }

    fn to_normal(self, x: S) -> S {
        let z = (x - self.origin) / self.scale;
        let density = |[z, shape]: [f64; 2]| Gamma { origin: 0.0, shape, scale: 1.0 }.log_density(z, || z);
        sign_of(self.scale) * transported([z, self.shape], |[z, shape]| gamma::to_normal(shape, z), density)
    }
}

impl Quantile for Gamma<f64> {
    fn transport(self, v: f64) -> [f64; 2] {
        let [log, log_slope] = gamma::from_normal(self.shape, v * self.scale.signum());
        [self.origin + self.scale * Scalar::exp(log), log_slope + Scalar::ln(self.scale.abs())]
    }

    fn ends(self) -> [f64; 2] {
        beyond(self.origin, self.scale)
    }
}
