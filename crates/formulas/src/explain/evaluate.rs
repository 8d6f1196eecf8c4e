//! The value of every operation of a formula at one point.

use motes_models::Step;
use motes_models::equations::Scalar;

use crate::error::Section;
use crate::operations::{Binary, choice, integer_exponent};
use crate::statement::{Line, Statement};
use crate::syntax::{Element, Formula, Node};

/// The formula of a coordinate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) section: Section,
    pub(super) line: &'a Line,
    /// Which coordinate of a vector.
    pub(super) number: usize,
}

/// What formulas depend on, and the values of the definitions there.
pub(super) struct Point<'a> {
    pub(super) statement: &'a Statement,
    pub(super) step: Step<'a>,
    states: Option<&'a [f64]>,
    definitions: Vec<Vec<f64>>,
    /// Of each definition, whether states are in it.
    has_states: Vec<bool>,
}

/// Which coordinate of a vector is meant.
fn number_of(element: Element, length: usize, values: &[f64]) -> usize {
    match element {
        Element::Whole => 0,
        Element::At(index) => (values[index] as i64).rem_euclid(length as i64) as usize,
    }
}

/// What a function is called with.
pub(super) fn arguments_of(call: &Node, values: &[f64]) -> Vec<f64> {
    match call {
        Node::Call { arguments, .. } => arguments.iter().map(|argument| values[*argument]).collect(),
        _ => Vec::new(),
    }
}

impl<'a> Point<'a> {
    /// `states` are those that the section's formulas are about, if there are any.
    pub(super) fn new(statement: &'a Statement, step: Step<'a>, states: Option<&'a [f64]>) -> Self {
        let definitions = vec![Vec::new(); statement.definitions.len()];
        let has_states = vec![false; statement.definitions.len()];
        let mut point = Point { statement, step, states, definitions, has_states };
        for &definition in &statement.order {
            let line = &statement.definitions[definition];
            point.has_states[definition] = line.formula.nodes.iter().any(|node| match node {
                Node::State { .. } => true,
                Node::Definition { number, .. } | Node::Call { number, .. } => point.has_states[*number],
                _ => false,
            });
            let value = |number| point.values(&line.formula, number, &[]).last().copied().unwrap_or(f64::NAN);
            // A function has a value where it is called.
            let coordinates = (0..line.coordinates()).filter(|_| line.arguments.is_empty());
            point.definitions[definition] = coordinates.map(value).collect();
        }
        point
    }

    /// A state's value; NaN where there is none.
    fn state(&self, number: usize) -> f64 {
        self.states.and_then(|states| states.get(number)).copied().unwrap_or(f64::NAN)
    }

    /// Of an entry that its list does not have, the index because of which it does not, what it is called, and what would be right.
    pub(super) fn index_of_nothing(
        &self,
        formula: &Formula,
        node: usize,
        values: &[f64],
    ) -> Option<(usize, [String; 2])> {
        let Node::Entry { list, indices } = &formula.nodes[node] else { return None };
        let list = self.statement.lists.get(*list)?;
        let is_none = |(index, length): &(&usize, &usize)| {
            let value = values[**index];
            value.fract() != 0.0 || !(0.0..**length as f64).contains(&value)
        };
        let (index, length) = indices.iter().zip(&list.lengths).find(is_none)?;
        let of = format!("an index of {}", formula.text_of(node));
        let words = [of, format!("an integer from 0 to {}", length - 1)];
        Some((*index, words))
    }

