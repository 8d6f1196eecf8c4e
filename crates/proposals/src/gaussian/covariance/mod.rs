//! The covariance that every Gaussian family shares: a kernel of a learned representation, mixed by a learned matrix.

mod adjoint;

use motes_models::batch::by_widest_vectors;
use motes_models::elementary::exp;
use motes_smc::ProposalError;

use crate::lanes::{LANES, Lane, Square};
use crate::settings::check_ridge;

/// `Σ = C K(z) Cᵀ + δ I` with `K(z)ᵢⱼ = exp(−(zᵢ − zⱼ)²)` (the paper's equations "covMatrix" and "covKernel"; the ridge
/// `δ` makes it positive definite, which without it it need not be).
///
/// For `N = 1` it is a constant whatever `z` is: `K(z) = 1`, so `Σ = C² + δ`.
#[derive(Debug, Clone)]
pub struct KernelCovariance {
    width: usize,
    /// `C`, row-major.
    mixing: Vec<f64>,
    ridge: f64,
}

impl KernelCovariance {
    /// Takes `C` (`N×N`, row-major) and `δ`.
    ///
    /// # Errors
    /// [`ProposalError::Mismatch`] if `C` is not square, [`ProposalError::Setting`] if the ridge is negative or not finite.
    pub fn new(width: usize, mixing: &[f64], ridge: f64) -> Result<Self, ProposalError> {
        if width == 0 || mixing.len() != width * width {
            let what = "the number of entries of the mixing matrix C";
            return Err(ProposalError::Mismatch { what, found: mixing.len(), expected: width * width });
        }
        check_ridge("the ridge of the covariance", ridge)?;
        Ok(KernelCovariance { width, mixing: mixing.to_vec(), ridge })
    }

    /// The Cholesky factor of each particle's `Σ`, given its `z` (rows of `R×N`): `R` matrices, `N×N` column-major.
    ///
    /// # Errors
    /// As [`KernelCovariance::factor`].
    pub fn factors(&self, representations: &[f64]) -> Result<Vec<f64>, ProposalError> {
        let mut lowers = vec![0.0; representations.len() * self.width];
        self.factor(representations, &mut lowers)?;
        Ok(lowers)
    }

    /// The same into `lowers` (`R·N·N`).
    ///
    /// # Errors
    /// [`ProposalError::Mismatch`] if the sizes are not those of `R` particles, [`ProposalError::Numerical`] with the
    /// particle, if its `z` is not finite or its `Σ` not positive definite.
    pub fn factor(&self, representations: &[f64], lowers: &mut [f64]) -> Result<(), ProposalError> {
        let n = self.width;
        let particles = representations.len() / n;
        ProposalError::unless_same("the number of coordinates of z", representations.len(), particles * n)?;
        ProposalError::unless_same("the number of entries of the factors", lowers.len(), particles * n * n)?;
        let mut work =
            Factoring { kernel: Square::zeros(n), mixed: Square::zeros(n), lower: Square::zeros(n) };
        let blocks = representations.chunks(LANES * n).zip(lowers.chunks_mut(LANES * n * n));
        for (block, (z, lowers)) in blocks.enumerate() {
            let failed = by_widest_vectors(
                #[inline(always)]
                || self.factor_block(z, lowers, &mut work),
            );
            if let Some(lane) = failed {
                let z = &z[lane * n..(lane + 1) * n];
                let finite = z.iter().chain(&self.mixing).all(|value| value.is_finite());
                return Err(ProposalError::Numerical {
                    computation: "the Cholesky factor of the proposal's covariance",
                    particle: block * LANES + lane,
                    reason: match finite {
                        true => "it is not positive definite".into(),
                        false => "the network's output is not finite".into(),
                    },
                });
            }
        }
        Ok(())
    }

    /// One block of particles; the first that has no factor comes back.
    #[inline(always)]
    fn factor_block(&self, z: &[f64], lowers: &mut [f64], work: &mut Factoring) -> Option<usize> {
        let (n, particles) = (self.width, z.len() / self.width);
        let Factoring { kernel, mixed, lower } = work;
        kernel_matrices(n, z, kernel);
        for i in 0..n {
            for j in 0..n {
                let mut sum = Lane::default();
                for l in 0..n {
                    sum.add_scaled(self.mixing[i * n + l], kernel.at(l, j));
                }
                *mixed.at_mut(i, j) = sum;
            }
        }
        // The exponential of NaN is none.
        let mut whole: [bool; LANES] = std::array::from_fn(|lane| {
            z[lane.min(particles - 1) * n..][..n].iter().all(|value| value.is_finite())
        });
        for i in 0..n {
            for j in 0..=i {
                let mut sum = Lane::default();
                for l in 0..n {
                    sum.add_scaled(self.mixing[j * n + l], mixed.at(i, l));
                }
                if i == j {
                    sum.0.iter_mut().for_each(|value| *value += self.ridge);
                }
                for k in 0..j {
                    sum.subtract_product(lower.at(i, k), lower.at(j, k));
                }
                if i == j {
                    for (value, whole) in sum.0.iter_mut().zip(&mut whole) {
                        *whole &= *value > 0.0 && *value < f64::INFINITY;
                        *value = value.sqrt();
                    }
                } else {
                    sum.divide(lower.at(j, j));
                }
                *lower.at_mut(i, j) = sum;
            }
        }
        if let Some(lane) = whole.iter().take(particles).position(|whole| !whole) {
            return Some(lane);
        }
        for (lane, into) in lowers.chunks_exact_mut(n * n).enumerate() {
            for j in 0..n {
                for i in 0..n {
                    into[i + n * j] = if i < j { 0.0 } else { lower.at(i, j).0[lane] };
                }
            }
        }
        None
    }
}

/// Space for one block of particles.
struct Factoring {
    kernel: Square,
    mixed: Square,
    lower: Square,
}

/// `K(z)` of each particle of a block.
#[inline(always)]
fn kernel_matrices(n: usize, z: &[f64], kernel: &mut Square) {
    for i in 0..n {
        let mine = Lane::gather(z, n, i);
        for j in 0..=i {
            let mut entry = Lane::gather(z, n, j);
            for (entry, mine) in entry.0.iter_mut().zip(&mine.0) {
                *entry = exp(-(mine - *entry) * (mine - *entry));
            }
            *kernel.at_mut(i, j) = entry;
            *kernel.at_mut(j, i) = entry;
        }
    }
}
