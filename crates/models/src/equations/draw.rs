//! Drawing from a distribution: from numbers of the standard distributions, drawn in bulk, and from the stream where that does not do.

use rand::RngExt;
use rand_distr::{Distribution as _, Exp1, StandardNormal};

use super::distribution::Distribution;
use super::scalar::Scalar;
use crate::Stream;

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

/// Where draws come from.
pub(super) trait Source<S> {
    /// A standard normal number.
    fn normal(&mut self) -> S;

    /// A number of the exponential distribution with mean 1.
    fn exponential(&mut self) -> S;

    /// A number uniform on `[0, 1)`.
    fn uniform(&mut self) -> S;

    /// What `draw` makes of two parameters and random bits.
    fn by(&mut self, a: S, b: S, draw: fn(f64, f64, &mut Stream) -> f64) -> S;
}

impl<S: Scalar> Distribution<S> {
    /// A draw; NaN where a parameter is out of range.
    #[inline(always)]
    pub(super) fn draw(&self, source: &mut impl Source<S>) -> S {
        match *self {
            Distribution::Normal { mean, sd } => mean + sd * source.normal(),
            Distribution::LogNormal { origin, sign, location, scale } => {
                origin + sign * (location + scale * source.normal()).exp()
            }
            Distribution::Laplace { location, scale } => {
                let up = source.exponential();
                location + scale * (up - source.exponential())
            }
            Distribution::Exponential { origin, mean } => origin + mean * source.exponential(),
            Distribution::Uniform { low, high } => low + (high - low) * source.uniform(),
            Distribution::StudentT { df, location, scale } => {
                let normal = source.normal();
                location + scale * normal * source.by(df, df, student_factor)
            }
            Distribution::Gamma { origin, shape, scale } => {
                origin + scale * source.by(shape, shape, standard_gamma)
            }
            Distribution::Poisson { mean } => source.by(mean, mean, count),
            Distribution::NegativeBinomial { mean, size } => source.by(mean, size, overdispersed_count),
            Distribution::Binomial { n, p } => source.by(n, p, successes),
        }
    }
}

/// One number at a time from the stream itself.
struct OneByOne<'a>(&'a mut Stream);

impl Source<f64> for OneByOne<'_> {
    fn normal(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }

    fn exponential(&mut self) -> f64 {
        self.0.sample(Exp1)
    }

    fn uniform(&mut self) -> f64 {
        self.0.random()
    }

    fn by(&mut self, a: f64, b: f64, draw: fn(f64, f64, &mut Stream) -> f64) -> f64 {
        draw(a, b, self.0)
    }
}

impl Distribution<f64> {
    /// Draws a number; NaN where a parameter is out of range.
    pub fn sample(&self, stream: &mut Stream) -> f64 {
        self.draw(&mut OneByOne(stream))
    }
}

/// A draw of the gamma distribution with scale 1; NaN for a shape that is out of range.
fn standard_gamma(shape: f64, _: f64, rng: &mut Stream) -> f64 {
    rand_distr::Gamma::new(shape, 1.0).map_or(f64::NAN, |gamma| gamma.sample(rng))
}

/// What a standard normal number is multiplied by to be one of Student's t; NaN for degrees of freedom out of range.
fn student_factor(df: f64, _: f64, rng: &mut Stream) -> f64 {
    // χ²(df) is twice a gamma of half its degrees of freedom.
    (0.5 * df / standard_gamma(0.5 * df, 0.0, rng)).sqrt()
}

/// A draw of the Poisson distribution; NaN for a mean that is out of range.
fn count(mean: f64, _: f64, rng: &mut Stream) -> f64 {
    if mean == 0.0 {
        return 0.0;
    }
    rand_distr::Poisson::new(mean).map_or(f64::NAN, |poisson| poisson.sample(rng))
}

/// A draw of the negative binomial distribution; NaN for parameters out of range.
fn overdispersed_count(mean: f64, size: f64, rng: &mut Stream) -> f64 {
    let of_shape = standard_gamma(size, 0.0, rng);
    count(mean / size * of_shape, 0.0, rng)
}

/// A draw of the binomial distribution; NaN for parameters out of range.
fn successes(n: f64, p: f64, rng: &mut Stream) -> f64 {
    /// From here on not every integer is a number.
    const LARGEST: f64 = (1_u64 << 53) as f64;
    if !((0.0..=LARGEST).contains(&n) && n.fract() == 0.0) {
        return f64::NAN;
    }
    rand_distr::Binomial::new(n as u64, p).map_or(f64::NAN, |binomial| binomial.sample(rng) as f64)
}
