//! The Poisson distribution.

use std::f64::consts::PI;

use crate::elementary;
use crate::equations::draw::{Events, Needs, Rejection, Source};
use crate::equations::family::{Family, MOST_EXPECTED, at_count, parameters, times_log};
use crate::equations::quantile::near_normal::{self, NearNormal, bend, deviance};
use crate::equations::quantile::{Count, Quantile, count};
use crate::equations::scalar::Scalar;

parameters! {
    /// The parameters of [`poisson`](super::distributions::poisson).
    Poisson {
        /// Its mean, at least 0.
        mean,
    }
}

impl<S: Scalar> Poisson<S> {
    #[inline(always)]
    pub(super) fn new(mean: S) -> Self {
        Poisson { mean }
    }
}

impl<S: Scalar> Family<S> for Poisson<S> {
    const IS_DISCRETE: bool = true;
    const NEEDS: Needs = Events::NEEDS;

    #[inline(always)]
    fn guarded(self) -> Self {
        self
    }

    #[inline(always)]
    fn affine(self, _: S, _: S, _: S) -> Self {
        Poisson { mean: S::from(f64::NAN) }
    }

    #[inline(always)]
    fn log_density(self, x: S, log_factorial: impl FnOnce() -> S) -> S {
        // Where so many are expected that they are no number, any count is as unlikely as can be.
        let mean = self.mean.min(S::from(MOST_EXPECTED));
        at_count(x, times_log(x, mean) - mean - log_factorial())
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        source.by::<Events>(self.mean, self.mean)
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        [self.mean, self.mean]
    }

    fn count_mass(self, low: S, high: S) -> S {
        S::custom(
            [self.mean, low, high],
            |[mean, low, high]| count::log_mass(Poisson { mean }, low, high),
            |[mean, low, high], mass| [count::slope(Poisson { mean }, [low, high], mass, |_| -1.0), 0.0, 0.0],
        )
    }

    fn to_normal(self, _: S) -> S {
        S::from(f64::NAN)
    }
}

impl Count for Poisson<f64> {
    fn ratio(self, n: f64) -> f64 {
        self.mean / (n + 1.0)
    }

    fn is_certain(self) -> bool {
        self.mean == 0.0
    }
}

impl NearNormal for Poisson<f64> {
    const FACTORIALS: usize = 1;

    #[inline(always)]
    fn boundary(self, n: f64) -> f64 {
        let Poisson { mean } = self;
        let half = n + 0.5;
        let bend = bend((half - mean) / mean, half / mean);
        (n + 2.0 / 3.0 - mean + 0.02 / (n + 1.0)) * (bend / mean).sqrt()
    }

    #[inline(always)]
    fn fewest(self) -> f64 {
        self.mean
    }

    #[inline(always)]
    fn factorials(self, n: f64) -> [f64; 3] {
        [n - 1.0; 3]
    }

    #[inline(always)]
    fn log_probability_by(self, n: f64, [of_count, ..]: [f64; 3]) -> f64 {
        let Poisson { mean } = self;
        let some = -of_count - deviance(n, mean) - 0.5 * elementary::ln(2.0 * PI * n);
        if n > 0.0 { some } else { -mean }
    }
}

impl Quantile for Poisson<f64> {
    fn value_at(self, v: f64) -> f64 {
        near_normal::from_normal(self, v)
    }

    fn ends(self) -> [f64; 2] {
        [0.0, self.last()]
    }
}
