//! The text of a formula, read.

mod formula;
mod lookup;
mod meaning;
mod parser;
mod scope;
mod sum;
mod token;

pub(crate) use formula::{Element, Formula, Node, NodeId};
pub(crate) use meaning::Meaning;
pub(crate) use parser::parse;
pub(crate) use scope::Scope;
pub(crate) use sum::{Since, Sum, Sums};
