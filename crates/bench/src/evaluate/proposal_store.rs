//! Proposals that are learned once, on disk: the first unit that needs one has it learned, all others read it.

use std::path::PathBuf;
use std::time::Duration;

use motes_models::ModelShape;
use motes_proposals::{Backend, Family, load, notes, save};
use serde::{Deserialize, Serialize};

use crate::computed_once::ComputedOnce;
use crate::metric::Metric;
use crate::problem::Model;
use crate::unit_error::UnitError;

/// Where proposals that are learned once are kept, and which of them are being learned.
#[derive(Default)]
pub(super) struct ProposalStore {
    /// Each in a folder of its own, named by its key; where there is none, each unit learns its own.
    folder: Option<PathBuf>,
    known: ComputedOnce<()>,
}

/// How often a proposal is read that ought to be there, ...
const ATTEMPTS: usize = 20;
/// ... and how long after the last time.
const PAUSE: Duration = Duration::from_millis(100);

/// What is written down of a proposal that was learned once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Notes {
    /// How long it took.
    pub(super) seconds: f64,
    /// How much likelier than the transition it finds states of validation sequences, in nats a step, where it learned that way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) gain: Option<f64>,
}

impl Notes {
    pub(super) fn metrics(&self) -> Option<Metric> {
        self.gain.map(|gain| Metric::new("gain", gain))
    }

    pub(super) fn timings(&self) -> Metric {
        Metric::new("train_seconds", self.seconds)
    }
}

impl ProposalStore {
    pub(super) fn new(folder: PathBuf) -> Self {
        ProposalStore { folder: Some(folder), known: ComputedOnce::default() }
    }

    /// The proposal of this key: read, or learned and then read, so that it is the same in either case.
    pub(super) fn get<F: Family>(
        &self,
        (model, shape): (&Model, &ModelShape),
        backend: Backend,
        key: &str,
        learn: impl FnOnce() -> Result<(F, Notes), UnitError>,
    ) -> Result<(F, Notes), UnitError> {
        let Some(folder) = &self.folder else { return learn() };
        let folder = folder.join(key);
        let read = || {
            let proposal = load::<F>(&folder, model, shape, backend.into())?;
            Ok::<_, motes_proposals::SavedError>((proposal, notes::<F, Notes>(&folder)?))
        };
        self.known.of(key, || {
            if read().is_ok() {
                return Ok(());
            }
            let (proposal, notes) = learn()?;
            // A task on another machine may have learned the same meanwhile: one of the two is kept, and is read by both.
            if read().is_ok() {
                return Ok(());
            }
            match save(&folder, &proposal, model, shape, &notes) {
                Err(error) if read().is_err() => Err(UnitError::NotKept(error.to_string())),
                _ => Ok(()),
            }
        })?;
        // A network's file system may show it a moment later than who wrote it.
        for _ in 0..ATTEMPTS {
            if let Ok(found) = read() {
                return Ok(found);
            }
            std::thread::sleep(PAUSE);
        }
        read().map_err(|error| UnitError::NotKept(error.to_string()))
    }
}
