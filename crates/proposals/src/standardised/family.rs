//! A family with standardised inputs and outputs: its settings, and how it is made.

use motes_models::{ModelShape, Seed};
use motes_networks::Compute;
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use super::frame::Frames;
use crate::family::Family;
use crate::settings::check_shape;

/// The settings of a [`Standardised`] family.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandardisedConfig<Config> {
    /// The family's own settings.
    pub family: Config,
    /// In which units its networks work.
    pub frames: Frames,
}

/// A family whose networks see and speak in the units of [`Frames`].
///
/// For systems whose coordinates are not of the size of 1: `F` gives `ξ_t ~ q(ξ | ξ_{t−1}, υ_t)` for the standardised previous state and
/// measurement, and the state is `x_t = o_t + P_t ξ_{t−1} + B_t υ_t + r_t ξ_t`, with `log q(x_t) = log q(ξ_t) − Σ log r_t`. What a
/// particle remembers is `F`'s. At `t = 0` the family sees zeros for the previous state, as it does by itself. What a family's
/// settings say in numbers, a ridge for instance, is in units of its outputs.
///
/// ```
/// use motes_models::{Epidemic, EpidemicConfig, ModelShape, Seed, Simulations};
/// use motes_proposals::{Backend, Family, Fcnn, FcnnConfig, Frames, Origin, Standardised, StandardisedConfig};
/// use motes_smc::{FilterSettings, ParticleFilter};
///
/// let (seed, horizon) = (Seed::from_u64(1), 20);
/// let epidemic = Epidemic::new(&EpidemicConfig::paper())?;
/// let simulations = Simulations::draw(&epidemic, horizon, 200, 2000.0, &seed.child("frames"))?;
/// let frames = Frames::of(&simulations, Origin::Prediction)?;
/// let config = StandardisedConfig { family: FcnnConfig { widths: vec![16], ..FcnnConfig::paper() }, frames };
/// let weights = seed.child("weights");
/// let proposal: Standardised<Fcnn> =
///     Standardised::create(&config, &ModelShape::of(&epidemic), horizon, Backend::Native.into(), &weights)?;
/// let stream = seed.child("filter").stream();
/// let mut filter = ParticleFilter::new(&epidemic, proposal, FilterSettings::new(500), stream)?;
/// filter.step(&[1010.0, -20.0])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Standardised<F: Family> {
    pub(super) proposal: F,
    pub(super) config: StandardisedConfig<F::Config>,
    /// What a filter prepared for its step.
    pub(super) prepared: Option<Prepared>,
}

/// What all particles of a step have in common.
#[derive(Clone)]
pub(super) struct Prepared {
    /// `υ_t`.
    pub(super) time: usize,
    /// `o + B υ_t`.
    pub(super) origin: Vec<f64>,
}

impl<F: Family> Family for Standardised<F> {
    const NAME: &'static str = F::NAME;
    type Config = StandardisedConfig<F::Config>;

    /// # Errors
    /// Those of the family, and [`ProposalError::Mismatch`] or [`ProposalError::Setting`] for frames that do not fit the model.
    fn create(
        config: &Self::Config,
        shape: &ModelShape,
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        check_shape(shape)?;
        config.frames.check(shape.state_dim, shape.measurement_dim, horizon)?;
        let proposal = F::create(&config.family, shape, horizon, compute, seed)?;
        Ok(Standardised { proposal, config: config.clone(), prepared: None })
    }

    fn count(config: &Self::Config, shape: &ModelShape, horizon: usize) -> Option<usize> {
        F::count(&config.family, shape, horizon)
    }

    fn config(&self) -> &Self::Config {
        &self.config
    }
}
