//! What the programs of Motes share: arguments with errors of one line, lines for a person, and signals.

mod arguments;
mod interrupt;
mod lines;
mod names;
mod numbers;

pub use arguments::{Parsed, UsageError, parse};
pub use interrupt::Interrupt;
pub use lines::{result, status};
pub use names::one_of;
pub use numbers::integer;
