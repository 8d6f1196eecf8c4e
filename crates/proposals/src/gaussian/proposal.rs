//! A Gaussian proposal: its networks, its weights, and how it is made.

use motes_models::{ModelShape, Seed};
use motes_networks::{Compute, Inference, Inputs, Parameters};
use motes_smc::{Past, ProposalError};

use super::batch::GaussianBatch;
use super::covariance::KernelCovariance;
use super::networks::GaussianNetworks;
use crate::family::Family;
use crate::settings::{check_compute, check_ridge, check_shape, check_weights};

/// `q(x_t | past) = N(μ_t, C K(z_t) Cᵀ + δI)` with `μ_t` and `z_t` from the networks of a family.
///
/// `C`, the kernel and the ridge are those of [`KernelCovariance`].
#[derive(Clone)]
pub struct GaussianProposal<F: GaussianNetworks> {
    pub(super) networks: F,
    config: F::Config,
    pub(super) state_dim: usize,
    pub(super) measurement_dim: usize,
    pub(super) parameters: Parameters,
    /// Index of `C` among the parameters.
    pub(super) mixing: usize,
    pub(super) conditional: GaussianBatch,
    pub(super) representations: Vec<f64>,
    pub(super) inference: Inference,
}

impl<F: GaussianNetworks> GaussianProposal<F> {
    /// Refuses a past that the networks cannot be asked about.
    pub(super) fn check(&self, past: &Past<'_>) -> Result<(), ProposalError> {
        if let Some(horizon) = self.networks.horizon()
            && past.time >= horizon
        {
            return Err(ProposalError::PastHorizon { horizon, time: past.time });
        }
        let (found, expected) = (self.measurement_dim, past.measurement.len());
        ProposalError::unless_same("the measurement dimension M", found, expected)
    }

    /// What the networks are asked.
    pub(super) fn inputs<'a>(&self, past: &Past<'a>) -> Inputs<'a> {
        let Past { time, previous, measurement, particles } = *past;
        Inputs { time, width: self.state_dim, previous, measurement, particles }
    }

    /// The covariance for the current `C`.
    pub(super) fn covariance(&self) -> Result<KernelCovariance, ProposalError> {
        let ridge = F::ridge(&self.config);
        KernelCovariance::new(self.state_dim, &self.parameters.host(self.mixing), ridge)
    }
}

impl<F: GaussianNetworks> Family for GaussianProposal<F> {
    const NAME: &'static str = F::NAME;
    type Config = F::Config;

    /// Draws the networks' weights, then `C`, uniform on `±1/N`.
    fn create(
        config: &F::Config,
        shape: &ModelShape,
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        check_compute(compute)?;
        F::check(config, horizon)?;
        check_ridge("the ridge of the covariance", F::ridge(config))?;
        check_shape(shape)?;
        check_weights(Self::count(config, shape, horizon))?;
        let &ModelShape { state_dim, measurement_dim, .. } = shape;
        let mut parameters = Parameters::new(compute);
        let networks = F::draw(config, shape, horizon, &mut parameters, seed)?;
        let mixing = parameters.len();
        let bound = 1.0 / state_dim as f64;
        parameters.draw("covariance.mixing".into(), [state_dim, state_dim], bound, seed);
        Ok(GaussianProposal {
            networks,
            config: config.clone(),
            state_dim,
            measurement_dim,
            parameters,
            mixing,
            conditional: GaussianBatch::default(),
            representations: Vec::new(),
            inference: Inference::default(),
        })
    }

    fn count(config: &F::Config, shape: &ModelShape, horizon: usize) -> Option<usize> {
        F::count(config, shape, horizon)?.checked_add(shape.state_dim.checked_mul(shape.state_dim)?)
    }

    fn config(&self) -> &F::Config {
        &self.config
    }
}
