//! The text of a formula, read.

mod formula;
mod lookup;
mod parser;
mod scope;
mod token;

pub(crate) use formula::{Element, Formula, Node, NodeId};
pub(crate) use parser::parse;
pub(crate) use scope::{Meaning, Scope};
