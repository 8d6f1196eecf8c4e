//! Numbers that are written as formulas of constants.

use std::collections::BTreeMap;

use crate::document::{Entry, Found};
use crate::error::{Fault, Problem, Section};
use crate::operations::choice;
use crate::syntax::{Formula, Meaning, Node, Scope, parse};

/// Reads formulas of numbers and parameters.
#[derive(Clone, Copy)]
pub(super) struct Constants<'a> {
    /// The parameters.
    pub(super) names: &'a BTreeMap<String, Meaning>,
}

impl Constants<'_> {
    /// The formula of a text.
    pub(super) fn parse(&self, text: &str, section: Section) -> Result<Formula, Fault> {
        parse(
            text,
            Scope { names: self.names, own: "", section, is_vector: false, totals: None, arguments: &[] },
        )
    }

    /// The number of an entry: one, or a formula of constants in quotes.
    pub(super) fn value(&self, entry: &Entry, section: Section) -> Result<f64, Fault> {
        let at = entry.value.at;
        let fault = |problem| Fault::at(at, problem).in_section(section).of_key(&entry.key);
        let value = match &entry.value.found {
            Found::Number(value, _) => Some(*value),
            Found::Text { text, .. } => {
                let formula = self.parse(text, section);
                constant(&formula.map_err(|found| fault(*found.problem))?)
            }
            _ => None,
        };
        value.filter(|value| value.is_finite()).ok_or_else(|| {
            let (found, expected) = (entry.value.words(), "a number, or a formula of numbers and parameters");
            fault(Problem::Value { found, expected: expected.to_string() })
        })
    }
}

/// The value of a formula that depends on nothing.
fn constant(formula: &Formula) -> Option<f64> {
    let mut values: Vec<f64> = Vec::with_capacity(formula.nodes.len());
    for node in &formula.nodes {
        values.push(match node {
            Node::Number(value) | Node::Named(value) => *value,
            Node::OfOne(operation, a) => operation.of(values[*a]),
            Node::OfTwo(operation, a, b) => operation.of(values[*a], values[*b]),
            Node::If([c, a, b]) => choice(values[*c], values[*a], values[*b]),
            _ => return None,
        });
    }
    values.last().copied()
}
