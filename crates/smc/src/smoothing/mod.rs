//! Smoothing by simulation: whole trajectories, drawn backwards through what a filter was at each time.

mod backward;
mod error;
mod history;
mod paths;

pub use backward::{backward_simulation, backward_simulation_while};
pub use error::SmoothingError;
pub use history::FilterHistory;
pub use paths::SmoothedPaths;
