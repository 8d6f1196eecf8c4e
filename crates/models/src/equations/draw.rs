//! What draws are made of: numbers of the standard distributions, drawn in bulk, and the stream where these do not do.

use rand::RngExt;
use rand_distr::{Distribution as _, Exp1, StandardNormal};

use crate::Stream;

/// How many numbers of the standard distributions draws take.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Needs {
    pub(super) normals: usize,
    pub(super) exponentials: usize,
    pub(super) uniforms: usize,
}

impl Needs {
    pub(super) const NOTHING: Needs = Needs { normals: 0, exponentials: 0, uniforms: 0 };
    pub(super) const NORMAL: Needs = Needs { normals: 1, ..Needs::NOTHING };
    pub(super) const EXPONENTIAL: Needs = Needs { exponentials: 1, ..Needs::NOTHING };
    pub(super) const UNIFORM: Needs = Needs { uniforms: 1, ..Needs::NOTHING };

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

/// One number at a time from the stream itself.
pub(super) struct OneByOne<'a>(pub(super) &'a mut Stream);

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

/// A draw of the gamma distribution with scale 1; NaN for a shape that is out of range.
pub(super) fn standard_gamma(shape: f64, _: f64, rng: &mut Stream) -> f64 {
    rand_distr::Gamma::new(shape, 1.0).map_or(f64::NAN, |gamma| gamma.sample(rng))
}

/// A draw of the Poisson distribution; NaN for a mean that is out of range.
pub(super) fn poisson(mean: f64, _: f64, rng: &mut Stream) -> f64 {
    if mean == 0.0 {
        return 0.0;
    }
    rand_distr::Poisson::new(mean).map_or(f64::NAN, |poisson| poisson.sample(rng))
}
