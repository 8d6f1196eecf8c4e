//! The graph-diffusion systems of the paper's figures 1 to 6.

mod batches;
mod config;
mod model;
mod system;
mod transport;

pub use config::{Drift, GraphDiffusionConfig};
pub use system::GraphDiffusion;
