//! Heads: what a network's outputs are the parameters of.
//!
//! A head is one file with one type that implements [`Head`], and a line in [`HeadConfig`].

mod config;
mod covariance;
mod flow;
mod gaussian;
mod head;
mod kernel;
mod mixture;
mod normal;
mod spline;

pub use config::HeadConfig;
pub use covariance::Covariance;
pub use flow::FlowHead;
pub use gaussian::GaussianHead;
pub use head::{Head, Reparametrised};
pub use kernel::KernelHead;
pub use mixture::MixtureHead;
