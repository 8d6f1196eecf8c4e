//! Sequences to learn from.

use motes_models::{OwnModel, OwnSteps, Seed};
use motes_proposals::{PathBatch, PotentialStandards, StepFeatures};
use rand::RngExt;

use super::settings::PotentialLearnConfig;
use crate::TrainError;

/// How often sequences are drawn again of which one leaves the numbers.
const TRIES: u64 = 20;

/// The share of measurements that are missing in a sequence with gaps.
const MISSING: f64 = 0.2;

/// Which models draw the sequences that are learned from.
pub enum PathSource<'a, M: ?Sized> {
    /// The same model draws all.
    Model(&'a M),
    /// Each sequence has a model of its own, as with parameters from their prior.
    Models(&'a PathSampler<'a>),
}

/// Draws a model by a seed, and from it the sequence that it is asked for.
pub type PathSampler<'a> =
    dyn Fn(&Seed, PathRequest<'_>) -> Result<Option<PathBatch>, TrainError> + Sync + 'a;

/// One sequence that is asked of a model.
#[derive(Debug, Clone, Copy)]
pub struct PathRequest<'a> {
    config: &'a PotentialLearnConfig,
    seed: &'a Seed,
}

impl PathRequest<'_> {
    /// A sequence of this model, in units of its own; none if it leaves the numbers.
    ///
    /// # Errors
    /// [`TrainError::Model`] for a model that cannot be simulated, [`TrainError::Networks`] for one that has no map of noise.
    pub fn of<M: OwnModel + ?Sized>(self, model: &M) -> Result<Option<PathBatch>, TrainError> {
        let PathRequest { config, seed } = self;
        let standards = PotentialStandards::of_model(model, config.horizon)?;
        drawn(model, 1, config, &standards, seed)
    }
}

impl<'a, M: OwnModel + ?Sized> PathSource<'a, M> {
    /// With the units of the one model, if it is one.
    ///
    /// # Errors
    /// [`TrainError::Model`] for a model that cannot be simulated.
    pub(super) fn prepared(self, horizon: usize) -> Result<Supply<'a, M>, TrainError> {
        Ok(match self {
            PathSource::Model(model) => Supply::Model(model, PotentialStandards::of_model(model, horizon)?),
            PathSource::Models(draw) => Supply::Models(draw),
        })
    }
}

/// A source with what all its sequences share.
pub(super) enum Supply<'a, M: ?Sized> {
    Model(&'a M, PotentialStandards),
    Models(&'a PathSampler<'a>),
}

impl<M: OwnModel + ?Sized> Supply<'_, M> {
    /// The units of the one model, if it is one.
    pub(super) fn standards(&self) -> Option<&PotentialStandards> {
        match self {
            Supply::Model(_, standards) => Some(standards),
            Supply::Models(_) => None,
        }
    }

    /// `sequences` whole sequences.
    ///
    /// # Errors
    /// [`TrainError::Simulations`] if of each try one sequence leaves the numbers, [`TrainError::Source`] if sequences of several models have different lengths.
    pub(super) fn drawn(
        &self,
        sequences: usize,
        config: &PotentialLearnConfig,
        seed: &Seed,
    ) -> Result<PathBatch, TrainError> {
        let draw = match self {
            Supply::Model(model, standards) => {
                return until_whole(seed, |own| drawn(*model, sequences, config, standards, own));
            }
            Supply::Models(draw) => draw,
        };
        let of_one = |number: u64| {
            until_whole(&seed.nth(number), |own| draw(&own.child("model"), PathRequest { config, seed: own }))
        };
        let parts: Vec<PathBatch> = (0..sequences as u64).map(of_one).collect::<Result<_, _>>()?;
        PathBatch::beside(&parts).ok_or_else(|| TrainError::Source {
            reason: "models with sequences of their own of different lengths cannot be learned from together"
                .into(),
        })
    }
}

/// Tries again where a sequence left the numbers.
fn until_whole(
    seed: &Seed,
    draw: impl Fn(&Seed) -> Result<Option<PathBatch>, TrainError>,
) -> Result<PathBatch, TrainError> {
    for number in 0..TRIES {
        if let Some(found) = draw(&seed.nth(number))? {
            return Ok(found);
        }
    }
    Err(TrainError::Simulations { tries: TRIES })
}

/// Sequences of a model side by side, in a window of one of the model's own sequences where it has these; none if one leaves the numbers.
fn drawn<M: OwnModel + ?Sized>(
    model: &M,
    sequences: usize,
    config: &PotentialLearnConfig,
    standards: &PotentialStandards,
    seed: &Seed,
) -> Result<Option<PathBatch>, TrainError> {
    let mut gaps = seed.child("gaps").stream();
    let has_gaps: Vec<bool> = (0..sequences).map(|_| gaps.random::<f64>() < config.with_gaps).collect();
    let (mut batch, mut features) = (PathBatch::default(), StepFeatures::default());
    let mut steps = OwnSteps::new(model, sequences, &seed.child("sequences"))?.in_window(config.horizon);
    for _ in 0..config.horizon {
        let Some(step) = steps.advance() else { break };
        let is_missing: Vec<bool> = (0..sequences).map(|_| gaps.random::<f64>() < MISSING).collect();
        batch.add(model, &step, |at| has_gaps[at] && is_missing[at], standards, &mut features)?;
    }
    Ok((steps.lost() == 0 && batch.steps() > 0).then_some(batch))
}
