//! The linearised proposal: one Fisher-scoring step from the predicted state.

mod batch;
mod factor;
mod proposal;
mod scoring;
mod scratch;

pub use batch::LinearisedBatch;
pub use proposal::Linearised;
pub use scratch::LinearisedScratch;
