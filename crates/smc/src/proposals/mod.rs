//! Proposals designed by hand.

mod bootstrap;
mod defensive;
mod min_degeneracy;

pub use bootstrap::{Bootstrap, Transition};
pub use defensive::{Defensive, Mixture};
pub use min_degeneracy::{MinDegeneracy, Shifted};
