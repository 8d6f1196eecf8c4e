//! Particle filters: weights, resampling, log-evidence, and proposals designed by hand.
//!
//! A filter approximates `p(x_t | y_{0:t})` by `K` weighted particles. At each measurement it draws every
//! particle from a [`Proposal`] and weighs it by `p(y_t | x_t) p(x_t | x_{t−1}) / q(x_t | x_{t−1}, y_t)`.
//! [`ParticleFilter`] is one filter on a stream of measurements; [`FilterBank`] is many independent ones advanced
//! as a single batch, which is what proposals made of networks want. Both are steppers: they record nothing,
//! and what should be remembered is read off them between two steps. [`FixedLagSmoother`] also remembers the last few generations, and
//! so estimates earlier states by later measurements.
//!
//! Nothing here knows of neural networks; learned proposals implement the same [`Proposal`] in another crate.

mod bank;
mod diagnosis;
mod error;
mod evidence;
mod filter;
mod filter_snapshot;
mod fixed_lag;
mod look_ahead;
mod memory;
mod parallel;
mod perturbed;
mod predictive;
mod proposal;
mod proposal_error;
mod proposals;
mod resampling;
mod second_opinion;
mod smoothing;
mod streams;
mod weights;

pub use bank::{BankSnapshot, FilterBank, FilterSettings};
pub use diagnosis::{
    LEAST_EFFECTIVE_PARTICLES, PARETO_K_LIMIT, WeightDiagnosis, WeightReport, WeightWarning, pareto_k,
};
pub use error::{ErrorKind, FilterError};
pub use evidence::{
    AncestryVariance, CheckSnapshot, EvidenceCheck, EvidenceWarning, LARGEST_ERROR, error_of_variance,
    variance_of_error,
};
pub use filter::ParticleFilter;
pub use filter_snapshot::FilterSnapshot;
pub use fixed_lag::FixedLagSmoother;
pub use look_ahead::{
    ByPotential, LookAhead, LookAheadBatch, LookAheadError, LookAheadScratch, PotentialComponent,
    RecordedStep, StepPotentials,
};
pub use memory::{MemoryRows, ParticleMemory};
pub use motes_models::batch::{Rows, particles_by_stream};
pub use perturbed::{Perturbation, PerturbedFilter};
pub use predictive::Predictive;
pub use proposal::{Conditional, Context, Proposal};
pub use proposal_error::ProposalError;
pub use proposals::{
    Bootstrap, Corrected, GaussianBatch, Linearised, LinearisedBatch, LinearisedScratch, MinDegeneracy,
    Transition, fisher_scoring, noise_share, weigh_with_share,
};
pub use resampling::{ResampleWhen, Resampling};
pub use second_opinion::{SecondOpinion, Verdict};
pub use smoothing::{
    DENSITIES_PER_MOVE, FilterHistory, SmoothedPaths, SmoothingError, backward_simulation,
    backward_simulation_while,
};
pub use weights::{LogWeights, WeightFault};

/// The README's code, compiled and run as a documentation test.
#[doc = include_str!("../README.md")]
#[cfg(doctest)]
pub struct Readme;
