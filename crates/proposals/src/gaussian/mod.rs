//! What the Gaussian families share: networks emit a mean and a representation, and all that is probabilistic follows.

mod batch;
mod covariance;
mod hidden;
mod propose;
mod tape;

pub use batch::GaussianBatch;
pub use covariance::{KernelCovariance, cholesky_adjoint};
pub use hidden::Hidden;

use burn::tensor::Tensor;
use motes_models::Seed;
use motes_smc::{Past, ProposalError};

use crate::affine::Weights;
use crate::family::check_ridge;
use crate::{Compute, Parameters};

/// The networks of one Gaussian family: from what a particle knows to a mean and a representation.
///
/// This is all that tells the families apart; covariance, sampling, densities and derivatives are [`GaussianProposal`]'s.
pub trait Networks: Clone {
    /// How many times there are networks for; `None` if any number.
    fn horizon(&self) -> Option<usize>;

    /// The widths of the tensors that a particle carries from step to step; none for a Markov family.
    fn hidden_widths(&self) -> Vec<usize> {
        Vec::new()
    }

    /// Emits the parameters of `R` particles' distributions at time `t`.
    fn forward(&self, weights: &mut Weights<'_>, time: usize, known: Known<'_>) -> Emission;
}

/// What the networks see of `R` particles.
pub struct Known<'a> {
    /// `x_{t−1}`, `R×N`; zeros at `t = 0`.
    pub previous: Tensor<2>,
    /// `y_t`, `1×M`.
    pub measurement: Tensor<2>,
    /// What the particles carry, `R×width` each.
    pub hidden: &'a [Tensor<2>],
}

impl Known<'_> {
    /// `[x_{t−1}; y_t]` of each particle, `R×(N+M)`.
    pub(crate) fn stacked(&self) -> Tensor<2> {
        let particles = self.previous.dims()[0];
        let measurements = self.measurement.clone().repeat_dim(0, particles);
        Tensor::cat(vec![self.previous.clone(), measurements], 1)
    }
}

/// What the networks say of `R` particles.
pub struct Emission {
    /// `μ_t`, `R×N`.
    pub means: Tensor<2>,
    /// `z_t`, `R×N`.
    pub representations: Tensor<2>,
    /// What the particles carry on, in the order of [`Networks::hidden_widths`].
    pub hidden: Vec<Tensor<2>>,
}

/// `q(x_t | past) = N(μ_t, C K(z_t) Cᵀ + δI)` with `μ_t` and `z_t` from the networks of a family.
///
/// `C`, the kernel and the ridge are those of [`KernelCovariance`].
#[derive(Clone)]
pub struct GaussianProposal<F, Config> {
    pub(crate) networks: F,
    pub(crate) config: Config,
    state_dim: usize,
    measurement_dim: usize,
    ridge: f64,
    parameters: Parameters,
    /// Index of `C` among the parameters.
    mixing: usize,
    conditional: GaussianBatch,
}

/// The sizes that every family needs to know.
#[derive(Clone, Copy)]
pub(crate) struct Sizes {
    pub(crate) state_dim: usize,
    pub(crate) measurement_dim: usize,
}

impl<F: Networks, Config: Clone> GaussianProposal<F, Config> {
    /// Lets `draw` add the networks' weights, then adds `C`, uniform on `±1/N`.
    pub(crate) fn assemble(
        config: &Config,
        ridge: f64,
        sizes: Sizes,
        compute: Compute,
        seed: &Seed,
        draw: impl FnOnce(&mut Parameters) -> F,
    ) -> Result<Self, ProposalError> {
        let Sizes { state_dim, measurement_dim } = sizes;
        check_ridge("the ridge of the covariance", ridge)?;
        let mut parameters = Parameters::new(compute);
        let networks = draw(&mut parameters);
        let mixing = parameters.len();
        let bound = 1.0 / state_dim as f64;
        parameters.draw("covariance.mixing".into(), [state_dim, state_dim], bound, seed);
        Ok(GaussianProposal {
            networks,
            config: config.clone(),
            state_dim,
            measurement_dim,
            ridge,
            parameters,
            mixing,
            conditional: GaussianBatch::default(),
        })
    }

    /// `x_{t−1}` (zeros at `t = 0`) and `y_t` as tensors.
    fn known(&self, past: &Past<'_>) -> Result<(Tensor<2>, Tensor<2>), ProposalError> {
        if let Some(horizon) = self.networks.horizon()
            && past.time >= horizon
        {
            return Err(ProposalError::PastHorizon { horizon, time: past.time });
        }
        let (n, m) = (self.state_dim, self.measurement_dim);
        ProposalError::unless_same("the measurement dimension M", m, past.measurement.len())?;
        let compute = self.parameters.compute();
        let shape = [past.particles, n];
        let previous = match past.previous {
            Some(previous) => compute.tensor(previous, shape),
            None => compute.tensor(&vec![0.0; past.particles * n], shape),
        };
        Ok((previous, compute.tensor(past.measurement, [1, m])))
    }

    /// The covariance for the current `C`.
    fn covariance(&self) -> Result<KernelCovariance, ProposalError> {
        KernelCovariance::new(self.state_dim, &self.parameters.host(self.mixing)?, self.ridge)
    }
}
