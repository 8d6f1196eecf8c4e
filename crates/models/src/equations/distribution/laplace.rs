//! Laplace's distribution.

use std::f64::consts::LN_2;

use crate::equations::draw::{Needs, Source};
use crate::equations::family::{Family, Score, above_zero, parameters};
use crate::equations::quantile::{Quantile, normal, transported};
use crate::equations::scalar::Scalar;

parameters! {
    /// The parameters of [`laplace`](super::distributions::laplace).
    Laplace {
        /// Its centre.
        location,
        /// Its scale, above 0.
        scale,
    }
}

impl<S: Scalar> Laplace<S> {
    #[inline(always)]
    pub(super) fn new(location: S, scale: S) -> Self {
        Laplace { location, scale }.guarded()
    }
}

impl<S: Scalar> Family<S> for Laplace<S> {
    const NEEDS: Needs = Needs { exponentials: 2, ..Needs::NOTHING };

    #[inline(always)]
    fn guarded(self) -> Self {
        Laplace { location: self.location, scale: above_zero(self.scale) }
    }

    #[inline(always)]
    fn affine(self, shift: S, scale: S, size: S) -> Self {
        Laplace { location: self.location * scale + shift, scale: self.scale * size }
    }

    #[inline(always)]
    fn log_density(self, x: S, _: impl FnOnce() -> S) -> S {
        -((x - self.location) / self.scale).abs() - self.scale.ln() - LN_2
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        let up = source.exponential();
        self.location + self.scale * (up - source.exponential())
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        [self.location, self.scale * self.scale * 2.0]
    }

    #[inline(always)]
    fn score(self, y: S) -> Score<S> {
        let (one, rest) = (S::from(1.0), y - self.location);
        let sign = rest.where_positive(one, (-rest).where_positive(-one, S::from(0.0)));
        // That of the normal distribution of this slope, far out.
        let information = (one / self.scale).min(one / rest.abs()) / self.scale;
        Score { location: self.location, slope: sign / self.scale, information }
    }

    #[inline(always)]
    fn spread(self) -> Option<[S; 2]> {
        Some([self.scale.ln(), S::from(1.0)])
    }

    fn to_normal(self, x: S) -> S {
        let z = (x - self.location) / self.scale;
        let of = |[z]: [f64; 1]| normal::from_log_upper(-z.abs() - LN_2).copysign(z);
        transported([z], of, |[z]| -z.abs() - LN_2)
    }
}

impl Quantile for Laplace<f64> {
    fn transport(self, v: f64) -> [f64; 2] {
        let depth = normal::depth(v.abs());
        let log_slope = normal::log_density(v) + depth + LN_2 + Scalar::ln(self.scale);
        [self.location + self.scale * depth.copysign(v), log_slope]
    }
}
