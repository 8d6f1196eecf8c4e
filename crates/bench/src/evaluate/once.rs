//! Proposals that are learned once: the first unit that needs one learns and keeps it, all others read it.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

use motes_models::{Seed, SimulatedMeasurements, Simulations};
use motes_proposals::{
    Amortised, Backend, Family, Frames, Learnable, Origin, Standardised, StandardisedConfig, load, notes,
    save,
};
use motes_train::{AdamConfig, LearnConfig, TrainConfig, TrainingData, learn, train};
use serde::{Deserialize, Serialize};

use super::learning::train_config;
use super::run::Run;
use crate::config::{Learning, Training};
use crate::learned_once::LearnedOnce;
use crate::metric::Metric;
use crate::unit_error::{UnitError, failed};

/// Where proposals that are learned once are kept, and which of them are being learned.
#[derive(Default)]
pub(super) struct Kept {
    /// Each in a folder of its own, named by its key; where there is none, each unit learns its own.
    folder: Option<PathBuf>,
    known: Mutex<HashMap<String, Slot>>,
}

/// Filled by the first that needs it, while others that need the same wait.
type Slot = Arc<OnceLock<Result<(), UnitError>>>;

/// What is written down of a proposal that was learned once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Notes {
    /// How long it took.
    seconds: f64,
    /// How much likelier than the transition it finds states of validation sequences, in nats a step, where it learned that way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    gain: Option<f64>,
}

impl Notes {
    pub(super) fn metrics(&self) -> Option<Metric> {
        self.gain.map(|gain| Metric::new("gain", gain))
    }

    pub(super) fn timings(&self) -> Metric {
        Metric::new("train_seconds", self.seconds)
    }
}

impl Kept {
    pub(super) fn new(folder: PathBuf) -> Self {
        Kept { folder: Some(folder), known: Mutex::default() }
    }

    /// The proposal of this key: read, or learned and then read, so that it is the same in either case.
    fn get<F: Family>(
        &self,
        run: Run<'_>,
        backend: Backend,
        key: &str,
        learn: impl FnOnce() -> Result<(F, Notes), UnitError>,
    ) -> Result<(F, Notes), UnitError> {
        let Some(folder) = &self.folder else { return learn() };
        let folder = folder.join(key);
        let (model, shape) = (&*run.problem.model, &run.problem.shape);
        let read = || {
            let proposal = load::<F>(&folder, model, shape, backend.into())?;
            Ok::<_, motes_proposals::SavedError>((proposal, notes::<Notes>(&folder)?))
        };
        let slot =
            self.known.lock().unwrap_or_else(PoisonError::into_inner).entry(key.into()).or_default().clone();
        let found = slot.get_or_init(|| {
            if read().is_ok() {
                return Ok(());
            }
            let (proposal, notes) = learn()?;
            save(&folder, &proposal, model, shape, &notes)
                .map_err(|error| UnitError::NotKept(error.to_string()))
        });
        if matches!(found, Err(UnitError::Interrupted | UnitError::NotKept(_))) {
            self.known.lock().unwrap_or_else(PoisonError::into_inner).remove(key);
        }
        found.clone()?;
        read().map_err(failed)
    }
}

impl Run<'_> {
    /// A proposal around a designed one, by the inclusive objective.
    pub(super) fn amortised(
        self,
        kept: &Kept,
        config: &<Amortised as Family>::Config,
        method: &LearnedOnce,
    ) -> Result<(Amortised, Notes), UnitError> {
        let (key, seed) = self.learned_once()?;
        kept.get(self, method.backend, &key, || {
            let Learning { horizon, learning_rate, rows, largest_state, .. } = method.learning;
            let new = LearnConfig::new();
            let settings = LearnConfig {
                steps: method.steps,
                rows,
                horizon,
                largest_state,
                validate_every: new.validate_every.min(method.steps),
                adam: AdamConfig { learning_rate, ..new.adam },
                ..new
            };
            let weights = seed.child("weights");
            let shape = &self.problem.shape;
            let mut proposal =
                Amortised::create(config, shape, 0, method.backend.into(), &weights).map_err(failed)?;
            let model = &*self.problem.model;
            let mut is_stopped = false;
            let learned = learn(&mut proposal, model, &[], &settings, &seed, |_, _| {
                is_stopped = self.interrupt.check().is_break();
                if is_stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
            .map_err(failed)?;
            if is_stopped {
                return Err(UnitError::Interrupted);
            }
            Ok((proposal, Notes { seconds: learned.seconds, gain: Some(learned.best_gain()) }))
        })
    }

    /// A family of the paper around a linear prediction, by the evidence lower bound of fresh sequences.
    pub(super) fn by_elbo<F: Family<Config: Clone> + Learnable>(
        self,
        kept: &Kept,
        config: &F::Config,
        training: &Training,
        method: &LearnedOnce,
    ) -> Result<(Standardised<F>, Notes), UnitError> {
        let (key, seed) = self.learned_once()?;
        kept.get(self, method.backend, &key, || {
            let start = Instant::now();
            let Learning { horizon, largest_state, elbo, .. } = &method.learning;
            let (model, largest) = (&*self.problem.model, largest_state.unwrap_or(f64::MAX));
            let of_frames = seed.child("frames");
            let simulations = Simulations::draw(model, *horizon, elbo.trajectories, largest, &of_frames);
            let frames = Frames::of(&simulations.map_err(failed)?, Origin::Prediction).map_err(failed)?;
            let config = StandardisedConfig { family: config.clone(), frames };
            let (shape, weights) = (&self.problem.shape, seed.child("weights"));
            let mut proposal =
                Standardised::<F>::create(&config, shape, *horizon, method.backend.into(), &weights)
                    .map_err(failed)?;
            let steps = method.steps.div_ceil(elbo.steps_for_one);
            let settings = train_config(training, elbo.particles, steps);
            let settings = TrainConfig { sequences_per_step: elbo.sequences, ..settings };
            let source = SimulatedMeasurements::new(model, *horizon, largest);
            let mut stream = seed.child("training").stream();
            let mut is_stopped = false;
            let data = TrainingData::Fresh(&source);
            train(&mut proposal, model, data, &settings, &mut stream, |_, _| {
                is_stopped = self.interrupt.check().is_break();
                if is_stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
            .map_err(failed)?;
            if is_stopped {
                return Err(UnitError::Interrupted);
            }
            Ok((proposal, Notes { seconds: start.elapsed().as_secs_f64(), gain: None }))
        })
    }

    fn learned_once(self) -> Result<(String, Seed), UnitError> {
        self.unit.learned_once().ok_or_else(|| failed("the method is not learned once"))
    }
}
