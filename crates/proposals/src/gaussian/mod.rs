//! What the Gaussian families share: networks emit a mean and a representation, and all that is probabilistic follows.

mod batch;
mod covariance;
mod hidden;
mod networks;
mod proposal;
mod propose;
mod tape;

pub use batch::GaussianBatch;
pub use covariance::KernelCovariance;
pub use hidden::Hidden;
pub use networks::GaussianNetworks;
pub use proposal::GaussianProposal;
