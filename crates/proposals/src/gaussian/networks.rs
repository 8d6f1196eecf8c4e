//! What tells the Gaussian families apart: their networks.

use motes_models::{ModelShape, Seed};
use motes_networks::{Networks, Parameters};
use motes_smc::ProposalError;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::over_time::OverTime;

/// The networks of one Gaussian family: from what a particle knows to a mean and a representation.
///
/// They have two outputs of width `N`: first `μ_t`, then `z_t`. This is all that tells the families apart; covariance, sampling, densities and
/// derivatives are [`super::GaussianProposal`]'s. Implement it for networks of your own, and `GaussianProposal<YourNetworks>` is a family.
pub trait GaussianNetworks: Networks {
    /// The family's name in configurations and saved files.
    const NAME: &'static str;

    /// The family's settings.
    type Config: Serialize + DeserializeOwned + Clone + Send + Sync;

    /// Refuses settings that no networks can be made from.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] with the setting that is wrong.
    fn check(config: &Self::Config, horizon: usize) -> Result<(), ProposalError>;

    /// How many numbers the weights of the networks are; `None` if they cannot be counted. Nothing is allocated.
    fn count(config: &Self::Config, shape: &ModelShape, horizon: usize) -> Option<usize>;

    /// Adds the weights of the networks to `parameters`, each matrix drawn from the stream that `seed` has for its name.
    ///
    /// # Errors
    /// [`ProposalError`] if the networks cannot be made for this model.
    fn draw(
        config: &Self::Config,
        shape: &ModelShape,
        horizon: usize,
        parameters: &mut Parameters,
        seed: &Seed,
    ) -> Result<Self, ProposalError>;

    /// `δ`, which is added to the diagonal of the covariance.
    fn ridge(config: &Self::Config) -> f64;

    /// Which networks serve which times; where they are [`OverTime::Shared`], `t = 0` has a `C` of its own.
    fn over_time(_config: &Self::Config) -> OverTime {
        OverTime::EachTime
    }
}
