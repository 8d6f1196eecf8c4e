//! The text of a formula, read.

mod along;
mod calls;
mod formula;
mod lookup;
mod meaning;
mod parser;
mod parts;
mod scope;
mod token;
mod total;

pub(crate) use formula::{Element, Formula, Node, NodeId};
pub(crate) use meaning::Meaning;
pub(crate) use parser::parse;
pub(crate) use parts::{arguments_of_call, parts};
pub(crate) use scope::Scope;
pub(crate) use total::{Since, Total, Totals};
