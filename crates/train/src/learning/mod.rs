//! Learning once: from a model's own simulations, or from a filter on recorded series.

mod by_rows;
mod course;
mod fivo;
mod held_out;
mod inclusive;
mod learn;
mod objective;
mod recorded;
mod rows;
mod settings;
mod step;
mod stretches;
mod wake;

pub use course::Learned;
pub use learn::{check_recorded, learn};
pub use objective::LearnObjective;
pub use settings::LearnConfig;
