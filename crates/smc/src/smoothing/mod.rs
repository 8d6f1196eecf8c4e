//! Smoothing by simulation: whole trajectories, drawn backwards through what a filter was at each time.

mod backward;
mod by_weight;
mod distinct;
mod error;
mod history;
mod moves;
mod paths;

pub use backward::{backward_simulation, backward_simulation_while};
pub use error::SmoothingError;
pub use history::FilterHistory;
pub use moves::DENSITIES_PER_MOVE;
pub use paths::SmoothedPaths;
