//! What is compared, and on what.

use std::path::PathBuf;
use std::sync::Arc;

use super::designed::designed_for_recorded;
use crate::data::Data;
use crate::learned::LearnedProposal;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};

/// The most filters that are averaged for the reference of a sequence.
pub const MOST_REFERENCE_FILTERS: usize = 400;

/// What is compared, and on what.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareOptions {
    /// The proposals.
    pub proposals: Vec<ProposalName>,
    /// Filters of the card have the particles that are said here, and all that is said beside them.
    pub filter: FilterOptions,
    /// The numbers of particles at which error is held against time.
    pub particles: Vec<usize>,
    /// The number of simulated sequences; data bring their own.
    pub sequences: usize,
    /// The number of times in each of them.
    pub steps: usize,
    /// The times and inputs of simulated sequences; a model without inputs, or one that simulates them, needs none.
    pub inputs: Option<Arc<Data>>,
    /// Designed filters that do best with the most of these particles are run with three times as many, and again, up to so many; not at all if absent.
    pub particles_up_to: Option<usize>,
    /// The particles of the filters that all are held against, where there is no exact one.
    pub reference_particles: usize,
    /// How many such filters there are for a sequence, whose evidence is averaged. More than one tell how far it can be trusted; learned proposals are then
    /// among those that are tried.
    pub reference_filters: usize,
    /// The standard error that a sequence's log-evidence may have. It is that of filters that look ahead, as many as this takes, where those know it better. If not, more of the others are added until
    /// it is at most this, or there are [`MOST_REFERENCE_FILTERS`].
    pub reference_error: Option<f64>,
    /// Where references are kept and found again; nowhere if absent. Everything that they depend on must be the same whenever a folder is given.
    pub references: Option<PathBuf>,
    /// The threads of the filters that are timed; those of the reference take all that there are.
    pub timed_threads: usize,
}

impl CompareOptions {
    /// The particles of a reference filter where nothing else is said.
    pub const REFERENCE_PARTICLES: usize = 20_000;

    /// What the command holds a proposal that it has just learned against: the designed proposals, on 20 sequences of 100 times, with so many particles.
    pub fn of_learned(model: &Model, learned: LearnedProposal, particles: usize, seed: u64) -> Self {
        let filter = FilterOptions { particles, seed, ..FilterOptions::default() };
        let mut proposals = designed_for_recorded(model, &filter);
        // Where there is an optimal proposal the linearised one is the same.
        proposals.retain(|proposal| *proposal != ProposalName::Optimal);
        proposals.push(ProposalName::Learned(learned));
        CompareOptions {
            proposals,
            filter,
            particles: vec![30, 100, 300, 1000],
            // Else what is learned would be held against filters with fewer particles than suit them.
            particles_up_to: Some(10_000),
            sequences: 20,
            steps: 100,
            inputs: None,
            // In the time that a person waits for: a filter of wide states takes longer.
            reference_particles: (2 * Self::REFERENCE_PARTICLES / model.states().len().max(2)).max(4000),
            reference_filters: 1,
            reference_error: None,
            references: None,
            timed_threads: 1,
        }
    }
}