    /// The values of all nodes of a formula, as it is for a coordinate of a vector or for arguments of a function; NaN for what is random.
    pub(super) fn values(&self, formula: &Formula, number: usize, arguments: &[f64]) -> Vec<f64> {
        let mut values = Vec::with_capacity(formula.nodes.len());
        for (at, node) in formula.nodes.iter().enumerate() {
            let value = match node {
                _ if formula.is_random[at] => f64::NAN,
                Node::Number(value) | Node::Named(value) => *value,
                Node::Time => self.step.time,
                Node::Length => self.step.length,
                Node::Input(number) => self.step.inputs.get(*number).copied().unwrap_or(f64::NAN),
                Node::Coordinate => number as f64,
                Node::Argument(argument) => arguments[*argument],
                Node::Call { number, .. } => {
                    let formula = &self.statement.definitions[*number].formula;
                    let arguments = arguments_of(node, &values);
                    self.values(formula, 0, &arguments).last().copied().unwrap_or(f64::NAN)
                }
                Node::State { first, length, element } => {
                    self.state(first + number_of(*element, *length, &values))
                }
                Node::Definition { number, length, element } => {
                    self.definitions[*number][number_of(*element, *length, &values)]
                }
                Node::Entry { list, indices } => {
                    let indices: Vec<f64> = indices.iter().map(|index| values[*index]).collect();
                    self.statement.lists[*list].entry(&indices).unwrap_or(f64::NAN)
                }
                Node::OfOne(operation, a) => operation.of(values[*a]),
                Node::OfTwo(Binary::Power, a, b) => {
                    let (base, exponent): (f64, f64) = (values[*a], values[*b]);
                    let is_constant = matches!(formula.nodes[*b], Node::Number(_) | Node::Named(_));
                    match integer_exponent(exponent).filter(|_| is_constant) {
                        Some(exponent) => Scalar::powi(base, exponent),
                        None => base.pow(exponent),
                    }
                }
                Node::OfTwo(operation, a, b) => operation.of(values[*a], values[*b]),
                Node::If([condition, then, otherwise]) => {
                    choice(values[*condition], values[*then], values[*otherwise])
                }
                // What is measured is not known here.
                Node::Own | Node::Random(..) | Node::Compound(..) | Node::Wrapped(..) => f64::NAN,
            };
            values.push(value);
        }
        values
    }

    /// The function that a node calls.
    pub(super) fn function(&self, node: &Node) -> Option<Place<'a>> {
        match node {
            Node::Call { number, .. } => {
                let line = &self.statement.definitions[*number];
                Some(Place { section: Section::Definitions, line, number: 0 })
            }
            _ => None,
        }
    }

    /// The definition that a node names, and which of its coordinates.
    pub(super) fn definition(&self, node: &Node, values: &[f64]) -> Option<Place<'a>> {
        match node {
            Node::Definition { number, length, element } => Some(Place {
                section: Section::Definitions,
                line: &self.statement.definitions[*number],
                number: number_of(*element, *length, values),
            }),
            _ => None,
        }
    }

    /// The name and value of a node that is a name.
    pub(super) fn named(&self, place: Place<'a>, node: usize, values: &[f64]) -> Option<(String, f64)> {
        let formula = &place.line.formula;
        let name = match &formula.nodes[node] {
            Node::Named(_) if formula.text_of(node) == "pi" => return None,
            Node::Named(_)
            | Node::Time
            | Node::Length
            | Node::Input(_)
            | Node::Coordinate
            | Node::Argument(_) => formula.text_of(node).to_string(),
            Node::State { first, length, element } => {
                self.statement.name_of(first + number_of(*element, *length, values))
            }
            definition => {
                let place = self.definition(definition, values)?;
                place.line.coordinate(place.number)
            }
        };
        Some((name, values[node]))
    }

    /// For each node of a formula, whether its value is known here: draws are not, and neither are coordinates of `x_0`.
    pub(super) fn are_known(&self, section: Section, formula: &Formula) -> Vec<bool> {
        let states = self.states.map_or(0, <[f64]>::len);
        let mut known: Vec<bool> = Vec::with_capacity(formula.nodes.len());
        for node in &formula.nodes {
            let is_known = match node {
                Node::State { first, .. } => section != Section::Initial && *first < states,
                Node::Definition { number, .. } => section != Section::Initial || !self.has_states[*number],
                Node::Call { number, arguments } => {
                    (section != Section::Initial || !self.has_states[*number])
                        && arguments.iter().all(|argument| known[*argument])
                }
                Node::Own => false,
                Node::Entry { indices, .. } => indices.iter().all(|index| known[*index]),
                Node::OfOne(_, a) => known[*a],
                Node::OfTwo(_, a, b) => known[*a] && known[*b],
                Node::If(operands) => operands.iter().all(|operand| known[*operand]),
                _ => true,
            };
            known.push(is_known);
        }
        known
    }
}
