//! A learned proposal as the command has it: in a folder, with a name, for one model.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use motes_models::{ModelShape, Seed};
use motes_proposals::{Amortised, Backend, SavedError, load, load_to_tune, save};
use serde::{Deserialize, Serialize};

use crate::error::MotesError;
use crate::model::{Kind, LearnableModel, Model};

/// A proposal that was learned for a model; copies share it.
#[derive(Clone)]
pub struct LearnedProposal {
    name: String,
    proposal: Arc<Amortised>,
    notes: Arc<Notes>,
}

/// What the folder of a learned proposal says beside its weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// What it was chosen as, in a sentence.
    pub choice: String,
    /// Gradient steps that were taken.
    pub updates: usize,
    /// How long they took.
    pub seconds: f64,
    /// The designed proposal that did better on validation sequences, if one did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worse_than: Option<String>,
}

impl fmt::Debug for LearnedProposal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("LearnedProposal").field("name", &self.name).finish_non_exhaustive()
    }
}

/// What networks are made from: sizes, and the graph of what depends on what, which is the same whenever it is asked for.
pub(crate) fn shape_of(model: &dyn LearnableModel) -> ModelShape {
    ModelShape::on_dependences(model, &Seed::from_u64(0).child("dependences"))
}

impl PartialEq for LearnedProposal {
    /// Whether they are the same one.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.proposal, &other.proposal)
    }
}

impl LearnedProposal {
    pub(crate) fn new(name: String, proposal: Amortised, notes: Notes) -> Self {
        LearnedProposal { name, proposal: Arc::new(proposal), notes: Arc::new(notes) }
    }

    /// Reads the proposal in `folder`, which was learned for `model`.
    ///
    /// # Errors
    /// [`MotesError::Saved`] if it is not there, damaged, or learned for another model.
    pub fn load(folder: &Path, model: &Model) -> Result<Self, MotesError> {
        let learnable = learnable(model)?;
        let shape = shape_of(learnable);
        let proposal = load(folder, learnable, &shape, Backend::Native.into())?;
        LearnedProposal::named(folder, proposal)
    }

    /// Reads the proposal in `folder` to be learned further for `model`, whose parameters may be others than those it was learned for.
    ///
    /// # Errors
    /// [`MotesError::Saved`] if it is not there, damaged, or learned for a model with other numbers of states or measurements.
    pub fn load_to_tune(folder: &Path, model: &Model) -> Result<Self, MotesError> {
        let shape = shape_of(learnable(model)?);
        let proposal = load_to_tune(folder, &shape, Backend::Native.into())?;
        LearnedProposal::named(folder, proposal)
    }

    /// What a folder is called, with what it says beside the weights.
    fn named(folder: &Path, proposal: Amortised) -> Result<Self, MotesError> {
        let notes = motes_proposals::notes(folder)?;
        let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
        Ok(LearnedProposal::new(name, proposal, notes))
    }

    /// Writes it into `folder`, replacing a proposal that is there.
    ///
    /// # Errors
    /// [`MotesError::Saved`] if it cannot be written.
    pub fn save(&self, folder: &Path, model: &Model) -> Result<(), MotesError> {
        let learnable = learnable(model)?;
        Ok(save(folder, &*self.proposal, learnable, &shape_of(learnable), &*self.notes)?)
    }

    /// What it is called on a card.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What was written down when it was learned.
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// The proposal itself, for [`motes_smc::ParticleFilter`].
    pub fn proposal(&self) -> &Amortised {
        &self.proposal
    }
}

/// What a proposal is learned for; a linear Gaussian model by its matrices is none.
pub(crate) fn learnable(model: &Model) -> Result<&dyn LearnableModel, MotesError> {
    match model.kind() {
        Kind::Learnable(learnable) => Ok(learnable),
        Kind::LinearGaussian(_) => Err(MotesError::Proposal {
            proposal: "learned".into(),
            reason: "nothing is left to learn for kind = \"linear-gaussian\": take --proposal optimal, which is exact".into(),
        }),
    }
}

impl From<SavedError> for MotesError {
    fn from(error: SavedError) -> Self {
        MotesError::Saved(error)
    }
}
