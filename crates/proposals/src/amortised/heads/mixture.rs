//! A mixture of Gaussians.

use motes_models::Seed;
use motes_models::batch::{LANES, by_widest_vectors};
use motes_models::equations::{Lanes, Scalar};
use rand::RngExt;
use rand_distr::StandardNormal;

use super::covariance::Covariance;
use super::head::Head;
use super::normal::Normal;

/// `h = Σ_j π_j N(m_j, (A_jᵀA_j)⁻¹)` with `π = softmax(λ)`.
///
/// `θ` has for each component its `λ_j`, its mean and its factor.
#[derive(Debug, Clone, Copy)]
pub struct MixtureHead {
    components: usize,
    normal: Normal,
}

/// How far the components of an untrained mixture lie apart, in units of the base.
const SPREAD: f64 = 1.0;

impl MixtureHead {
    /// That of `components` Gaussians of `n` coordinates.
    pub fn new(n: usize, components: usize, covariance: Covariance) -> Self {
        MixtureHead { components, normal: Normal::new(n, covariance) }
    }

    /// How many numbers of `θ` one component has.
    fn each(&self) -> usize {
        1 + self.normal.outputs()
    }

    /// `log Σ_j exp λ_j`.
    #[inline(always)]
    fn log_normalizer(&self, theta: &[Lanes]) -> Lanes {
        let each = self.each();
        let mut largest = theta[0];
        for component in 1..self.components {
            largest = largest.max(theta[component * each]);
        }
        let mut sum = Lanes::from(0.0);
        for component in 0..self.components {
            sum = sum + (theta[component * each] - largest).exp();
        }
        largest + sum.ln()
    }

    /// `log h`; each `ε_j` and then each `λ_j + log N_j` are left in `scratch`.
    #[inline(always)]
    fn evaluate(&self, theta: &[Lanes], u: &[Lanes], scratch: &mut [Lanes]) -> Lanes {
        let (noise, logs) = scratch.split_at_mut(self.components * self.normal.n);
        let parts = theta.chunks_exact(self.each()).zip(noise.chunks_exact_mut(self.normal.n));
        let mut largest = Lanes::from(f64::NEG_INFINITY);
        for ((theta, noise), log) in parts.zip(&mut *logs) {
            *log = theta[0] + self.normal.log_density(&theta[1..], u, noise);
            largest = largest.max(*log);
        }
        let mut sum = Lanes::from(0.0);
        for log in &*logs {
            sum = sum + (*log - largest).exp();
        }
        largest + sum.ln() - self.log_normalizer(theta)
    }
}

impl Head for MixtureHead {
    fn outputs(&self) -> usize {
        self.components * self.each()
    }

    /// The first component is the base; the others lie around it.
    fn start(&self) -> Vec<f64> {
        let mut stream = Seed::from_u64(0).child("components of a mixture").stream();
        let mut theta = vec![0.0; self.outputs()];
        for (number, theta) in theta.chunks_exact_mut(self.each()).enumerate().skip(1) {
            for (coordinate, mean) in theta[1..=self.normal.n].iter_mut().enumerate() {
                let side = if (number + coordinate) % 2 == 0 { 1.0 } else { -1.0 };
                // On both sides along the first coordinate, anywhere along the others.
                *mean = match coordinate {
                    0 => SPREAD * side * number.div_ceil(2) as f64,
                    _ => SPREAD * stream.sample::<f64, _>(StandardNormal),
                };
            }
        }
        theta
    }

    fn uniforms(&self) -> usize {
        1
    }

    fn draw(&self, theta: &[Lanes], uniforms: &[Lanes], normals: &mut [Lanes]) {
        let each = self.each();
        // The parameters of the component that each particle draws from.
        motes_models::equations::with_scalars::<Lanes, _>(each, |chosen| {
            by_widest_vectors(
                #[inline(always)]
                || {
                    let log_normalizer = self.log_normalizer(theta);
                    let mut number = [0_usize; LANES];
                    let mut below = Lanes::from(0.0);
                    for component in 0..self.components - 1 {
                        below = below + (theta[component * each] - log_normalizer).exp();
                        for ((number, uniform), below) in number.iter_mut().zip(uniforms[0].0).zip(below.0) {
                            *number += usize::from(uniform >= below);
                        }
                    }
                    for (lane, number) in number.into_iter().enumerate() {
                        for (chosen, theta) in chosen.iter_mut().zip(&theta[number * each..]) {
                            chosen.0[lane] = theta.0[lane];
                        }
                    }
                    self.normal.draw(&chosen[1..], normals);
                },
            );
        });
    }

    fn log_density(&self, theta: &[Lanes], u: &[Lanes], scratch: &mut [Lanes]) -> Lanes {
        by_widest_vectors(
            #[inline(always)]
            || self.evaluate(theta, u, scratch),
        )
    }

    fn gradient(&self, theta: &[Lanes], u: &[Lanes], d_theta: &mut [Lanes], scratch: &mut [Lanes]) -> Lanes {
        by_widest_vectors(
            #[inline(always)]
            || {
                let value = self.evaluate(theta, u, scratch);
                let log_normalizer = self.log_normalizer(theta);
                let (noise, logs) = scratch.split_at(self.components * self.normal.n);
                let each = self.each();
                for component in 0..self.components {
                    let theta = &theta[component * each..][..each];
                    let noise = &noise[component * self.normal.n..][..self.normal.n];
                    let d_theta = &mut d_theta[component * each..][..each];
                    // How likely u came from this component.
                    let share = (logs[component] - value - log_normalizer).exp();
                    self.normal.gradient(&theta[1..], u, noise, share, &mut d_theta[1..]);
                    d_theta[0] = share - (theta[0] - log_normalizer).exp();
                }
                value
            },
        )
    }

    fn scratch(&self) -> usize {
        self.components * (self.normal.n + 1)
    }
}
