//! A unit being run.

use std::ops::ControlFlow;
use std::path::Path;

use motes_cli::Interrupt;

use super::proposal_store::ProposalStore;
use crate::checkpoint::Checkpoints;
use crate::problem::Problem;
use crate::reference::References;
use crate::unit::UnitConfig;
use crate::unit_error::UnitError;

/// A unit being run.
#[derive(Clone, Copy)]
pub(super) struct Run<'a> {
    pub(super) unit: &'a UnitConfig,
    pub(super) problem: &'a Problem,
    pub(super) references: &'a References,
    /// Where trained proposals are kept, if they are.
    pub(super) models: Option<&'a Path>,
    /// Where trainings are checkpointed, if they are.
    pub(super) checkpoints: Option<&'a Checkpoints>,
    /// Where proposals are kept that are learned once.
    pub(super) kept: &'a ProposalStore,
    pub(super) interrupt: &'a Interrupt,
}

impl Run<'_> {
    /// An error where the run is being stopped.
    pub(super) fn go_on(self) -> Result<(), UnitError> {
        match self.interrupt.check() {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(UnitError::Interrupted),
        }
    }
}
