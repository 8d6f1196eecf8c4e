//! Proposals designed by hand.

mod bootstrap;
mod defensive;
mod min_degeneracy;

pub use bootstrap::{Bootstrap, Transition};
pub(crate) use defensive::{Defensive, Densities};
pub use min_degeneracy::{MinDegeneracy, Shifted};
