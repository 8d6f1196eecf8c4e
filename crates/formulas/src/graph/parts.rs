//! The distributions of a formula, as its nodes are computed: families, what shifts and scales them, and what is made of them.

use std::collections::HashMap;

use super::coordinate::{Coordinate, Made, Part};
use super::nodes::{Graph, Id};
use crate::error::Problem;
use crate::operations::{Binary, Unary};
use crate::syntax::{Node, NodeId};
use crate::tables::{Argument, EXACT, Kind, Range, Wrapper, Wrapping, call};

/// Where something is wrong, and what.
type Wrong = (NodeId, Problem);

/// The distributions that nothing is made of yet, each at the node that is its value, with the node that it began with.
pub(super) struct Parts {
    open: HashMap<NodeId, (Part, NodeId)>,
    /// Whether a normal one may have a standard deviation of 0.
    may_be_exact: bool,
}

impl Parts {
    pub(super) fn of(may_be_exact: bool) -> Self {
        Parts { open: HashMap::new(), may_be_exact }
    }

    /// Adds a node `at` its place; `values` are the numbers of the nodes before.
    pub(super) fn add(
        &mut self,
        graph: &mut Graph,
        node: &Node,
        at: NodeId,
        is_random: &[bool],
        values: &[Id],
    ) -> Result<(), Wrong> {
        match node {
            Node::Random(family, parameters) => {
                let parameters = parameters.iter().map(|parameter| values[*parameter]).collect();
                self.open.insert(at, (Part::Plain(Coordinate::new(family, parameters)), at));
            }
            Node::Wrapped(wrapper, arguments) => {
                let made = self.made(graph, wrapper, arguments, values)?;
                check_made(graph, &made).map_or(Ok(()), |problem| Err((at, problem)))?;
                self.open.insert(at, (Part::Made(made), at));
            }
            Node::OfOne(Unary::Negative, a) => self.change(*a, at, |random| random.negate(graph)),
            Node::OfTwo(operation, a, b) => {
                let (operand, by) = if is_random[*a] { (*a, values[*b]) } else { (*b, values[*a]) };
                self.change(operand, at, |random| match (operation, is_random[*a]) {
                    (Binary::Add, _) => random.add(graph, by),
                    (Binary::Subtract, true) => random.subtract(graph, by),
                    (Binary::Subtract, false) => {
                        random.negate(graph);
                        random.add(graph, by);
                    }
                    (Binary::Multiply, _) => random.multiply(graph, by),
                    (Binary::Divide, _) => random.divide(graph, by),
                    // The parser refuses the others.
                    _ => {}
                });
            }
            _ => {}
        }
        Ok(())
    }

    /// The distribution of a formula, whose value is this node.
    pub(super) fn finish(mut self, graph: &mut Graph, root: NodeId) -> Result<Option<Part>, Wrong> {
        if self.open.contains_key(&root) { self.take(graph, root).map(Some) } else { Ok(None) }
    }

    /// Shifts or scales what is the value of a node, which becomes that of another.
    fn change(&mut self, from: NodeId, to: NodeId, change: impl FnOnce(&mut Coordinate)) {
        if let Some((mut part, began)) = self.open.remove(&from) {
            if let Part::Plain(coordinate) = &mut part {
                change(coordinate);
            }
            self.open.insert(to, (part, began));
        }
    }

    /// What is the value of a node, when nothing shifts or scales it any more.
    fn take(&mut self, graph: &mut Graph, at: NodeId) -> Result<Part, Wrong> {
        // The parser says which nodes are random.
        let (mut part, began) = self.open.remove(&at).ok_or((at, Problem::Empty))?;
        if let Part::Plain(coordinate) = &mut part {
            let is_exact = self.may_be_exact
                && coordinate.family.kind == Kind::Normal
                && graph.value(coordinate.parameters[1]) == Some(0.0);
            if is_exact {
                coordinate.family = &EXACT;
            }
            check(graph, coordinate).map_or(Ok(()), |problem| Err((began, problem)))?;
            coordinate.settle(graph);
        }
        Ok(part)
    }

    fn made(
        &mut self,
        graph: &mut Graph,
        wrapper: &'static Wrapper,
        arguments: &[NodeId],
        values: &[Id],
    ) -> Result<Made, Wrong> {
        let mut made = Made { wrapper, numbers: Vec::new(), parts: Vec::new(), density: None };
        for (argument, kind) in arguments.iter().zip(wrapper.arguments) {
            match kind {
                Argument::Number(_) | Argument::End => made.numbers.push(values[*argument]),
                Argument::Distribution => made.parts.push(self.take(graph, *argument)?),
                Argument::Formula => made.density = Some(values[*argument]),
            }
        }
        Ok(made)
    }
}

/// What is wrong with a distribution, whatever the states are.
fn check(graph: &Graph, coordinate: &Coordinate) -> Option<Problem> {
    let family = coordinate.family;
    let call = call(family.name, family.parameters);
    let out_of_range = |parameter: &str, value, expected: String| {
        Some(Problem::OutOfRange { what: format!("the {parameter} of {call}"), value, expected })
    };
    let values: Vec<Option<f64>> = coordinate.parameters.iter().map(|id| graph.value(*id)).collect();
    for ((value, range), name) in values.iter().zip(family.ranges).zip(family.parameters) {
        if let Some(value) = value.filter(|value| !range.has(*value)) {
            return out_of_range(name, value, range.words().to_string());
        }
    }
    match (family.kind, values.as_slice()) {
        (Kind::Uniform, [Some(low), Some(high)]) if low >= high => {
            out_of_range("high", *high, format!("above low, which is {low}"))
        }
        _ => match coordinate.scale.and_then(|scale| graph.value(scale)) {
            Some(0.0) => Some(Problem::NoNoiseLeft(call)),
            Some(scale) if !Range::Any.has(scale) => {
                out_of_range("factor", scale, Range::Any.words().to_string())
            }
            _ => None,
        },
    }
}

/// What is wrong with a distribution that is made of others, whatever the states are.
fn check_made(graph: &Graph, made: &Made) -> Option<Problem> {
    let wrapper = made.wrapper;
    let out_of_range = |parameter: &str, value, expected: String| Problem::OutOfRange {
        what: format!("the {parameter} of {}", call(wrapper.name, wrapper.parameters)),
        value,
        expected,
    };
    let is_number = |argument: &Argument| matches!(argument, Argument::Number(_) | Argument::End);
    let arguments =
        wrapper.arguments.iter().zip(wrapper.parameters).filter(|(argument, _)| is_number(argument));
    let mut values = made.numbers.iter().map(|id| graph.value(*id)).zip(arguments);
    let wrong = values.find_map(|(value, (argument, name))| {
        let value = value.filter(|value| !argument.has(*value))?;
        Some(out_of_range(name, value, argument.words().to_string()))
    });
    let in_order = || match (wrapper.wrapping, made.numbers.as_slice()) {
        (Wrapping::Censored | Wrapping::Truncated, [low, high]) => {
            let (low, high) = (graph.value(*low)?, graph.value(*high)?);
            (low >= high).then(|| out_of_range("high", high, format!("above low, which is {low}")))
        }
        _ => None,
    };
    wrong.or_else(in_order)
}
