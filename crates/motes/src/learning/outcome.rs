//! What came of learning.

use motes_train::Learned;

use crate::learned::LearnedProposal;

/// What came of learning.
#[derive(Debug, Clone)]
pub struct LearnOutcome {
    /// The proposal, with the best weights on validation sequences.
    pub proposal: LearnedProposal,
    /// The course of the training of a network for each particle; none where potentials were learned alone, over a prior.
    pub history: Option<Learned>,
    /// Why there are no potentials beside it, where they were tried for.
    pub no_potentials: Option<String>,
    /// How long it all took: choosing, training, and judging what the folder says of it.
    pub training_seconds: f64,
}

impl LearnOutcome {
    /// What validation of a network for each particle said after so many updates; nothing where there is none.
    pub fn validation(&self) -> Vec<(usize, f64)> {
        self.history.as_ref().map_or_else(Vec::new, |history| history.validation.clone())
    }
}
