//! What draws are made of: numbers of the standard distributions, drawn in bulk, and the stream where these do not do.

mod binomial;
mod gamma;
mod inversion;
mod needs;
mod poisson;
mod rejection;
mod squeeze;
mod stirling;

use rand::RngExt;
use rand_distr::{Exp1, StandardNormal};

use crate::Stream;

pub use binomial::LARGEST_BINOMIAL;
pub(super) use binomial::Successes;
pub(super) use gamma::StandardGamma;
pub(super) use needs::Needs;
pub(super) use poisson::Events;
pub use poisson::LARGEST_POISSON;
pub(super) use rejection::{Rejection, Try, UNDECIDED, draw_all};
pub(super) use stirling::beyond_stirling_of_all;

/// Where draws come from.
pub(super) trait Source<S> {
    /// A standard normal number.
    fn normal(&mut self) -> S;

    /// A number of the exponential distribution with mean 1.
    fn exponential(&mut self) -> S;

    /// A number uniform on `[0, 1)`.
    fn uniform(&mut self) -> S;

    /// A number drawn by a method, given its parameters.
    fn by<M: Rejection>(&mut self, a: S, b: S) -> S;
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

    #[inline(never)]
    fn by<M: Rejection>(&mut self, a: f64, b: f64) -> f64 {
        let normal = [if M::NEEDS.normals > 0 { self.normal() } else { 0.0 }];
        let mut uniforms = [[0.0]; 2];
        uniforms[..M::NEEDS.uniforms].fill_with(|| [self.uniform()]);
        let first = Try { normal: &normal, uniforms: uniforms.each_ref() };
        let mut drawn = [0.0];
        draw_all::<M, 1>(&[a], &[b], &first, 1, self.0, &mut drawn);
        drawn[0]
    }
}
