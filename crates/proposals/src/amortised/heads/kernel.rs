//! One Gaussian whose covariance is the paper's: a kernel of a representation, mixed by a matrix.

use motes_models::LN_2PI;
use motes_models::batch::by_widest_vectors;
use motes_models::equations::triangle::{at, factor, solve_lower, solve_upper};
use motes_models::equations::{Lanes, Scalar, with_scalars};

use super::head::{Head, Reparametrised};
use super::normal::bounded;

/// `δ`: no direction is narrower than a hundredth of the base.
const RIDGE: f64 = 1e-4;

/// How far apart the `z_i` of an untrained network lie: `K` is then the identity within `e⁻⁹`.
const APART: f64 = 3.0;

/// `h = N(m, C K(z) Cᵀ + δ I)` with `K(z)ᵢⱼ = exp(−(zᵢ − zⱼ)²)` (the paper's equations "covMatrix" and "covKernel").
///
/// `θ` has the mean `m` (`N`), the representation `z` (`N`) and the matrix `C` (`N×N`, row-major), whose entries stay within ±6.
#[derive(Debug, Clone, Copy)]
pub struct KernelHead {
    n: usize,
}

/// What a density is computed in.
struct Work<'a> {
    /// `C`, bounded, `N×N`.
    mixing: &'a mut [Lanes],
    /// `K(z)`, `N×N`.
    kernel: &'a mut [Lanes],
    /// `C K(z)`, `N×N`.
    mixed: &'a mut [Lanes],
    /// The Cholesky factor of the covariance.
    lower: &'a mut [Lanes],
    /// `Σ⁻¹ (u − m)`, `N`.
    pull: &'a mut [Lanes],
    /// `∂ log h / ∂Σ`, `N×N`, and a row.
    slope: &'a mut [Lanes],
    row: &'a mut [Lanes],
}

impl<'a> Work<'a> {
    fn of(memory: &'a mut [Lanes], n: usize) -> Self {
        let (mixing, rest) = memory.split_at_mut(n * n);
        let (kernel, rest) = rest.split_at_mut(n * n);
        let (mixed, rest) = rest.split_at_mut(n * n);
        let (lower, rest) = rest.split_at_mut(n * (n + 1) / 2);
        let (pull, rest) = rest.split_at_mut(n);
        let (slope, row) = rest.split_at_mut(n * n);
        Work { mixing, kernel, mixed, lower, pull, slope, row }
    }
}

impl KernelHead {
    /// That of `n` coordinates.
    pub fn new(n: usize) -> Self {
        KernelHead { n }
    }

    /// `m`, `z` and `C` before it is bounded.
    fn parts<'t>(&self, theta: &'t [Lanes]) -> [&'t [Lanes]; 3] {
        let (mean, rest) = theta.split_at(self.n);
        let (z, mixing) = rest.split_at(self.n);
        [mean, z, mixing]
    }

    /// `K(z)`, `C K(z)` and the Cholesky factor of the covariance.
    #[inline(always)]
    fn factor(&self, theta: &[Lanes], work: &mut Work<'_>) {
        let n = self.n;
        let [_, z, mixing] = self.parts(theta);
        for (bound, entry) in work.mixing.iter_mut().zip(mixing) {
            [*bound, _] = bounded(*entry);
        }
        for i in 0..n {
            for j in 0..n {
                let apart = z[i] - z[j];
                work.kernel[i * n + j] = (-(apart * apart)).exp();
            }
        }
        for i in 0..n {
            for j in 0..n {
                let mut sum = Lanes::from(0.0);
                for k in 0..n {
                    sum = sum + work.mixing[i * n + k] * work.kernel[k * n + j];
                }
                work.mixed[i * n + j] = sum;
            }
        }
        for i in 0..n {
            for j in 0..=i {
                let mut sum = Lanes::from(if i == j { RIDGE } else { 0.0 });
                for k in 0..n {
                    sum = sum + work.mixed[i * n + k] * work.mixing[j * n + k];
                }
                work.lower[at(i, j)] = sum;
            }
        }
        factor(n, work.lower);
    }

    /// `log h`; the factor and `Σ⁻¹ (u − m)` are left in `work`.
    #[inline(always)]
    fn evaluate(&self, theta: &[Lanes], u: &[Lanes], work: &mut Work<'_>) -> Lanes {
        let n = self.n;
        self.factor(theta, work);
        for i in 0..n {
            work.pull[i] = u[i] - theta[i];
        }
        solve_lower(n, work.lower, work.pull);
        let mut sum = Lanes::from(-0.5 * LN_2PI * n as f64);
        for i in 0..n {
            sum = sum - work.pull[i] * work.pull[i] * 0.5 - work.lower[at(i, i)].ln();
        }
        solve_upper(n, work.lower, work.pull);
        sum
    }

    /// `∂ log h / ∂Σ = ½ (Σ⁻¹ r rᵀ Σ⁻¹ − Σ⁻¹)` into `work.slope`.
    #[inline(always)]
    fn slope_of_covariance(&self, work: &mut Work<'_>) {
        let n = self.n;
        for i in 0..n {
            // Row i of the inverse.
            work.row.fill(Lanes::from(0.0));
            work.row[i] = Lanes::from(1.0);
            solve_lower(n, work.lower, work.row);
            solve_upper(n, work.lower, work.row);
            for j in 0..n {
                work.slope[i * n + j] = (work.pull[i] * work.pull[j] - work.row[j]) * 0.5;
            }
        }
    }
}

