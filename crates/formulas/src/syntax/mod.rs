//! The text of a formula, read.

mod along;
mod calls;
mod formula;
mod lookup;
mod parser;
mod parts;
mod scope;
mod token;

pub(crate) use formula::{Element, Formula, Node, NodeId};
pub(crate) use parser::parse;
pub(crate) use parts::{arguments_of_call, parts};
pub(crate) use scope::{Meaning, Scope};
