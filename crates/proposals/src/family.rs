//! What all learned families have in common: weights, a name, settings, and a way to make one from them.

use motes_models::{ModelShape, Seed};
use motes_networks::{Compute, HiddenReader, Parameters};
use motes_smc::ProposalError;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The file of a proposal's description.
const DESCRIPTION: &str = "proposal.toml";

/// The file of its weights.
const WEIGHTS: &str = "weights.safetensors";

/// A proposal with weights.
pub trait Parametric {
    /// The weights.
    fn parameters(&self) -> &Parameters;

    /// The weights, to be changed by an optimiser.
    fn parameters_mut(&mut self) -> &mut Parameters;

    /// The matrices that read units of hidden layers, which dropout can leave out; none where a unit cannot be left out.
    fn hidden_readers(&self) -> Vec<HiddenReader> {
        Vec::new()
    }

    /// The indices of the matrices that a weight penalty shrinks: those of weights, neither offsets nor what scales a distribution or its inputs.
    fn weight_matrices(&self) -> Vec<usize> {
        let names = self.parameters().names();
        (0..names.len()).filter(|index| !names[*index].ends_with("bias")).collect()
    }

    /// How many times the proposal has parameters for; `None` if any number.
    fn horizon(&self) -> Option<usize>;

    /// `N`, the number of coordinates of a state.
    fn state_dim(&self) -> usize;

    /// `M`, the number of coordinates of a measurement.
    fn measurement_dim(&self) -> usize;
}

/// A family of learned proposals, made from settings alone: what an experiment or a saved file names.
pub trait Family: Parametric + Sized {
    /// Its name in configurations and saved files.
    const NAME: &'static str;

    /// What its description and its weights are called in a folder.
    const FILES: [&'static str; 2] = [DESCRIPTION, WEIGHTS];

    /// Its settings.
    type Config: Serialize + DeserializeOwned + Clone + Send + Sync;

    /// Draws initial weights for models of a shape. A family that is not unrolled over time has no use for `horizon`.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] or [`ProposalError::NoGraph`] for settings or a model that it cannot be made for.
    fn create(
        config: &Self::Config,
        shape: &ModelShape,
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError>;

    /// How many numbers its weights are; `None` if they cannot be counted. Nothing is allocated.
    fn count(config: &Self::Config, shape: &ModelShape, horizon: usize) -> Option<usize>;

    /// The settings it was made from.
    fn config(&self) -> &Self::Config;
}
