//! What the Gaussian families share: networks emit a mean and a representation, and all that is probabilistic follows.

mod batch;
mod covariance;
mod hidden;
mod networks;
mod propose;
mod tape;

pub use batch::GaussianBatch;
pub use covariance::KernelCovariance;
pub use hidden::Hidden;
pub use networks::{Emission, Known, Networks};

pub(crate) use networks::NetworkTape;

use motes_models::Seed;
use motes_smc::{Past, ProposalError};

use crate::family::check_ridge;
use crate::native::Inference;
use crate::{Compute, Parameters};

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
    representations: Vec<f64>,
    inference: Inference,
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
            representations: Vec::new(),
            inference: Inference::default(),
        })
    }

    /// Refuses a past that the networks cannot be asked about.
    fn check(&self, past: &Past<'_>) -> Result<(), ProposalError> {
        if let Some(horizon) = self.networks.horizon()
            && past.time >= horizon
        {
            return Err(ProposalError::PastHorizon { horizon, time: past.time });
        }
        let (found, expected) = (self.measurement_dim, past.measurement.len());
        ProposalError::unless_same("the measurement dimension M", found, expected)
    }

    /// The covariance for the current `C`.
    fn covariance(&self) -> Result<KernelCovariance, ProposalError> {
        KernelCovariance::new(self.state_dim, &self.parameters.host(self.mixing), self.ridge)
    }
}
