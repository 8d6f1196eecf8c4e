//! What is compared, and on what.

use crate::options::{FilterOptions, ProposalName};

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
    /// The particles of the filters that all are held against, where there is no exact one.
    pub reference_particles: usize,
    /// How many such filters there are for a sequence, whose evidence is averaged. More than one tell how far it can be trusted; learned proposals are then
    /// among those that are tried.
    pub reference_filters: usize,
    /// The threads of the filters that are timed; those of the reference take all that there are.
    pub timed_threads: usize,
}
