//! The maximum of a likelihood of which there are estimates alone.

mod height;
mod hill;
mod interval;
mod iterated;
mod iterated_profile;
mod point;
mod profile;
mod quadratic;
mod refinement;
mod search;
mod settings;
mod swarm_shape;
mod walks;

pub use point::{Maximum, Profile, ProfilePoint};
pub use search::MaximumSearch;
pub use settings::{IteratedSettings, MaximumSettings};
