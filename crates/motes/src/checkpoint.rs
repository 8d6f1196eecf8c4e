//! A running filter as bytes, to go on from elsewhere or later.

use motes_models::StateSpaceModel;
use motes_proposals::{Fingerprint, OtherSystem};
use serde::{Deserialize, Serialize};

use crate::engine::Running;
use crate::error::MotesError;
use crate::filter_choice::filter_of;
use crate::model::{Kind, Model};
use crate::options::FilterOptions;
use crate::packed::{pack, unpack};
use crate::particles::Start;
use crate::running_state::RunningState;

/// What errors call it.
const CHECKPOINT: &str = "a checkpoint of a filter";

/// The version of what the bytes hold.
const VERSION: u32 = 3;

/// What the bytes hold.
#[derive(Serialize, Deserialize)]
struct Checkpoint {
    /// Of the model.
    fingerprint: Fingerprint,
    /// The kind of the proposal.
    proposal: String,
    state: RunningState,
}

impl<'m> Running<'m> {
    /// The filter between two steps as bytes: particles, weights, random streams, evidence, and what runs beside it. Model and options are not in them.
    ///
    /// ```
    /// use motes::{FilterOptions, Model, Running};
    ///
    /// let text = r#"
    ///     [initial]
    ///     x = "normal(0, 1)"
    ///     [transition]
    ///     x = "normal(0.9*x, 0.5)"
    ///     [measurement]
    ///     y = "normal(x, 0.5)"
    /// "#;
    /// let model = Model::parse(text, "walk", &[])?;
    /// let options = FilterOptions::default();
    /// let mut running = Running::new(&model, &options, 0)?;
    /// running.step(&[Some(0.3)])?;
    /// let bytes = running.checkpoint()?;
    ///
    /// // Tomorrow, in another process.
    /// let mut resumed = Running::resume(&model, &options, &bytes)?;
    /// assert_eq!(resumed.step(&[Some(0.7)])?, running.step(&[Some(0.7)])?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MotesError::Packed`] if it has no form as bytes.
    pub fn checkpoint(&self) -> Result<Vec<u8>, MotesError> {
        let of_options = Checkpoint {
            fingerprint: fingerprint(self.model),
            proposal: self.kind.to_string(),
            state: RunningState {
                filter: self.filter.snapshot(),
                time: self.time,
                has_passed: self.has_passed,
                before: self.before,
                clock: self.clock.clone(),
            },
        };
        pack(CHECKPOINT, VERSION, &of_options)
    }

    /// The filter that [`Running::checkpoint`] made `checkpoint` of, with the model and the options that it had: it goes on to the last bit as the original
    /// does. A filter that had failed has failed.
    ///
    /// # Errors
    /// [`MotesError::Packed`] if the bytes were damaged or are of another version, or were made by a filter of another model, proposal or settings; as
    /// [`Running::new`].
    pub fn resume(model: &'m Model, options: &FilterOptions, checkpoint: &[u8]) -> Result<Self, MotesError> {
        let Checkpoint { fingerprint: kept, proposal, state } = unpack(CHECKPOINT, VERSION, checkpoint)?;
        let refused = |reason| Err(MotesError::Packed { what: CHECKPOINT.into(), reason });
        if let Err(OtherSystem { what, found, expected }) = kept.check(&fingerprint(model)) {
            return refused(format!(
                "the filter was one of another model: {what} is {found} there and {expected} in the model given"
            ));
        }
        let differs = |what: &str, found: &dyn std::fmt::Debug, expected: &dyn std::fmt::Debug| {
            format!("{what} is {found:?} there and {expected:?} in the options given")
        };
        if proposal != options.proposal.kind() {
            return refused(differs("the proposal", &proposal, &options.proposal.kind()));
        }
        let expected = options.settings();
        let found = state.settings().copied().unwrap_or(expected);
        if found.particles != expected.particles {
            return refused(differs("the number of particles", &found.particles, &expected.particles));
        }
        if found != expected {
            return refused(differs("how it resamples and mixes", &found, &expected));
        }
        let is_checked = state.is_checked().unwrap_or(options.check);
        if is_checked != options.check {
            return refused(differs("whether it is checked", &is_checked, &options.check));
        }
        if !state.is_of_one_time() {
            return refused("its parts are of different times".into());
        }
        let RunningState { filter, time, has_passed, before, clock } = state;
        let filter = filter_of(model, options, Start::State(Box::new(filter)), None)?;
        Ok(Running { time, has_passed, before, clock, ..Running::of(model, options, filter) })
    }
}

/// What tells a model from others.
fn fingerprint(model: &Model) -> Fingerprint {
    let model: &dyn StateSpaceModel = match model.kind() {
        Kind::Learnable(learnable) => learnable,
        Kind::LinearGaussian(linear) => linear,
    };
    Fingerprint::of(model, None)
}
