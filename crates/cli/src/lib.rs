//! What the programs of Motes share: arguments with errors of one line, lines for a person, and signals.

#[cfg(feature = "command")]
mod arguments;
#[cfg(feature = "command")]
mod interrupt;
mod lines;
mod names;
#[cfg(feature = "command")]
mod numbers;

#[cfg(feature = "command")]
pub use arguments::{Parsed, UsageError, parse};
#[cfg(feature = "command")]
pub use interrupt::Interrupt;
pub use lines::{result, status};
pub use names::{nearest, one_of};
#[cfg(feature = "command")]
pub use numbers::integer;
