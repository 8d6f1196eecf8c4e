//! A series of data, and filters that run over it.

use std::ops::ControlFlow;

use motes_models::Seed;
use motes_smc::{FilterError, LookAhead, RecordedStep};

use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::filtering::of_series;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::recorded::{look_ahead, recorded_steps};

/// A series of data.
pub(super) struct Sequence {
    /// Its name, where the data have several.
    name: Option<String>,
    steps: Vec<RecordedStep>,
}

/// What is asked on the way, from any thread.
pub(super) type Proceed<'p> = &'p (dyn Fn() -> ControlFlow<()> + Sync);

/// Steps after which it is asked.
const STEPS_AT_ONCE: usize = 64;

/// All series of some data.
pub(super) fn sequences(data: &Data) -> Vec<Sequence> {
    let of_series = |(name, places): (&String, Vec<usize>)| Sequence {
        name: data.columns.has_series().then(|| name.clone()),
        steps: recorded_steps(data, &places),
    };
    data.series.iter().zip(data.by_series()).map(of_series).collect()
}

impl Sequence {
    /// Potentials of all of it, if the proposal has any.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if they cannot be had.
    pub(super) fn look_ahead(
        &self,
        proposal: &ProposalName,
        model: &Model,
    ) -> Result<Option<LookAhead>, MotesError> {
        look_ahead(proposal, model, &self.steps)
    }

    /// The log-evidence that one filter estimates; −∞ where no particle explains a measurement.
    ///
    /// # Errors
    /// As [`Running::new`] and [`Running::advance`], and [`MotesError::Interrupted`].
    pub(super) fn log_evidence(
        &self,
        model: &Model,
        options: &FilterOptions,
        seed: Seed,
        ahead: Option<&LookAhead>,
        proceed: Proceed<'_>,
    ) -> Result<f64, MotesError> {
        let mut running = Running::with_seed(model, options, seed, ahead)?;
        for (number, RecordedStep { step, measurement }) in self.steps.iter().enumerate() {
            if let Err(error) = running.take_step(&step.step(), measurement) {
                return match running.filter.failure() {
                    Some(FilterError::Collapse { .. }) => Ok(f64::NEG_INFINITY),
                    _ => Err(of_series(self.name.as_deref(), error)),
                };
            }
            if number % STEPS_AT_ONCE == 0 && proceed().is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        Ok(running.log_evidence())
    }
}
