//! What the Gaussian families share: networks emit a mean and a representation, and all that is probabilistic follows.

mod covariance;
mod hidden;
mod networks;
mod proposal;
mod propose;
mod tape;

pub use covariance::KernelCovariance;
pub use hidden::{Hidden, HiddenRows};
pub use networks::GaussianNetworks;
pub use proposal::GaussianProposal;
pub use propose::GaussianScratch;
