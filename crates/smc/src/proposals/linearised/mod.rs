//! The linearised proposal: one Fisher-scoring step from the predicted state.

mod batch;
mod noise;
mod precision_batch;
mod proposal;
mod scoring;
mod scratch;

pub use batch::LinearisedBatch;
pub use proposal::Linearised;
pub use scoring::fisher_scoring;
pub use scratch::LinearisedScratch;
pub(crate) use scratch::lanes;
