//! Any learned family in units that suit networks: standardised inputs, and outputs around an origin.

mod family;
mod fit;
mod frame;
mod propose;
mod tape;

pub use family::{Standardised, StandardisedConfig};
pub use fit::Origin;
pub use frame::{Frame, Frames};
pub use propose::StandardisedScratch;
