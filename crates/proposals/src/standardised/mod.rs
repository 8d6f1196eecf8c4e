//! Any learned family in units that suit networks: standardised inputs, and outputs around an origin.

mod fit;
mod frame;
mod propose;
mod tape;

pub use fit::Origin;
pub use frame::{Frame, Frames};

use motes_models::{ModelShape, Seed};
use motes_networks::Compute;
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::family::Family;
use crate::settings::check_shape;
use frame::Inputs;

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
/// let config = StandardisedConfig { family: FcnnConfig { widths: vec![16], ridge: 1e-6 }, frames };
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
    proposal: F,
    config: StandardisedConfig<F::Config>,
    scratch: Scratch,
}

#[derive(Clone, Default)]
struct Scratch {
    inputs: Inputs,
    /// `o + P ξ_{t−1} + B υ_t` of each particle, `R×N`.
    origins: Vec<f64>,
    /// States in the units of the outputs, `R×N`.
    outputs: Vec<f64>,
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
        Ok(Standardised { proposal, config: config.clone(), scratch: Scratch::default() })
    }

    fn count(config: &Self::Config, shape: &ModelShape, horizon: usize) -> Option<usize> {
        F::count(&config.family, shape, horizon)
    }

    fn config(&self) -> &Self::Config {
        &self.config
    }
}
