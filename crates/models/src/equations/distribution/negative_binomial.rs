//! The negative binomial distribution.

use crate::equations::draw::{Events, Needs, Rejection, Source, StandardGamma};
use crate::equations::family::{
    Family, MOST_EXPECTED, above_zero, at_count, first_large, parameters, times_log,
};
use crate::equations::quantile::{Count, Quantile, count, difference};
use crate::equations::scalar::Scalar;

parameters! {
    /// The parameters of [`negative_binomial`](super::distributions::negative_binomial).
    NegativeBinomial {
        /// Its mean, at least 0.
        mean,
        /// Its size, above 0.
        size,
    }
}

impl<S: Scalar> NegativeBinomial<S> {
    #[inline(always)]
    pub(super) fn new(mean: S, size: S) -> Self {
        NegativeBinomial { mean, size }.guarded()
    }
}

impl<S: Scalar> Family<S> for NegativeBinomial<S> {
    const IS_DISCRETE: bool = true;
    const NEEDS: Needs = StandardGamma::NEEDS.plus(Events::NEEDS);

    #[inline(always)]
    fn guarded(self) -> Self {
        NegativeBinomial { mean: self.mean, size: above_zero(self.size) }
    }

    #[inline(always)]
    fn affine(self, _: S, _: S, _: S) -> Self {
        NegativeBinomial { mean: S::from(f64::NAN), size: self.size }
    }

    #[inline(always)]
    fn log_density(self, x: S, log_factorial: impl FnOnce() -> S) -> S {
        let (mean, size) = (self.mean.min(S::from(MOST_EXPECTED)), self.size);
        let whole = mean + size;
        let log_factorial = log_factorial();
        let density = (x + size).ln_gamma() - size.ln_gamma() - log_factorial
            + times_log(x, mean / whole)
            + size * (size / whole).ln();
        // Logarithms of a large size cancel each other; there it is nearly Poisson.
        let poisson = times_log(x, mean) - mean - log_factorial;
        let nearly = poisson + ((x - mean) * (x - mean) - x) * 0.5 / size;
        let density = (size - first_large(x + mean)).where_positive(nearly, density);
        at_count(x, density)
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        let of_size = source.by::<StandardGamma>(self.size, self.size);
        let mean = self.mean / self.size * of_size;
        source.by::<Events>(mean, mean)
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        [self.mean, self.mean + self.mean * self.mean / self.size]
    }

    fn count_mass(self, low: S, high: S) -> S {
        let of =
            |[mean, size, low, high]: [f64; 4]| count::log_mass(NegativeBinomial { mean, size }, low, high);
        S::custom([self.mean, self.size, low, high], of, |at, mass| {
            let [mean, size, low, high] = at;
            let by_mean = |n: f64| -(size + n) / (size + mean);
            let counts = NegativeBinomial { mean, size };
            // Along the size there is no formula.
            [count::slope(counts, [low, high], mass, by_mean), difference(at, 1, of), 0.0, 0.0]
        })
    }

    fn to_normal(self, _: S) -> S {
        S::from(f64::NAN)
    }
}

impl Count for NegativeBinomial<f64> {
    fn ratio(self, n: f64) -> f64 {
        (n + self.size) / (n + 1.0) * (self.mean / (self.mean + self.size))
    }

    fn is_certain(self) -> bool {
        self.mean == 0.0 && self.size > 0.0
    }
}

impl Quantile for NegativeBinomial<f64> {
    fn value_at(self, v: f64) -> f64 {
        count::from_normal(self, v)
    }

    fn ends(self) -> [f64; 2] {
        [0.0, self.last()]
    }
}
