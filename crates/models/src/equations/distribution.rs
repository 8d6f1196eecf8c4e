//! The distributions of one coordinate, as values: which family, with which parameters.

mod beta;
mod binomial;
mod exponential;
mod gamma;
mod laplace;
mod log_normal;
mod negative_binomial;
mod normal;
mod poisson;
mod student_t;
mod uniform;

use super::draw::{Needs, OneByOne, Source};
use super::family::{Family, Score, above_zero};
use super::lanes::Lanes;
use super::quantile::{GuidedNoise, Quantile, count, guided, normal_mass};
use super::scalar::Scalar;
use crate::Stream;

pub use {
    beta::Beta, binomial::Binomial, exponential::Exponential, gamma::Gamma, laplace::Laplace,
    log_normal::LogNormal, negative_binomial::NegativeBinomial, normal::Normal, poisson::Poisson,
    student_t::StudentT, uniform::Uniform,
};

/// The families, each with the function that makes it and the parameters of this function.
macro_rules! families {
    ($d:tt $($(#[$about:meta])* $family:ident = $name:ident($($parameter:ident),+);)+) => {
        /// A distribution of one number, whose parameters may depend on the states.
        ///
        /// Any but those of counts can be scaled and then shifted: `exponential(1.0).scaled(3.0).shifted(-3.0)`. Where a parameter is out of range or NaN,
        /// densities and draws are NaN.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Distribution<S> {
            $(
                #[doc = concat!("[`", stringify!($name), "`](distributions::", stringify!($name), ").")]
                $family($family<S>),
            )+
        }

        /// The functions that make distributions.
        pub mod distributions {
            use super::{Binomial, Distribution, Scalar};

            $(
                $(#[$about])*
                #[inline(always)]
                pub fn $name<S: Scalar>($($parameter: impl Into<S>),+) -> Distribution<S> {
                    Distribution::$family(super::$family::new($($parameter.into()),+))
                }
            )+

            /// 1 with probability `p`, else 0.
            #[inline(always)]
            pub fn bernoulli<S: Scalar>(p: impl Into<S>) -> Distribution<S> {
                Distribution::Binomial(Binomial { n: S::from(1.0), p: p.into() })
            }
        }

        impl<S> Distribution<S> {
            /// Whether it is one of counts, which can be neither shifted nor scaled.
            #[inline(always)]
            pub fn is_discrete(&self) -> bool {
                match self {
                    $(Distribution::$family(_) => <$family<f64> as Family<f64>>::IS_DISCRETE,)+
                }
            }

            /// What one draw takes.
            #[inline(always)]
            pub(super) fn needs(&self) -> Needs {
                match self {
                    $(Distribution::$family(_) => <$family<f64> as Family<f64>>::NEEDS,)+
                }
            }

            /// The same family with each parameter replaced by what `of` makes of it.
            #[inline(always)]
            pub fn map<T>(&self, of: impl Fn(&S) -> T) -> Distribution<T> {
                match self {
                    $(Distribution::$family(family) => Distribution::$family(family.map(of)),)+
                }
            }
        }

        /// What is said of the family of a distribution.
        macro_rules! of_family {
            ($d distribution:expr, $d family:ident => $d found:expr) => {
                match $d distribution {
                    $(Distribution::$family($d family) => $d found,)+
                }
            };
        }

        /// The distribution of what is said of the family of another.
        macro_rules! same_family {
            ($d distribution:expr, $d family:ident => $d found:expr) => {
                match $d distribution {
                    $(Distribution::$family($d family) => Distribution::$family($d found),)+
                }
            };
        }
    };
}

families! { $
    /// `N(mean, sd²)`: `−½ ((x − mean)/sd)² − log sd − ½ log 2π`.
    Normal = normal(mean, sd);
    /// Student's t with `df` degrees of freedom: `z = (x − location)/scale` has the density
    /// `Γ((df+1)/2) / (Γ(df/2) √(df π)) · (1 + z²/df)^{−(df+1)/2}`.
    StudentT = student_t(df, location, scale);
    /// Laplace's distribution: `−|x − location|/scale − log 2 scale`. Its standard deviation is `√2·scale`.
    Laplace = laplace(location, scale);
    /// That of `e^z` for `z ~ N(location, scale²)`.
    LogNormal = log_normal(location, scale);
    /// The exponential distribution: `−x/mean − log mean` for `x ≥ 0`.
    Exponential = exponential(mean);
    /// The gamma distribution with mean `shape·scale`: `(shape − 1) log x − x/scale − log Γ(shape) − shape log scale` for `x > 0`.
    Gamma = gamma(shape, scale);
    /// The beta distribution on `[0, 1]`: `(a − 1) log x + (b − 1) log(1 − x) − log B(a, b)`. Its mean is `a/(a + b)`.
    Beta = beta(a, b);
    /// Uniform on `[low, high]`.
    Uniform = uniform(low, high);
    /// The number of events where `mean` are expected: `k log mean − mean − log k!` for `k = 0, 1, …`.
    Poisson = poisson(mean);
    /// Counts with the given mean and the variance `mean + mean²/size`: a Poisson distribution whose mean is a gamma of shape `size`.
    NegativeBinomial = negative_binomial(mean, size);
    /// The number of successes in `n` trials with probability `p` each.
    Binomial = binomial(n, p);
}

impl<S: Scalar> Distribution<S> {
    /// That of `x + by`. Counts cannot be shifted: a parameter becomes NaN.
    #[inline(always)]
    #[must_use]
    pub fn shifted(self, by: impl Into<S>) -> Self {
        self.affine(by.into(), S::from(1.0))
    }

    /// That of `by·x`. A factor of 0 is out of range, and counts cannot be scaled: a parameter becomes NaN.
    #[inline(always)]
    #[must_use]
    pub fn scaled(self, by: impl Into<S>) -> Self {
        self.affine(S::from(0.0), by.into())
    }

    /// That of `shift + scale·x`.
    #[inline(always)]
    fn affine(self, shift: S, scale: S) -> Self {
        // NaN for a scale of 0.
        let size = above_zero(scale.abs());
        same_family!(self, family => family.affine(shift, scale, size))
    }

    /// The same with parameters that are NaN where they are out of range: for what was not made by the functions of [`distributions`].
    #[inline(always)]
    #[must_use]
    pub fn guarded(self) -> Self {
        same_family!(self, family => family.guarded())
    }

    /// `log p(x)`; −∞ outside the support, NaN where a parameter is out of range.
    #[inline(always)]
    pub fn log_density(&self, x: S) -> S {
        of_family!(*self, family => family.log_density(x, || (x + 1.0).ln_gamma()))
    }

    /// `log p(x)` of a number that is the same for all, as a measurement.
    #[inline(always)]
    pub(crate) fn log_density_of_one(&self, x: f64) -> S {
        of_family!(*self, family => family.log_density(S::from(x), || S::from(Scalar::ln_gamma(x + 1.0))))
    }

    /// A draw; NaN where a parameter is out of range.
    #[inline(always)]
    pub(super) fn draw(&self, source: &mut impl Source<S>) -> S {
        of_family!(*self, family => family.draw(source))
    }

    /// Mean and variance; location and squared scale where the variance is infinite.
    #[inline(always)]
    pub fn moments(&self) -> [S; 2] {
        of_family!(*self, family => family.moments())
    }

    /// What the observation `y` says of the location.
    #[inline(always)]
    pub fn score(&self, y: S) -> Score<S> {
        of_family!(*self, family => family.score(y))
    }

    /// The logarithm of the scale and its Fisher information, of families that have a scale beside their location.
    #[inline(always)]
    pub(super) fn spread(&self) -> Option<[S; 2]> {
        of_family!(*self, family => family.spread())
    }

    /// `T(v)` and `log T′(v)` of the families that are formulas of a normal number, and nothing of others.
    #[inline(always)]
    pub(super) fn formula(&self, v: S) -> Option<[S; 2]> {
        of_family!(*self, family => family.formula(v))
    }

    /// `T⁻¹(x)`: the standard normal quantile of `x`; −∞ and +∞ at and beyond the ends of the range.
    ///
    /// NaN for counts, and where a parameter is out of range.
    #[inline(always)]
    pub fn to_normal(&self, x: S) -> S {
        of_family!(*self, family => family.to_normal(x))
    }

    /// `log P(low < X ≤ high)`, where the ends may be infinite; −∞ where nothing lies there, NaN where a parameter is out of range.
    ///
    /// ```
    /// use motes_models::equations::{Distribution, normal};
    ///
    /// let far: Distribution<f64> = normal(0.0, 1.0);
    /// assert!((far.log_mass(40.0, 41.0) - -804.608442).abs() < 1e-6);
    /// ```
    pub fn log_mass(&self, low: S, high: S) -> S {
        if self.is_discrete() {
            return of_family!(*self, family => family.count_mass(low, high));
        }
        // Of nearly the same numbers the density in the middle is as good, and there is no difference to take.
        let ends = [low, high].map(|end| self.to_normal(end));
        let mass = normal_mass(ends);
        let [from, to] = ends.map(|v| v.max(S::from(-1e100)).min(S::from(1e100)));
        let width = high - low;
        let is_narrow = ((from - to) * from.abs().max(S::from(1.0)) + NARROW).min(-width + 1e300);
        is_narrow.where_positive(self.log_density((low + high) * 0.5) + width.ln(), mass)
    }
}

/// The width in standard deviations below which an interval is taken for its middle: by then a difference has as few digits.
const NARROW: f64 = 3e-5;

impl Distribution<f64> {
    /// Draws a number; NaN where a parameter is out of range.
    pub fn sample(&self, stream: &mut Stream) -> f64 {
        self.draw(&mut OneByOne(stream))
    }

    /// `T(v) = F⁻¹(Φ(v))`: what has this distribution where `v` is standard normal. It grows with `v`.
    ///
    /// Of counts it is the smallest whose distribution function reaches `Φ(v)`. NaN where a parameter is out of range. Each tail is computed from its own end of the
    /// range, so neither loses digits.
    ///
    /// ```
    /// use motes_models::equations::{Distribution, exponential, normal};
    ///
    /// let [position, delay]: [Distribution<f64>; 2] = [normal(1.0, 0.5), exponential(2.0)];
    /// assert_eq!(position.from_normal(-3.0), -0.5);
    /// // The median of the exponential distribution is log 2 of its mean.
    /// assert!((delay.from_normal(0.0) - 2.0 * 2.0_f64.ln()).abs() < 1e-15);
    /// ```
    pub fn from_normal(&self, v: f64) -> f64 {
        of_family!(*self, family => family.value_at(v))
    }

    /// The ends of where a number with this distribution can lie, infinite ones, too.
    ///
    /// ```
    /// use motes_models::equations::{Distribution, exponential};
    ///
    /// let delay: Distribution<f64> = exponential(2.0).shifted(1.0);
    /// assert_eq!(delay.ends(), [1.0, f64::INFINITY]);
    /// ```
    pub fn ends(&self) -> [f64; 2] {
        of_family!(*self, family => family.ends())
    }

    /// Mean and variance; NaN where the mean, or the variance, is none or infinite.
    pub(super) fn mean_and_variance(&self) -> [f64; 2] {
        let [mean, variance] = self.moments();
        match self {
            Distribution::StudentT(StudentT { df, .. }) if *df <= 1.0 => [f64::NAN; 2],
            Distribution::StudentT(StudentT { df, .. }) if *df <= 2.0 => [mean, f64::NAN],
            _ => [mean, variance],
        }
    }

    /// `P(X < x)` and `P(X = x)`; NaN where a parameter is out of range.
    pub(super) fn place(&self, x: f64) -> [f64; 2] {
        let at = if self.is_discrete() { self.log_density(x).exp() } else { 0.0 };
        let up_to = self.log_mass(f64::NEG_INFINITY, x).exp();
        [if at > 0.0 { (up_to - at).max(0.0) } else { up_to }, at]
    }

    /// `T(v)` and `log T′(v)`.
    pub(super) fn transport(&self, v: f64) -> [f64; 2] {
        of_family!(*self, family => family.transport(v))
    }
}

impl<const W: usize> Distribution<Lanes<W>> {
    /// Counts by the Gaussians of their noise: what is drawn, `log Q(n) − log p(n)`, and the most likely noise that becomes it; NaN where a count cannot be had in
    /// floating point, and of what is no count.
    pub(super) fn guided_counts(&self, noise: &GuidedNoise<'_, W>) -> [Lanes<W>; 3] {
        let found = match self {
            Distribution::Poisson(Poisson { mean }) => guided(|i| Poisson { mean: mean.0[i] }, noise),
            Distribution::Binomial(Binomial { n, p }) => guided(|i| Binomial { n: n.0[i], p: p.0[i] }, noise),
            Distribution::NegativeBinomial(NegativeBinomial { mean, size }) => {
                let of_one = std::array::from_fn::<_, W, _>(|i| {
                    let counts = NegativeBinomial { mean: mean.0[i], size: size.0[i] };
                    count::guided(counts, noise.v[i], noise.centre[i], noise.scale[i])
                });
                [0, 1, 2].map(|which| of_one.map(|found| found[which]))
            }
            _ => [[f64::NAN; W]; 3],
        };
        found.map(Lanes)
    }
}

#[cfg(test)]
mod tests {
    use super::distributions::{binomial, negative_binomial, poisson};
    use super::*;
    use crate::equations::quantile::normal;

    fn counts() -> [Distribution<f64>; 5] {
        [poisson(0.3), poisson(40.0), negative_binomial(6.0, 1.5), binomial(15.0, 0.2), binomial(1.0, 0.9)]
    }

    #[test]
    fn noise_is_transported_to_the_smallest_count_that_reaches_it() {
        for distribution in counts() {
            for v in [-6.0, -2.3, -0.4, 0.0, 0.8, 2.9, 5.5] {
                let (mut n, mut below) = (0.0, distribution.log_density(0.0).exp());
                // Φ(v) by its smaller tail; sums from 0 on are exact enough for these.
                let reached = if v < 0.0 { normal::upper(-v) } else { 1.0 - normal::upper(v) };
                while below < reached - 1e-13 {
                    n += 1.0;
                    below += distribution.log_density(n).exp();
                }
                let found = distribution.from_normal(v);
                assert_eq!(found, n, "{distribution:?} at {v}");
            }
        }
    }

    #[test]
    fn a_count_that_floating_point_does_not_have_is_none() {
        assert!(negative_binomial(0.0, -1.0).from_normal(0.0).is_nan());
        assert!(poisson(1e17).from_normal(0.0).is_nan());
        assert!(binomial(2.5, 0.5).from_normal(0.0).is_nan());
        assert!(binomial(3.0, 1.5).from_normal(0.0).is_nan());
        assert!(poisson(-1.0).from_normal(0.0).is_nan());
        assert_eq!(poisson(0.0).from_normal(3.0), 0.0);
        assert_eq!(binomial(7.0, 1.0).from_normal(-3.0), 7.0);
    }
}
