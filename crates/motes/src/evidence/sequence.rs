//! A series of data, and filters that run over it.

use std::ops::ControlFlow;

use motes_models::{Seed, Step};
use motes_smc::{FilterError, LookAhead, RecordedStep};

use crate::data::{Data, RowSource};
use crate::engine::Running;
use crate::error::MotesError;
use crate::exact::log_evidence_alone;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::recorded::{look_ahead, recorded_steps};

/// A series of data, prepared once for many filters.
pub(crate) struct RecordedSequence {
    /// Its name, where the data have several.
    name: Option<String>,
    steps: Vec<RecordedStep>,
    /// Where the row that each step leads to stands in the data.
    lines: Vec<u64>,
    source: RowSource,
}

/// What is asked on the way, from any thread.
pub(crate) type Proceed<'p> = &'p (dyn Fn() -> ControlFlow<()> + Sync);

/// Steps after which it is asked.
pub(crate) const STEPS_AT_ONCE: usize = 64;

/// All series of some data.
pub(crate) fn sequences(data: &Data) -> Vec<RecordedSequence> {
    let of_series = |(name, places): (&String, Vec<usize>)| {
        let rows = places.iter().map(|at| &data.rows[*at]);
        RecordedSequence {
            name: data.columns.has_series().then(|| name.clone()),
            steps: recorded_steps(data, &places),
            lines: rows.flat_map(|row| vec![row.line; row.steps.len()]).collect(),
            source: data.source.clone(),
        }
    };
    data.series.iter().zip(data.by_series()).map(of_series).collect()
}

impl RecordedSequence {
    /// One without a name.
    pub(crate) fn of_steps(steps: Vec<RecordedStep>) -> Self {
        let lines = (0..steps.len() as u64).collect();
        RecordedSequence { name: None, steps, lines, source: RowSource::of_table() }
    }

    /// Its steps, with what is measured at their ends.
    pub(crate) fn steps(&self) -> &[RecordedStep] {
        &self.steps
    }

    /// A step of it like the others; that at the start where there is no other.
    pub(crate) fn typical_step(&self) -> Step<'_> {
        self.steps.get(self.steps.len() / 2).map_or(Step::of_index(0), |recorded| recorded.step.step())
    }

    /// Potentials of all of it, if the proposal has any.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if they cannot be had.
    pub(crate) fn look_ahead(
        &self,
        proposal: &ProposalName,
        model: &Model,
    ) -> Result<Option<LookAhead>, MotesError> {
        look_ahead(proposal, model, &self.steps)
    }

    /// The log-evidence that one filter estimates, with potentials of its own where it looks ahead; −∞ where no particle explains a measurement.
    ///
    /// # Errors
    /// As [`RecordedSequence::log_evidence`], and [`MotesError::Proposal`] if there are no potentials.
    pub(crate) fn log_evidence_alone(
        &self,
        model: &Model,
        options: &FilterOptions,
        seed: Seed,
        proceed: Proceed<'_>,
    ) -> Result<f64, MotesError> {
        if options.proposal == ProposalName::Exact
            && let Some(found) = log_evidence_alone(model, &self.steps)
        {
            return Ok(found);
        }
        let ahead = self.look_ahead(&options.proposal, model)?;
        self.log_evidence(model, options, seed, ahead.as_ref(), proceed)
    }

    /// The log-evidence that one filter estimates; −∞ where no particle explains a measurement.
    ///
    /// # Errors
    /// As [`Running::new`] and [`Running::advance`], and [`MotesError::Interrupted`].
    pub(crate) fn log_evidence(
        &self,
        model: &Model,
        options: &FilterOptions,
        seed: Seed,
        ahead: Option<&LookAhead>,
        proceed: Proceed<'_>,
    ) -> Result<f64, MotesError> {
        let mut running = Running::with_seed(model, options, seed, ahead)?;
        for (number, RecordedStep { step, measurement }) in self.steps.iter().enumerate() {
            let step = step.step();
            match running.filter.step(&step, measurement) {
                Ok(()) => {}
                // Nobody reads why, so that it is not looked for.
                Err(FilterError::Collapse { .. }) => return Ok(f64::NEG_INFINITY),
                Err(error) => return Err(self.placed(number, running.explain(&error, &step, measurement))),
            }
            if number % STEPS_AT_ONCE == 0 && proceed().is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        Ok(running.log_evidence())
    }

    /// An error at the step of that number, with the series and the row.
    fn placed(&self, number: usize, error: MotesError) -> MotesError {
        error.at_row(&self.source, self.name.as_deref(), self.lines[number])
    }

    /// Why the evidence of [`RecordedSequence::log_evidence_alone`] is 0, or there is none: the row, and what is wrong with it; none where all is well.
    pub(crate) fn failure(&self, model: &Model, options: &FilterOptions, seed: Seed) -> Option<String> {
        let ahead = self.look_ahead(&options.proposal, model);
        let running = ahead.and_then(|ahead| Running::with_seed(model, options, seed, ahead.as_ref()));
        let mut running = match running {
            Ok(running) => running,
            Err(error) => return Some(error.to_string()),
        };
        self.steps.iter().enumerate().find_map(|(number, RecordedStep { step, measurement })| {
            let step = step.step();
            let error = running.filter.step(&step, measurement).err()?;
            Some(self.placed(number, running.explain(&error, &step, measurement)).to_string())
        })
    }
}
