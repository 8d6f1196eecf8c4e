//! A Gaussian proposal: its networks, its weights, and how it is made.

use motes_models::{ModelShape, Seed};
use motes_networks::{Compute, Parameters};
use motes_smc::ProposalError;

use super::covariance::KernelCovariance;
use super::networks::GaussianNetworks;
use crate::family::Family;
use crate::over_time::one_at;
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
    /// Indices of `C` among the parameters: one for all times, or one for `t = 0` and one for the others.
    pub(super) mixings: Vec<usize>,
    /// `y_t` and the covariance for the present weights, of the step that a filter prepared.
    pub(super) prepared: Option<Prepared>,
}

/// What all particles of a step have in common.
#[derive(Clone)]
pub(super) struct Prepared {
    pub(super) time: usize,
    pub(super) measurement: Vec<f64>,
    pub(super) covariance: KernelCovariance,
}

impl<F: GaussianNetworks> GaussianProposal<F> {
    /// Refuses a step that the networks cannot be asked about.
    pub(super) fn check(&self, time: usize, measurement: &[f64]) -> Result<(), ProposalError> {
        if let Some(horizon) = self.networks.horizon()
            && time >= horizon
        {
            return Err(ProposalError::PastHorizon { horizon, time });
        }
        let (found, expected) = (self.measurement_dim, measurement.len());
        ProposalError::unless_same("the measurement dimension M", found, expected)
    }

    /// The index among the parameters of the `C` of a time.
    pub(super) fn mixing(&self, time: usize) -> usize {
        *one_at(&self.mixings, time)
    }

    /// The covariance at a time, for the current `C`.
    pub(super) fn covariance(&self, time: usize) -> Result<KernelCovariance, ProposalError> {
        let ridge = F::ridge(&self.config);
        KernelCovariance::new(self.state_dim, &self.parameters.host(self.mixing(time)), ridge)
    }
}

impl<F: GaussianNetworks> Family for GaussianProposal<F> {
    const NAME: &'static str = F::NAME;
    type Config = F::Config;

    /// Draws the networks' weights, then `C`, uniform on `±1/N`; two of them where `t = 0` has one of its own.
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
        let bound = 1.0 / state_dim as f64;
        let mut mixings = Vec::new();
        for name in F::over_time(config).names_of_one("covariance.mixing") {
            mixings.push(parameters.len());
            parameters.draw(name, [state_dim, state_dim], bound, seed);
        }
        Ok(GaussianProposal {
            networks,
            config: config.clone(),
            state_dim,
            measurement_dim,
            parameters,
            mixings,
            prepared: None,
        })
    }

    fn count(config: &F::Config, shape: &ModelShape, horizon: usize) -> Option<usize> {
        let mixings = F::over_time(config).of_one();
        let entries = shape.state_dim.checked_mul(shape.state_dim)?.checked_mul(mixings)?;
        F::count(config, shape, horizon)?.checked_add(entries)
    }

    fn config(&self) -> &F::Config {
        &self.config
    }
}