impl KernelHead {
    /// Takes the symmetric derivative `G` along the covariance, in `work.slope`, to those along `z` and `C`; `C K` in `work.mixed` is used up.
    #[inline(always)]
    fn along_parameters(
        &self,
        theta: &[Lanes],
        work: &mut Work<'_>,
        d_z: &mut [Lanes],
        d_mixing: &mut [Lanes],
    ) {
        let n = self.n;
        let [_, z, mixing] = self.parts(theta);
        for i in 0..n {
            for j in 0..n {
                // ∂/∂C = 2 G C K with G = ∂/∂Σ.
                let mut sum = Lanes::from(0.0);
                for k in 0..n {
                    sum = sum + work.slope[i * n + k] * work.mixed[k * n + j];
                }
                let [_, slope] = bounded(mixing[i * n + j]);
                d_mixing[i * n + j] = sum * slope * 2.0;
            }
        }
        // G C in place of C K, which is no longer needed.
        for i in 0..n {
            for j in 0..n {
                let mut sum = Lanes::from(0.0);
                for k in 0..n {
                    sum = sum + work.slope[i * n + k] * work.mixing[k * n + j];
                }
                work.mixed[i * n + j] = sum;
            }
        }
        // ∂/∂K = Cᵀ G C, and K_ij falls with the distance of z_i and z_j.
        for i in 0..n {
            let mut sum = Lanes::from(0.0);
            for j in 0..n {
                let mut of_kernel = Lanes::from(0.0);
                for k in 0..n {
                    of_kernel = of_kernel + work.mixing[k * n + i] * work.mixed[k * n + j];
                }
                sum = sum + of_kernel * (z[i] - z[j]) * work.kernel[i * n + j];
            }
            d_z[i] = sum * -4.0;
        }
    }

    /// The derivative along the covariance of `Σ_i c_i u_i` with `u = m + L ε` at a fixed `ε`, which is in `work.pull`, into `work.slope`; `pull` has `c`.
    ///
    /// It is `L⁻ᵀ P L⁻¹` with `P_kj = ½ w_max(k,j) ε_min(k,j)` and `w = Lᵀ c`: the derivative of a Cholesky factor in reverse (Murray 2016, equation 10).
    #[inline(always)]
    fn slope_of_draw(&self, work: &mut Work<'_>, pull: &mut [Lanes]) {
        let n = self.n;
        for k in 0..n {
            let mut sum = Lanes::from(0.0);
            for (i, pull) in pull.iter().enumerate().skip(k) {
                sum = sum + work.lower[at(i, k)] * *pull;
            }
            pull[k] = sum;
        }
        for k in 0..n {
            for j in 0..n {
                work.row[j] = pull[k.max(j)] * work.pull[k.min(j)] * 0.5;
            }
            solve_upper(n, work.lower, &mut work.row[..n]);
            work.slope[k * n..(k + 1) * n].copy_from_slice(&work.row[..n]);
        }
        for j in 0..n {
            for k in 0..n {
                work.row[k] = work.slope[k * n + j];
            }
            solve_upper(n, work.lower, &mut work.row[..n]);
            for k in 0..n {
                work.slope[k * n + j] = work.row[k];
            }
        }
    }
}

