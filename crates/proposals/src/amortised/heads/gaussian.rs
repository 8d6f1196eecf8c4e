//! One Gaussian.

use motes_models::batch::by_widest_vectors;
use motes_models::equations::Lanes;

use super::covariance::Covariance;
use super::head::{Head, Reparametrised};
use super::normal::Normal;

/// `h = N(m, (AᵀA)⁻¹)` with a mean and a triangular factor of the precision from the network, or with entries below the diagonal that all particles share.
#[derive(Debug, Clone, Copy)]
pub struct GaussianHead(Normal);

impl GaussianHead {
    /// That of `n` coordinates.
    pub fn new(n: usize, covariance: Covariance) -> Self {
        GaussianHead(Normal::new(n, covariance))
    }
}

impl Head for GaussianHead {
    fn outputs(&self) -> usize {
        self.0.outputs()
    }

    fn shared(&self) -> usize {
        self.0.shared()
    }

    /// The base itself.
    fn start(&self) -> Vec<f64> {
        vec![0.0; self.outputs()]
    }

    fn draw(&self, theta: &[Lanes], _uniforms: &[Lanes], normals: &mut [Lanes]) {
        by_widest_vectors(
            #[inline(always)]
            || self.0.draw(theta, normals),
        );
    }

    fn log_density(&self, theta: &[Lanes], u: &[Lanes], scratch: &mut [Lanes]) -> Lanes {
        by_widest_vectors(
            #[inline(always)]
            || self.0.log_density(theta, u, scratch),
        )
    }

    fn gradient(&self, theta: &[Lanes], u: &[Lanes], d_theta: &mut [Lanes], scratch: &mut [Lanes]) -> Lanes {
        by_widest_vectors(
            #[inline(always)]
            || {
                let value = self.0.log_density(theta, u, scratch);
                self.0.gradient(theta, u, scratch, Lanes::from(1.0), d_theta);
                value
            },
        )
    }

    fn scratch(&self) -> usize {
        self.0.n
    }

    fn reparametrised(&self) -> Option<&dyn Reparametrised> {
        Some(self)
    }
}

impl Reparametrised for GaussianHead {
    fn slope(&self, theta: &[Lanes], u: &[Lanes], d_u: &mut [Lanes], scratch: &mut [Lanes]) {
        by_widest_vectors(
            #[inline(always)]
            || {
                self.0.log_density(theta, u, scratch);
                for (slope, noise) in d_u.iter_mut().zip(&*scratch) {
                    *slope = -*noise;
                }
                self.0.along_draw(theta, d_u);
            },
        );
    }

    fn pull_back(
        &self,
        theta: &[Lanes],
        u: &[Lanes],
        pull: &mut [Lanes],
        d_theta: &mut [Lanes],
        _scratch: &mut [Lanes],
    ) {
        by_widest_vectors(
            #[inline(always)]
            || self.0.pull_back(theta, u, pull, d_theta),
        );
    }
}
