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
    /// Why it serves the values alone that the model has, where learning over the prior was tried for.
    pub not_over_prior: Option<String>,
    /// Why there are no potentials beside a network, where they were tried for.
    pub no_potentials: Option<String>,
    /// How long it all took: choosing, training, and judging what the folder says of it.
    pub training_seconds: f64,
}

impl LearnOutcome {
    /// What was tried and did not come about.
    pub fn warnings(&self) -> Vec<String> {
        let over_prior = self.not_over_prior.as_ref().map(|reason| {
            format!("it serves the values alone that the parameters have here, and not all of their priors: {reason}")
        });
        let potentials =
            self.no_potentials.as_ref().map(|reason| format!("no potentials for recorded data: {reason}"));
        over_prior.into_iter().chain(potentials).collect()
    }

    /// What validation of a network for each particle said after so many updates; nothing where there is none.
    pub fn validation(&self) -> Vec<(usize, f64)> {
        self.history.as_ref().map_or_else(Vec::new, |history| history.validation.clone())
    }
}
