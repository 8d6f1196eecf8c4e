//! The distribution of a measurement at a state, with its numbers in place of its formulas.

use motes_models::Step;

use super::evaluate::Point;
use crate::model::FormulaModel;
use crate::operations::Binary;
use crate::syntax::{Formula, Node, NodeId};

impl FormulaModel {
    /// The distribution of an entry of the measurement at a state (`N`), to six digits: `rounded(normal(3.2, 0.5))` for `rounded(normal(rho*I, sd))`. None of an entry
    /// that the model does not have.
    pub fn distribution_at(&self, step: &Step<'_>, state: &[f64], entry: usize) -> Option<String> {
        let statement = self.statement();
        let entries =
            statement.measurement.iter().flat_map(|line| (0..line.coordinates()).map(move |at| (line, at)));
        let (line, number) = entries.into_iter().nth(entry)?;
        let point = Point::new(statement, step.end(self.0.inputs.len()), Some(state));
        let values = point.values(&line.formula, line.first + number, &[]);
        Some(written(&line.formula, &values, line.formula.root()))
    }
}

/// A node: a distribution by its name, all that is none by its value.
fn written(formula: &Formula, values: &[f64], node: NodeId) -> String {
    let each = |name: &str, arguments: &[NodeId]| {
        let arguments: Vec<String> =
            arguments.iter().map(|argument| written(formula, values, *argument)).collect();
        format!("{name}({})", arguments.join(", "))
    };
    match &formula.nodes[node] {
        Node::Random(family, arguments) => each(family.name, arguments),
        Node::Wrapped(wrapper, arguments) => each(wrapper.name, arguments),
        Node::Compound(compound, arguments) => each(compound.name, arguments),
        Node::OfTwo(operation, a, b) if formula.is_random[node] => {
            let sign = match operation {
                Binary::Add => "+",
                Binary::Subtract => "-",
                Binary::Multiply => "*",
                Binary::Divide => "/",
                _ => return formula.text_of(node).to_string(),
            };
            format!("{} {sign} {}", written(formula, values, *a), written(formula, values, *b))
        }
        // A formula of the measurement itself has no value yet.
        _ if formula.is_random[node] || values[node].is_nan() => formula.text_of(node).to_string(),
        _ => short(values[node]),
    }
}

/// A number to six digits.
fn short(value: f64) -> String {
    let rounded = format!("{value:.5e}").parse().unwrap_or(value);
    match rounded == 0.0 || !rounded.is_finite() || (1e-4..1e9).contains(&rounded.abs()) {
        true => rounded.to_string(),
        false => format!("{rounded:e}"),
    }
}
