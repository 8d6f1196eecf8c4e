//! The binomial distribution.

use crate::equations::draw::{Needs, Rejection, Source, Successes};
use crate::equations::family::{Family, at_count, inside, parameters, times_log};
use crate::equations::quantile::{Count, Quantile, count, counts};
use crate::equations::scalar::Scalar;

parameters! {
    /// The parameters of [`binomial`](super::distributions::binomial).
    Binomial {
        /// The number of trials, an integer of at least 0.
        n,
        /// The probability of success.
        p,
    }
}

impl<S: Scalar> Binomial<S> {
    #[inline(always)]
    pub(super) fn new(n: S, p: S) -> Self {
        Binomial { n, p }
    }
}

impl<S: Scalar> Family<S> for Binomial<S> {
    const IS_DISCRETE: bool = true;
    const NEEDS: Needs = Successes::NEEDS;

    #[inline(always)]
    fn guarded(self) -> Self {
        self
    }

    #[inline(always)]
    fn affine(self, _: S, _: S, _: S) -> Self {
        Binomial { n: self.n, p: S::from(f64::NAN) }
    }

    #[inline(always)]
    fn log_density(self, x: S, log_factorial: impl FnOnce() -> S) -> S {
        let Binomial { n, p } = self;
        let failures = n - x;
        let choices = (n + 1.0).ln_gamma() - log_factorial() - (failures + 1.0).ln_gamma();
        let density = choices + times_log(x, p) + times_log(failures, -p + 1.0);
        let is_count = n - n.floor();
        let density = is_count.where_positive(S::from(f64::NAN), density);
        at_count(x, inside(failures, density))
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        source.by::<Successes>(self.n, self.p)
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        [self.n * self.p, self.n * self.p * (-self.p + 1.0)]
    }

    fn count_mass(self, low: S, high: S) -> S {
        S::custom(
            [self.n, self.p, low, high],
            |[n, p, low, high]| count::log_mass(Binomial { n, p }, low, high),
            |[n, p, low, high], mass| {
                let by_p = |count: f64| -(n - count) / (1.0 - p);
                [0.0, count::slope(Binomial { n, p }, [low, high], mass, by_p), 0.0, 0.0]
            },
        )
    }

    fn to_normal(self, _: S) -> S {
        S::from(f64::NAN)
    }
}

/// From here on not every integer is a number.
const LARGEST: f64 = (1_u64 << 53) as f64;

impl Count for Binomial<f64> {
    fn is_possible(self) -> bool {
        let Binomial { n, p } = self;
        (0.0..=LARGEST).contains(&n) && n.fract() == 0.0 && (0.0..=1.0).contains(&p)
    }

    fn ratio(self, n: f64) -> f64 {
        (self.n - n) / (n + 1.0) * (self.p / (1.0 - self.p))
    }

    fn last(self) -> f64 {
        self.n
    }

    fn is_certain(self) -> bool {
        self.n == 0.0 || self.p == 0.0 || self.p == 1.0
    }
}

impl Quantile for Binomial<f64> {
    counts!();
}
