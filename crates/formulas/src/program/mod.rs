//! A section's graph as a list of small operations, and what computes it.

mod compile;
mod instruction;
mod interpret;
mod kept;
mod known;
mod made;
mod moment;
mod registers;

pub(crate) use compile::compile;
pub(crate) use instruction::Program;
pub(crate) use known::{Known, KnownPart};
