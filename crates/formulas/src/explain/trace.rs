//! Where a number that is none came from.

use super::domain_error::DomainError;
use super::evaluate::{Place, Point};
use crate::syntax::{Node, NodeId};

/// An operation that left its domain.
pub(super) struct Origin<'a> {
    place: Place<'a>,
    node: NodeId,
    value: f64,
    /// For a distribution's parameter its name, and what would be right.
    parameter: Option<[String; 2]>,
}

impl<'a> Origin<'a> {
    /// A parameter that is out of range, with its name and what would be right.
    pub(super) fn of_parameter(place: Place<'a>, node: NodeId, value: f64, parameter: [String; 2]) -> Self {
        Origin { place, node, value, parameter: Some(parameter) }
    }

    /// The error for the reader, who learns the file later.
    pub(super) fn error(self, point: &Point<'a>) -> DomainError {
        let Place { section, line, number } = self.place;
        let values = point.values(&line.formula, line.first + number);
        let span = &line.formula.spans[self.node];
        let inside = |node: &NodeId| {
            let at = &line.formula.spans[*node];
            at.start >= span.start && at.end <= span.end
        };
        let mut nodes: Vec<NodeId> = (0..line.formula.nodes.len()).filter(inside).collect();
        nodes.sort_by_key(|node| line.formula.spans[*node].start);
        let mut at = Vec::new();
        for node in nodes {
            match point.named(self.place, node, &values) {
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
            value: self.value,
            parameter: self.parameter,
            at,
        }
    }
}

/// Follows a number that is NaN, or infinite, to the operation that it came from.
pub(super) fn origin<'a>(place: Place<'a>, node: NodeId, values: &[f64], point: &Point<'a>) -> Origin<'a> {
    let (mut place, mut node, mut values) = (place, node, values.to_vec());
    loop {
        let value = values[node];
        let is_alike = |other: &NodeId| {
            let other = values[*other];
            if value.is_nan() { other.is_nan() } else { other.is_infinite() }
        };
        let current = &place.line.formula.nodes[node];
        if let Some(definition) = point.definition(current, &values) {
            place = definition;
            values = point.values(&place.line.formula, place.number);
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
            None => return Origin { place, node, value, parameter: None },
        }
    }
}
