//! The minimum-degeneracy proposal in closed form.

use faer::{Mat, MatRef};
use motes_models::{AdditiveGaussian, Gaussian, ModelError, Stream, kalman};

use motes_models::batch::particles_by_stream;

use crate::{Conditional, Past, Proposal, ProposalError};

/// `p(x_t | x_{t−1}, y_t)` of a system with additive Gaussian noise and linear measurements (the paper's
/// equation "minDeg", in Doucet, Godsill and Andrieu's closed form).
///
/// `Σ⁻¹ = Σ_v⁻¹ + Cᵀ Σ_w⁻¹ C` and `μ = f(x_{t−1}) + G (y_t − C f(x_{t−1}))` with `G = Σ Cᵀ Σ_w⁻¹`; at `t = 0`
/// the prior's mean and covariance take the place of `f` and `Σ_v`. Among proposals that see only `x_{t−1}` and `y_t`
/// it gives weights of the smallest variance.
#[derive(Debug, Clone)]
#[doc(alias = "optimal proposal")]
pub struct MinDegeneracy {
    first: Correction,
    later: Correction,
    means: Vec<f64>,
}

/// How a prediction is corrected by a measurement, for one prior covariance.
#[derive(Debug, Clone)]
struct Correction {
    posterior: Gaussian,
    gain: Mat<f64>,
    measurement_matrix: Mat<f64>,
}

impl MinDegeneracy {
    /// Precomputes gains and covariances, which are the same for every particle and every `t ≥ 1`.
    ///
    /// # Errors
    /// [`ModelError::Covariance`] if a posterior covariance is not positive definite in floating point.
    pub fn new(model: &(impl AdditiveGaussian + ?Sized)) -> Result<Self, ModelError> {
        Ok(MinDegeneracy {
            first: Correction::new(model, model.initial().covariance())?,
            later: Correction::new(model, model.transition_covariance())?,
            means: Vec::new(),
        })
    }
}

impl Correction {
    fn new(model: &(impl AdditiveGaussian + ?Sized), prior: MatRef<'_, f64>) -> Result<Self, ModelError> {
        let c = model.measurement_matrix();
        let kalman::Correction { gain, covariance, .. } =
            kalman::correction(prior, c, model.measurement_covariance())?;
        let mean = vec![0.0; c.ncols()];
        let posterior = Gaussian::new("the minimum-degeneracy covariance", mean, covariance)?;
        Ok(Correction { posterior, gain, measurement_matrix: c.to_owned() })
    }

    /// Turns each predicted mean (rows of `means`) into the posterior mean.
    fn correct(&self, measurement: &[f64], means: &mut [f64]) {
        let (n, m) = (self.gain.nrows(), self.gain.ncols());
        let particles = means.len() / n;
        // Column by column of this matrix is particle by particle: the batch is one product each way.
        let mut predicted = faer::MatMut::from_column_major_slice_mut(means, n, particles);
        let mut innovations = Mat::from_fn(m, particles, |i, _| measurement[i]);
        multiply_add(innovations.as_mut(), self.measurement_matrix.as_ref(), predicted.as_ref(), -1.0);
        multiply_add(predicted.as_mut(), self.gain.as_ref(), innovations.as_ref(), 1.0);
    }
}

fn multiply_add(into: faer::MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>, scale: f64) {
    faer::linalg::matmul::matmul(into, faer::Accum::Add, a, b, scale, faer::Par::Seq);
}

impl<M: AdditiveGaussian + ?Sized> Proposal<M> for MinDegeneracy {
    type Memory = ();
    type Conditional<'a>
        = Shifted<'a>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        _memory: &mut (),
    ) -> Result<Shifted<'a>, ProposalError> {
        ProposalError::unless_same("the state dimension N", self.later.gain.nrows(), model.state_dim())?;
        ProposalError::unless_same(
            "the measurement dimension M",
            self.later.gain.ncols(),
            past.measurement.len(),
        )?;
        let n = model.state_dim();
        self.means.resize(past.particles * n, 0.0);
        let correction = match past.previous {
            None => {
                for mean in self.means.chunks_exact_mut(n) {
                    mean.copy_from_slice(model.initial().mean());
                }
                &self.first
            }
            Some(previous) => {
                model.transition_means(past.time, previous, &mut self.means);
                &self.later
            }
        };
        correction.correct(past.measurement, &mut self.means);
        Ok(Shifted { deviation: &correction.posterior, means: &self.means })
    }
}

/// Gaussians of one covariance, each particle with its own mean.
pub struct Shifted<'a> {
    deviation: &'a Gaussian,
    means: &'a [f64],
}

impl Conditional for Shifted<'_> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let width = self.deviation.mean().len();
        let particles = log_density.len();
        for (stream, states) in particles_by_stream(streams, states, width, particles) {
            for state in states.chunks_exact_mut(width) {
                self.deviation.sample_deviation(stream, state);
            }
        }
        for (state, mean) in states.iter_mut().zip(self.means) {
            *state += mean;
        }
        self.log_density(states, log_density);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        let width = self.deviation.mean().len();
        let rows = states.chunks_exact(width).zip(self.means.chunks_exact(width));
        for ((state, mean), log_density) in rows.zip(log_density) {
            *log_density = self.deviation.log_density_of(|j| state[j] - mean[j]);
        }
    }
}
