//! Potentials that are learned over the prior of a model's parameters.

use std::ops::ControlFlow;
use std::time::Instant;

use motes_formulas::Schedule;
use motes_models::Seed;
use motes_proposals::Sees;
use motes_train::{PathRequest, PathSource, TrainError};

use super::options::LearnOptions;
use super::outcome::LearnOutcome;
use super::potentials::{SEQUENCES, judge, judged, potentials};
use super::worth::worse_than;
use crate::data::Data;
use crate::error::MotesError;
use crate::learned::{LearnedProposal, Notes, PotentialNotes, learnable, shape_of};
use crate::model::Model;
use crate::over_prior::OverPrior;

/// The prior over which potentials are learned: that of all parameters that have one, unless a network of some kind is asked for, which knows one model.
pub(super) fn prior_of(model: &Model, options: &LearnOptions) -> Option<OverPrior> {
    let is_asked = options.start.is_some()
        || options.base.is_some()
        || options.head.is_some()
        || options.widths.is_some()
        || options.sees != Sees::All
        || options.dropout > 0.0
        || options.weight_penalty > 0.0;
    if is_asked { None } else { OverPrior::of(model) }
}

/// What is learned over a prior.
pub(super) struct PriorLearning<'a> {
    pub(super) model: &'a Model,
    pub(super) data: Option<&'a Data>,
    pub(super) schedule: Option<&'a Schedule>,
    pub(super) prior: OverPrior,
    pub(super) options: &'a LearnOptions,
    pub(super) seed: &'a Seed,
}

impl PriorLearning<'_> {
    /// Learns and judges, or says why it cannot: simulated sequences leave the numbers again and again.
    ///
    /// # Errors
    /// As [`learn`](super::learn).
    pub(super) fn learn(
        self,
        started: Instant,
        proceed: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
    ) -> Result<Result<LearnOutcome, String>, MotesError> {
        let PriorLearning { model, data, schedule, prior, options, seed } = self;
        let of_model = |error: MotesError| TrainError::Source { reason: error.to_string() };
        let draw = |seed: &Seed, asked: PathRequest<'_>| {
            let drawn = OverPrior::draw(model, schedule, seed).map_err(of_model)?;
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
        let notes = PotentialNotes { filters: true, prior: Some(prior), ..notes };
        let learned = LearnedProposal::new("learned".into(), None, of_all, own).with_potentials(found, notes);
        let seed = seed.child("recorded worth");
        let mut sequences = Vec::with_capacity(SEQUENCES);
        for number in 0..SEQUENCES as u64 {
            let seed = seed.child("sequences").nth(number);
            let drawn = OverPrior::draw(model, None, &seed.child("model"))?;
            // A sequence that leaves the numbers counts for none.
            match judged(&drawn, data, options, 1, &seed) {
                Ok(found) => sequences.extend(found),
                Err(MotesError::Simulation(_)) => {}
                Err(error) => return Err(error),
            }
        }
        let learned = judge(model, learned, sequences, options, &seed, &mut || proceed(1, 1))?;
        let worse_than = worse_than(model, &learned, data, options, &seed.child("worth"))?;
        let training_seconds = started.elapsed().as_secs_f64();
        let notes = Notes { worse_than, seconds: training_seconds, ..learned.notes().clone() };
        Ok(Ok(LearnOutcome {
            proposal: learned.with_notes(notes),
            history: None,
            no_potentials: None,
            training_seconds,
        }))
    }
}
