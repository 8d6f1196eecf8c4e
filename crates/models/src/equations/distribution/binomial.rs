//! The binomial distribution.

use std::f64::consts::PI;

use crate::elementary;
use crate::equations::draw::{Needs, Rejection, Source, Successes};
use crate::equations::family::{Family, at_count, first_large, inside, parameters, times_log};
use crate::equations::quantile::near_normal::{self, NearNormal, bend, deviance};
use crate::equations::quantile::{Count, Quantile, count};
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
        let log_factorial = log_factorial();
        let choices = (n + 1.0).ln_gamma() - log_factorial - (failures + 1.0).ln_gamma();
        // Logarithms of many trials cancel each other; of few successes among them it is nearly Poisson.
        let mean = n * p;
        let poisson = times_log(x, mean) - mean - log_factorial;
        let nearly = poisson + x * p - (x * (x - 1.0) / n + mean * p) * 0.5;
        let density = choices + times_log(x, p) + times_log(failures, -p + 1.0);
        let density = (n - first_large(x + mean)).where_positive(nearly, density);
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

impl Count for Binomial<f64> {
    fn is_possible(self) -> bool {
        let Binomial { n, p } = self;
        (0.0..=count::LARGEST).contains(&n) && n.fract() == 0.0 && (0.0..=1.0).contains(&p)
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

impl NearNormal for Binomial<f64> {
    const FACTORIALS: usize = 3;

    #[inline(always)]
    fn boundary(self, n: f64) -> f64 {
        let Binomial { n: trials, p } = self;
        let q = 1.0 - p;
        let (mean, failures) = (trials * p, trials * q);
        let half = n + 0.5;
        let away = half - mean;
        let ends = q / (n + 1.0) - p / (trials - n) + (q - 0.5) / (trials + 1.0);
        let from = n + 2.0 / 3.0 - (trials + 1.0 / 3.0) * p + 0.02 * ends;
        let bend_up = bend(away / mean, half / mean) / mean;
        let bend_down = bend(-away / failures, (trials - half) / failures) / failures;
        from * ((bend_up + bend_down) * (6.0 * trials) / (6.0 * trials + 1.0)).sqrt()
    }

    #[inline(always)]
    fn fewest(self) -> f64 {
        let [successes, failures] = [self.n * self.p, self.n * (1.0 - self.p)];
        if successes < failures { successes } else { failures }
    }

    #[inline(always)]
    fn factorials(self, n: f64) -> [f64; 3] {
        [n - 1.0, self.n - n - 1.0, self.n - 1.0]
    }

    #[inline(always)]
    fn log_probability_by(self, n: f64, [of_count, of_rest, of_all]: [f64; 3]) -> f64 {
        let Binomial { n: trials, p } = self;
        let (q, rest) = (1.0 - p, trials - n);
        let away = deviance(n, trials * p) + deviance(rest, trials * q);
        let some = of_all - of_count - of_rest - away - 0.5 * elementary::ln(2.0 * PI * n * (rest / trials));
        let none = trials * elementary::ln_1p(-p);
        let all = trials * elementary::ln(p);
        let some = if rest > 0.0 { some } else { all };
        if n > 0.0 { some } else { none }
    }
}

impl Quantile for Binomial<f64> {
    fn value_at(self, v: f64) -> f64 {
        near_normal::from_normal(self, v)
    }

    fn ends(self) -> [f64; 2] {
        [0.0, self.last()]
    }
}
