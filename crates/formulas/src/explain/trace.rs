//! Where a number that is none came from.

use super::domain_error::DomainError;
use super::evaluate::{Place, Point, arguments_of};
use crate::syntax::{Node, NodeId};

/// An operation that left its domain.
pub(super) struct Origin<'a> {
    place: Place<'a>,
    node: NodeId,
    /// Those of all nodes of the formula.
    values: Vec<f64>,
    /// For a distribution's parameter its name, and what would be right.
    parameter: Option<[String; 2]>,
}

impl<'a> Origin<'a> {
    /// A parameter that is out of range, with its name and what would be right.
    pub(super) fn of_parameter(
        place: Place<'a>,
        node: NodeId,
        values: &[f64],
        parameter: [String; 2],
    ) -> Self {
        Origin { place, node, values: values.to_vec(), parameter: Some(parameter) }
    }

    /// The error for the reader, who learns the file later.
    pub(super) fn error(self, point: &Point<'a>) -> DomainError {
        let Place { section, line, number } = self.place;
        let values = &self.values;
        let (mut nodes, mut looked_at) = (vec![self.node], 0);
        while let Some(node) = nodes.get(looked_at) {
            nodes.extend(line.formula.nodes[*node].operands());
            looked_at += 1;
        }
        nodes.sort_by_key(|node| line.formula.spans[*node].start);
        let mut at = Vec::new();
        for node in nodes {
            match point.named(self.place, node, values) {
                Some(named) if at.iter().all(|(name, _)| *name != named.0) => at.push(named),
                _ => {}
            }
        }
        DomainError {
            file: String::new(),
            line: Some(line.number),
            section: section.title(),
            key: line.coordinate(number),
            text: line.formula.text_of(self.node).to_string(),
            value: values[self.node],
            parameter: self.parameter,
            at,
        }
    }
}

/// Follows a number that is NaN, or infinite, to the operation that it came from.
pub(super) fn origin<'a>(place: Place<'a>, node: NodeId, values: &[f64], point: &Point<'a>) -> Origin<'a> {
    let (mut place, mut node, mut values) = (place, node, values.to_vec());
    // The calls that lead to where it is now.
    let mut calls: Vec<(Place<'a>, NodeId, Vec<f64>)> = Vec::new();
    loop {
        let value = values[node];
        let is_alike = |other: &NodeId| {
            let other = values[*other];
            if value.is_nan() { other.is_nan() } else { other.is_infinite() }
        };
        let current = &place.line.formula.nodes[node];
        if let Some(function) = point.function(current) {
            let called = point.values(&function.line.formula, 0, &arguments_of(current, &values));
            calls.push((place, node, values));
            (place, values, node) = (function, called, function.line.formula.root());
            continue;
        }
        if let Node::Argument(number) = current
            && let Some((caller, call, of_caller)) = calls.pop()
        {
            if let Node::Call { arguments, .. } = &caller.line.formula.nodes[call] {
                node = arguments[*number];
            }
            (place, values) = (caller, of_caller);
            continue;
        }
        if let Some(definition) = point.definition(current, &values) {
            place = definition;
            values = point.values(&place.line.formula, place.number, &[]);
            node = place.line.formula.root();
            continue;
        }
        let operands = match current {
            Node::OfOne(_, a) => [Some(*a), None],
            Node::OfTwo(_, a, b) => [Some(*a), Some(*b)],
            Node::If([condition, then, otherwise]) => {
                let chosen = if values[*condition] == 0.0 { otherwise } else { then };
                [Some(*condition), Some(*chosen)]
            }
            _ => [None, None],
        };
        match operands.into_iter().flatten().find(is_alike) {
            Some(operand) => node = operand,
            None => {
                let (at, parameter) = point.index_of_nothing(&place.line.formula, node, &values).unzip();
                return Origin { place, node: at.unwrap_or(node), values, parameter };
            }
        }
    }
}
