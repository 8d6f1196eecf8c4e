//! Learned potentials: networks that say, once for each step, which states the measurements make likely: those of a whole recorded sequence, or that of the step alone.

mod config;
mod decoded;
mod features;
mod learned;
mod loss;
mod networks;
mod on_line;
mod paths;
mod standards;
mod step_memory;
mod tape;

pub use config::LearnedPotentialsConfig;
pub use features::StepFeatures;
pub use learned::LearnedPotentials;
pub use on_line::OnLinePotentials;
pub use paths::PathBatch;
pub use standards::PotentialStandards;
