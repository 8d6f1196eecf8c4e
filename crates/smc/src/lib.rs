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
mod blocks;
mod diagnosis;
mod error;
mod filter;
mod fixed_lag;
mod proposal;
mod proposals;
mod resampling;
mod weights;
mod workers;

pub use bank::{FilterBank, FilterSettings};
pub use diagnosis::{
    LEAST_EFFECTIVE_PARTICLES, TAIL_INDEX_LIMIT, WeightDiagnosis, WeightReport, WeightWarning, tail_index,
};
pub use error::{ErrorKind, FilterError};
pub use filter::ParticleFilter;
pub use fixed_lag::FixedLagSmoother;
pub use motes_models::batch::particles_by_stream;
pub use proposal::{Conditional, Past, Proposal, ProposalError, RowPast, RowProposal};
pub use proposals::{Bootstrap, MinDegeneracy, Shifted, Transition};
pub use resampling::{ParticleMemory, ResampleWhen, Resampling};
pub use weights::{LogWeights, WeightFault};

/// The README's code, compiled and run as a documentation test.
#[doc = include_str!("../README.md")]
#[cfg(doctest)]
pub struct Readme;
