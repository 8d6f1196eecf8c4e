//! Drawing from a distribution: from numbers of the standard distributions, drawn in bulk, and from the stream where that does not do.

use rand::Rng;
use rand_distr::Distribution as _;

use super::distribution::Distribution;

/// How many numbers of the standard distributions draws take.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Needs {
    pub(super) normals: usize,
    pub(super) exponentials: usize,
    pub(super) uniforms: usize,
}

impl Needs {
    pub(super) fn plus(self, other: Needs) -> Needs {
        Needs {
            normals: self.normals + other.normals,
            exponentials: self.exponentials + other.exponentials,
            uniforms: self.uniforms + other.uniforms,
        }
    }

    /// How many numbers in all.
    pub(super) fn count(self) -> usize {
        self.normals + self.exponentials + self.uniforms
    }
}

impl<S> Distribution<S> {
    /// What one draw takes.
    #[inline(always)]
    pub(super) fn needs(&self) -> Needs {
        let none = Needs::default();
        match self {
            Distribution::Normal { .. } | Distribution::StudentT { .. } | Distribution::LogNormal { .. } => {
                Needs { normals: 1, ..none }
            }
            Distribution::Laplace { .. } => Needs { exponentials: 2, ..none },
            Distribution::Exponential { .. } => Needs { exponentials: 1, ..none },
            Distribution::Uniform { .. } => Needs { uniforms: 1, ..none },
            Distribution::Gamma { .. }
            | Distribution::Poisson { .. }
            | Distribution::NegativeBinomial { .. }
            | Distribution::Binomial { .. } => none,
        }
    }
}

/// A draw of the gamma distribution with scale 1; NaN for a shape that is out of range.
pub(super) fn standard_gamma(shape: f64, rng: &mut impl Rng) -> f64 {
    rand_distr::Gamma::new(shape, 1.0).map_or(f64::NAN, |gamma| gamma.sample(rng))
}

/// What a standard normal number is multiplied by to be one of Student's t; NaN for degrees of freedom out of range.
pub(super) fn student_factor(df: f64, rng: &mut impl Rng) -> f64 {
    // χ²(df) is twice a gamma of half its degrees of freedom.
    (0.5 * df / standard_gamma(0.5 * df, rng)).sqrt()
}

/// A draw of the Poisson distribution; NaN for a mean that is out of range.
pub(super) fn count(mean: f64, rng: &mut impl Rng) -> f64 {
    if mean == 0.0 {
        return 0.0;
    }
    rand_distr::Poisson::new(mean).map_or(f64::NAN, |poisson| poisson.sample(rng))
}

/// A draw of the negative binomial distribution; NaN for parameters out of range.
pub(super) fn overdispersed_count(mean: f64, size: f64, rng: &mut impl Rng) -> f64 {
    let of_shape = standard_gamma(size, rng);
    count(mean / size * of_shape, rng)
}

/// A draw of the binomial distribution; NaN for parameters out of range.
pub(super) fn successes(n: f64, p: f64, rng: &mut impl Rng) -> f64 {
    /// From here on not every integer is a number.
    const LARGEST: f64 = (1_u64 << 53) as f64;
    if !(n >= 0.0 && n <= LARGEST && n.fract() == 0.0) {
        return f64::NAN;
    }
    rand_distr::Binomial::new(n as u64, p).map_or(f64::NAN, |binomial| binomial.sample(rng) as f64)
}
