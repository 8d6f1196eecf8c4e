//! Potentials that are learned over the prior of a model's parameters.

use std::ops::ControlFlow;
use std::time::Instant;

use motes_models::Seed;
use motes_train::{PathRequest, PathSource, TrainError};

use super::options::LearnOptions;
use super::outcome::LearnOutcome;
use super::potentials::{SEQUENCES, asks_for_network, judge, judged, learns_potentials, potentials};
use crate::data::Data;
use crate::error::MotesError;
use crate::filter_source::FilterSource;
use crate::learned::{LearnedProposal, learnable, shape_of};
use crate::learned_notes::{Notes, PotentialNotes};
use crate::model::{Kind, Model};
use crate::training_prior::TrainingPrior;

/// The prior over which potentials are learned, that of all parameters that have one; none where learning is from data, a network of some kind is asked for, which knows one model, or the
/// model has times or inputs: its units are those of a schedule.
pub(super) fn prior_of(model: &Model, data: Option<&Data>, options: &LearnOptions) -> Option<TrainingPrior> {
    let Kind::Learnable(learnable) = model.kind() else { return None };
    let is_of_one_model = data.is_some() || model.timeline().is_some() || asks_for_network(options);
    if is_of_one_model || !learns_potentials(learnable, options) { None } else { TrainingPrior::of(model) }
}

/// Whether potentials are learned over the prior of a model's parameters, so that they serve all values of these.
pub fn learns_over_prior(model: &Model, data: Option<&Data>, options: &LearnOptions) -> bool {
    prior_of(model, data, options).is_some()
}

/// What is learned over a prior.
pub(super) struct PriorLearning<'a> {
    pub(super) model: &'a Model,
    pub(super) prior: TrainingPrior,
    pub(super) options: &'a LearnOptions,
    pub(super) seed: &'a Seed,
}

impl PriorLearning<'_> {
    /// Learns and judges, or says why it cannot: simulated sequences leave the numbers again and again.
    ///
    /// # Errors
    /// As [`learn`](crate::learn).
    pub(super) fn learn(
        self,
        started: Instant,
        proceed: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
    ) -> Result<Result<LearnOutcome, String>, MotesError> {
        let PriorLearning { model, prior, options, seed } = self;
        let of_model = |error: MotesError| TrainError::Source { reason: error.to_string() };
        let draw = |seed: &Seed, asked: PathRequest<'_>| {
            let drawn = TrainingPrior::draw(model, seed).map_err(of_model)?;
            asked.of(learnable(&drawn).map_err(of_model)?)
        };
        let own = learnable(model)?;
        let found = potentials(PathSource::Models(&draw), &shape_of(own), options, seed, proceed)?;
        let (found, notes) = match found {
            Ok(found) => found,
            Err(reason) => return Ok(Err(reason)),
        };
        let choice = format!("potentials alone, over the prior of {}", prior.names().join(", "));
        let (updates, seconds) = (notes.updates, notes.seconds);
        let of_all = Notes { choice, updates, seconds, worse_than: None };
        // Filters have nothing else.
        let notes = PotentialNotes { filters: FilterSource::Potential, prior: Some(prior), ..notes };
        let learned = LearnedProposal::new("learned".into(), None, of_all, own).with_potentials(found, notes);
        let seed = seed.child("recorded worth");
        let mut sequences = Vec::with_capacity(SEQUENCES);
        for number in 0..SEQUENCES as u64 {
            let seed = seed.child("sequences").nth(number);
            let drawn = TrainingPrior::draw(model, &seed.child("model"))?;
            // A sequence that leaves the numbers counts for none.
            match judged(&drawn, None, options, 1, &seed) {
                Ok(found) => sequences.extend(found),
                Err(MotesError::Simulation(_)) => {}
                Err(error) => return Err(error),
            }
        }
        if sequences.is_empty() {
            return Ok(Err(format!(
                "all of {SEQUENCES} sequences to judge by run to numbers that are not finite"
            )));
        }
        let learned = judge(model, learned, sequences, options, &seed, &mut || proceed(1, 1))?;
        let training_seconds = started.elapsed().as_secs_f64();
        let notes = Notes { seconds: training_seconds, ..learned.notes().clone() };
        Ok(Ok(LearnOutcome {
            proposal: learned.with_notes(notes),
            history: None,
            not_over_prior: None,
            no_potentials: None,
            training_seconds,
        }))
    }
}
