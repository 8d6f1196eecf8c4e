//! Proposals designed by hand.

mod bootstrap;
mod defensive;
mod min_degeneracy;

pub use bootstrap::Bootstrap;
pub use defensive::Defensive;
pub use min_degeneracy::MinDegeneracy;
