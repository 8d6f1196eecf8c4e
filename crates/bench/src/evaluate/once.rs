//! How proposals are learned once.

use std::ops::ControlFlow;
use std::time::Instant;

use motes_models::{Seed, SimulatedMeasurements, Simulations};
use motes_proposals::{
    Amortised, Backend, Family, Frames, Learnable, LearnedPotentials, LearnedPotentialsConfig, Origin,
    Standardised, StandardisedConfig,
};
use motes_train::{
    AdamConfig, LearnConfig, PathSource, PotentialLearnConfig, TrainConfig, TrainingData, learn,
    learn_potentials, train,
};

use super::learning::train_config;
use super::proposal_store::{Notes, ProposalStore};
use super::run::Run;
use crate::config::{Learning, Training};
use crate::learned_once::LearnedOnce;
use crate::unit_error::{UnitError, failed};

impl Run<'_> {
    /// A proposal around a designed one, by the inclusive objective.
    pub(super) fn amortised(
        self,
        kept: &ProposalStore,
        config: &<Amortised as Family>::Config,
        method: &LearnedOnce,
    ) -> Result<(Amortised, Notes), UnitError> {
        let (key, seed) = self.learned_once()?;
        kept.get((&*self.problem.model, &self.problem.shape), method.backend, &key, || {
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
        kept: &ProposalStore,
        config: &F::Config,
        training: &Training,
        method: &LearnedOnce,
    ) -> Result<(Standardised<F>, Notes), UnitError> {
        let (key, seed) = self.learned_once()?;
        kept.get((&*self.problem.model, &self.problem.shape), method.backend, &key, || {
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

    /// Potentials of any sequence of the filter's model.
    pub(super) fn potentials(self, steps: usize) -> Result<(LearnedPotentials, Notes), UnitError> {
        let none = || failed("the method has no potentials");
        let (key, seed) = self.unit.learned_potentials().ok_or_else(none)?;
        let (model, shape) = (self.problem.equations()?, &self.problem.shape);
        self.kept.get((&*self.problem.model, shape), Backend::Native, &key, || {
            let horizon = self.unit.system.horizon();
            let config = PotentialLearnConfig { steps, horizon, ..PotentialLearnConfig::new() };
            let (settings, backend) = (LearnedPotentialsConfig::default(), Backend::Native.into());
            let mut potentials =
                LearnedPotentials::create(&settings, shape, 0, backend, &seed.child("weights"))
                    .map_err(failed)?;
            let learned =
                learn_potentials(&mut potentials, PathSource::Model(model), &config, &seed, |_, _| {
                    self.interrupt.check()
                })
                .map_err(failed)?;
            self.go_on()?;
            let [gain, _] = learned.best_gains();
            Ok((potentials, Notes { seconds: learned.seconds, gain: Some(gain) }))
        })
    }

    fn learned_once(self) -> Result<(String, Seed), UnitError> {
        self.unit.learned_once().ok_or_else(|| failed("the method is not learned once"))
    }
}
