//! Numbers that are written as formulas of constants.

use std::collections::BTreeMap;

use super::list::List;
use crate::document::{Entry, Found, Value};
use crate::error::{Fault, Problem, Section};
use crate::operations::choice;
use crate::syntax::{Formula, Meaning, Node, Scope, parse};

/// Reads formulas of numbers and parameters.
#[derive(Clone, Copy)]
pub(crate) struct Constants<'a> {
    /// The parameters.
    pub(crate) names: &'a BTreeMap<String, Meaning>,
    /// Those that are lists.
    pub(crate) lists: &'a [List],
}

impl Constants<'_> {
    /// The formula of a text.
    pub(super) fn parse(&self, text: &str, section: Section) -> Result<Formula, Fault> {
        parse(
            text,
            Scope {
                names: self.names,
                own: "",
                section,
                is_vector: false,
                is_of_several: false,
                totals: None,
                arguments: &[],
            },
        )
    }

    /// The number of an entry: one, or a formula of constants in quotes.
    pub(super) fn value(&self, entry: &Entry, section: Section) -> Result<f64, Fault> {
        self.number(&entry.value, section).map_err(|fault| fault.in_section(section).of_key(&entry.key))
    }

    /// The number of a value: one, or a formula of constants in quotes.
    pub(crate) fn number(&self, value: &Value, section: Section) -> Result<f64, Fault> {
        let fault = |problem| Fault::at(value.at, problem);
        let number = match &value.found {
            Found::Number(number, _) => Some(*number),
            Found::Text { text, .. } => {
                let formula = self.parse(text, section);
                self.constant(&formula.map_err(|found| fault(*found.problem))?)
            }
            _ => None,
        };
        number.filter(|number| number.is_finite()).ok_or_else(|| {
            let (found, expected) = match (number, &value.found) {
                (Some(number), Found::Text { .. }) => {
                    (format!("{}, which is {number}", value.words()), "finite")
                }
                _ => (value.words(), "a number, or a formula of numbers and parameters"),
            };
            fault(Problem::Value { found, expected: expected.to_string() })
        })
    }

    /// The value of a formula that depends on nothing.
    fn constant(&self, formula: &Formula) -> Option<f64> {
        let mut values: Vec<f64> = Vec::with_capacity(formula.nodes.len());
        for node in &formula.nodes {
            values.push(match node {
                Node::Number(value) | Node::Named(value) => *value,
                Node::OfOne(operation, a) => operation.of(values[*a]),
                Node::OfTwo(operation, a, b) => operation.of(values[*a], values[*b]),
                Node::If([c, a, b]) => choice(values[*c], values[*a], values[*b]),
                Node::Entry { list, indices } => {
                    let indices: Vec<f64> = indices.iter().map(|index| values[*index]).collect();
                    self.lists[*list].entry(&indices)?
                }
                _ => return None,
            });
        }
        values.last().copied()
    }
}
