//! Proposals designed by hand, and what they are made of.

mod bootstrap;
mod defensive;
mod gaussian_batch;
mod linearised;
mod log_add;
mod min_degeneracy;
mod noise_share;

pub use bootstrap::{Bootstrap, Transition};
pub(crate) use defensive::Defensive;
pub use gaussian_batch::GaussianBatch;
pub(crate) use linearised::lanes;
pub use linearised::{Linearised, LinearisedBatch, LinearisedScratch, fisher_scoring};
pub(crate) use log_add::{NEGLIGIBLE, log_add};
pub use min_degeneracy::{Corrected, MinDegeneracy};
pub use noise_share::{noise_share, weigh_with_share};
