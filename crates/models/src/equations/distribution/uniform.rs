//! The uniform distribution.

use crate::equations::draw::{Needs, Source};
use crate::equations::family::{Family, above_zero, inside, parameters, zero_or_nan};
use crate::equations::quantile::{Quantile, normal, transported};
use crate::equations::scalar::Scalar;

parameters! {
    /// The parameters of [`uniform`](super::distributions::uniform).
    Uniform {
        /// Its lower end.
        low,
        /// Its upper end.
        high,
    }
}

impl<S: Scalar> Uniform<S> {
    #[inline(always)]
    pub(super) fn new(low: S, high: S) -> Self {
        Uniform { low, high }.guarded()
    }
}

impl<S: Scalar> Family<S> for Uniform<S> {
    const NEEDS: Needs = Needs::UNIFORM;

    #[inline(always)]
    fn guarded(self) -> Self {
        let Uniform { low, high } = self;
        // The width is NaN where the ends are the wrong way round.
        Uniform { low, high: low + above_zero(high - low) }
    }

    #[inline(always)]
    fn affine(self, shift: S, scale: S, size: S) -> Self {
        let (a, b) = (self.low * scale + shift, self.high * scale + shift);
        Uniform { low: a.min(b) + zero_or_nan(size), high: a.max(b) }
    }

    #[inline(always)]
    fn log_density(self, x: S, _: impl FnOnce() -> S) -> S {
        let depth = (x - self.low).min(self.high - x);
        inside(depth, -(self.high - self.low).ln())
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        self.low + (self.high - self.low) * source.uniform()
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        let width = self.high - self.low;
        [(self.low + self.high) * 0.5, width * width / 12.0]
    }

    fn to_normal(self, x: S) -> S {
        let (zero, width) = (S::from(0.0), self.high - self.low);
        let [below, above] = [(x - self.low) / width, (self.high - x) / width].map(|share| share.max(zero));
        // Each half from its own end: what it is made of is the smaller share.
        let of_lower =
            |share: S| transported([share], |[share]| -normal::from_log_upper(Scalar::ln(share)), |_| 0.0);
        (above - below).where_positive(of_lower(below), -of_lower(above))
    }
}

impl Quantile for Uniform<f64> {
    fn transport(self, v: f64) -> [f64; 2] {
        let share = (self.high - self.low) * normal::upper(v.abs());
        let x = if v < 0.0 { self.low + share } else { self.high - share };
        [x, normal::log_density(v) + Scalar::ln(self.high - self.low)]
    }

    fn ends(self) -> [f64; 2] {
        [self.low, self.high]
    }
}
