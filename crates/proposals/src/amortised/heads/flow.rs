//! A conditional flow: a triangular map, and a monotone spline of each coordinate.

use motes_models::batch::by_widest_vectors;
use motes_models::equations::{Lanes, with_scalars};

use super::covariance::Covariance;
use super::head::{Head, Reparametrised};
use super::normal::Normal;
use super::spline::Spline;

/// `z = s(A(u − m))` is standard normal, with `A` lower triangular and `s` a monotone spline of each coordinate:
/// `log h = Σ_i log φ(z_i) + log s_i' + log A_ii`.
///
/// `θ` has the mean and the factor of a Gaussian, and then the parameters of the spline of each coordinate. Entries of the factor that all particles share
/// stand last.
#[derive(Debug, Clone, Copy)]
pub struct FlowHead {
    normal: Normal,
    spline: Spline,
}

impl FlowHead {
    /// That of `n` coordinates, whose splines have so many pieces.
    pub fn new(n: usize, pieces: usize, covariance: Covariance) -> Self {
        let (normal, spline) = (Normal::new(n, covariance), Spline { pieces });
        // What all particles share stands last.
        let below = normal.below + if normal.shared() > 0 { n * spline.outputs() } else { 0 };
        FlowHead { normal: Normal { below, ..normal }, spline }
    }

    /// The parameters of the spline of a coordinate.
    fn of_spline(&self, coordinate: usize) -> std::ops::Range<usize> {
        let first = self.normal.outputs() - self.normal.shared() + coordinate * self.spline.outputs();
        first..first + self.spline.outputs()
    }

    /// `log h`; `ε = A(u − m)` and then what each spline computed are left in `scratch`.
    #[inline(always)]
    fn evaluate(&self, theta: &[Lanes], u: &[Lanes], scratch: &mut [Lanes]) -> Lanes {
        let (noise, splines) = scratch.split_at_mut(self.normal.n);
        let mut sum = self.normal.log_density(theta, u, noise);
        for (i, scratch) in splines.chunks_exact_mut(self.spline.scratch()).enumerate() {
            let found = self.spline.evaluate(&theta[self.of_spline(i)], noise[i], scratch);
            // The density of z in the place of that of ε.
            sum = sum + found.log_slope + (noise[i] * noise[i] - found.value * found.value) * 0.5;
        }
        sum
    }
}

impl Head for FlowHead {
    fn outputs(&self) -> usize {
        self.normal.outputs() + self.normal.n * self.spline.outputs()
    }

    fn shared(&self) -> usize {
        self.normal.shared()
    }

    /// The base itself.
    fn start(&self) -> Vec<f64> {
        vec![0.0; self.outputs()]
    }

    fn draw(&self, theta: &[Lanes], _uniforms: &[Lanes], normals: &mut [Lanes]) {
        with_scalars::<Lanes, _>(self.spline.scratch(), |scratch| {
            by_widest_vectors(
                #[inline(always)]
                || {
                    for (i, normal) in normals.iter_mut().enumerate() {
                        *normal = self.spline.invert(&theta[self.of_spline(i)], *normal, scratch);
                    }
                    self.normal.draw(theta, normals);
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
                let (noise, splines) = scratch.split_at_mut(self.normal.n);
                for (i, scratch) in splines.chunks_exact(self.spline.scratch()).enumerate() {
                    let place = self.of_spline(i);
                    let d_theta = &mut d_theta[place.clone()];
                    // A Gaussian is pulled back by ε, which is minus the derivative of its density along ε.
                    noise[i] = -self.spline.gradient(&theta[place], noise[i], scratch, d_theta);
                }
                self.normal.gradient(theta, u, noise, Lanes::from(1.0), d_theta);
                value
            },
        )
    }

    fn scratch(&self) -> usize {
        self.normal.n * (1 + self.spline.scratch())
    }

    fn reparametrised(&self) -> Option<&dyn Reparametrised> {
        Some(self)
    }
}

impl Reparametrised for FlowHead {
    fn slope(&self, theta: &[Lanes], u: &[Lanes], d_u: &mut [Lanes], scratch: &mut [Lanes]) {
        with_scalars::<Lanes, _>(self.spline.outputs(), |unused| {
            by_widest_vectors(
                #[inline(always)]
                || {
                    self.evaluate(theta, u, scratch);
                    let (noise, splines) = scratch.split_at(self.normal.n);
                    for (i, scratch) in splines.chunks_exact(self.spline.scratch()).enumerate() {
                        d_u[i] = self.spline.gradient(&theta[self.of_spline(i)], noise[i], scratch, unused);
                    }
                    self.normal.along_draw(theta, d_u);
                },
            );
        });
    }

    /// The noise is `z = s(r)` with `r = A(u − m)`: at a fixed `z`, `∂r = −∂s / s'`.
    fn pull_back(
        &self,
        theta: &[Lanes],
        u: &[Lanes],
        pull: &mut [Lanes],
        d_theta: &mut [Lanes],
        scratch: &mut [Lanes],
    ) {
        by_widest_vectors(
            #[inline(always)]
            || {
                self.evaluate(theta, u, scratch);
                self.normal.pull_back(theta, u, pull, d_theta);
                let (noise, splines) = scratch.split_at(self.normal.n);
                for (i, scratch) in splines.chunks_exact(self.spline.scratch()).enumerate() {
                    let place = self.of_spline(i);
                    let d_theta = &mut d_theta[place.clone()];
                    let slope = self.spline.value_gradient(&theta[place], noise[i], scratch, d_theta);
                    let weight = -(pull[i] / slope);
                    for d in d_theta {
                        *d = *d * weight;
                    }
                }
            },
        );
    }
}
