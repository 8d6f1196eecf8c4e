//! What the folder of a learned proposal says beside its weights.

use serde::{Deserialize, Serialize};

use crate::evidence::LearnedWorth;
use crate::filter_source::FilterSource;
use crate::training_prior::TrainingPrior;

/// What the folder of a learned proposal says of its potentials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PotentialNotes {
    /// Gradient steps that were taken.
    pub updates: usize,
    /// How long they took.
    pub seconds: f64,
    /// The gain over the transition on validation sequences, in nats for a step.
    pub gain: f64,
    /// The same of potentials that see the measurement of their step alone.
    pub gain_now: f64,
    /// What filters draw by that take in one measurement after another.
    pub filters: FilterSource,
    /// What they are worth beside designed proposals, on simulated sequences; nothing before they are judged.
    pub worth: Option<LearnedWorth>,
    /// The prior over which they were learned, if they were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prior: Option<TrainingPrior>,
    /// What the folder says of all of it, where there is no network for each particle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) folder_notes: Option<Notes>,
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
    /// The designed proposal that did better on validation sequences than the network that was asked for, or is all that was learned; none if none did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worse_than: Option<String>,
}
