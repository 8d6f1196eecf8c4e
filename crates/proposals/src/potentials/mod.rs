//! Learned potentials: networks that see a whole recorded sequence and say, once for each step, where all that is measured from then on wants the state to be.

mod config;
mod decoded;
mod features;
mod loss;
mod networks;
mod sequence;
mod standards;
mod tape;

pub use config::SequencePotentialsConfig;
pub use features::{SequenceBatch, StepFeatures};
pub use sequence::SequencePotentials;
pub use standards::PotentialStandards;