impl Head for KernelHead {
    fn outputs(&self) -> usize {
        2 * self.n + self.n * self.n
    }

    /// The base, within a few hundredths.
    fn start(&self) -> Vec<f64> {
        let n = self.n;
        let mut theta = vec![0.0; self.outputs()];
        for i in 0..n {
            theta[n + i] = APART * i as f64;
            theta[2 * n + i * n + i] = 1.0;
        }
        theta
    }

    fn draw(&self, theta: &[Lanes], _uniforms: &[Lanes], normals: &mut [Lanes]) {
        let n = self.n;
        with_scalars::<Lanes, _>(self.scratch(), |memory| {
            let mut work = Work::of(memory, n);
            by_widest_vectors(
                #[inline(always)]
                || {
                    self.factor(theta, &mut work);
                    for i in (0..n).rev() {
                        let mut sum = theta[i];
                        for (j, normal) in normals[..=i].iter().enumerate() {
                            sum = sum + work.lower[at(i, j)] * *normal;
                        }
                        normals[i] = sum;
                    }
                },
            );
        });
    }

    fn log_density(&self, theta: &[Lanes], u: &[Lanes], scratch: &mut [Lanes]) -> Lanes {
        let mut work = Work::of(scratch, self.n);
        by_widest_vectors(
            #[inline(always)]
            || self.evaluate(theta, u, &mut work),
        )
    }

    fn gradient(&self, theta: &[Lanes], u: &[Lanes], d_theta: &mut [Lanes], scratch: &mut [Lanes]) -> Lanes {
        let n = self.n;
        let mut work = Work::of(scratch, n);
        by_widest_vectors(
            #[inline(always)]
            || {
                let value = self.evaluate(theta, u, &mut work);
                self.slope_of_covariance(&mut work);
                let (d_mean, rest) = d_theta.split_at_mut(n);
                let (d_z, d_mixing) = rest.split_at_mut(n);
                d_mean.copy_from_slice(work.pull);
                self.along_parameters(theta, &mut work, d_z, d_mixing);
                value
            },
        )
    }

    fn scratch(&self) -> usize {
        4 * self.n * self.n + self.n * (self.n + 1) / 2 + 2 * self.n
    }

    fn reparametrised(&self) -> Option<&dyn Reparametrised> {
        Some(self)
    }
}

impl Reparametrised for KernelHead {
    fn slope(&self, theta: &[Lanes], u: &[Lanes], d_u: &mut [Lanes], scratch: &mut [Lanes]) {
        let mut work = Work::of(scratch, self.n);
        by_widest_vectors(
            #[inline(always)]
            || {
                self.evaluate(theta, u, &mut work);
                for (slope, pull) in d_u.iter_mut().zip(&*work.pull) {
                    *slope = -*pull;
                }
            },
        );
    }

    fn pull_back(
        &self,
        theta: &[Lanes],
        u: &[Lanes],
        pull: &mut [Lanes],
        d_theta: &mut [Lanes],
        scratch: &mut [Lanes],
    ) {
        let n = self.n;
        let mut work = Work::of(scratch, n);
        by_widest_vectors(
            #[inline(always)]
            || {
                self.factor(theta, &mut work);
                for i in 0..n {
                    work.pull[i] = u[i] - theta[i];
                }
                solve_lower(n, work.lower, work.pull);
                let (d_mean, rest) = d_theta.split_at_mut(n);
                let (d_z, d_mixing) = rest.split_at_mut(n);
                d_mean.copy_from_slice(pull);
                self.slope_of_draw(&mut work, pull);
                self.along_parameters(theta, &mut work, d_z, d_mixing);
            },
        );
    }
}
