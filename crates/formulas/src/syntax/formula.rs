//! A formula as a tree, in the order in which it is computed.

use std::ops::Range;

use crate::operations::{Binary, Unary};
use crate::tables::{Compound, Family, Wrapper};

/// A node by its number.
pub(crate) type NodeId = usize;

/// A coordinate: the only one, or one of a vector by an index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Element {
    /// What is no vector.
    Whole,
    /// The value of a node, modulo the length of the vector.
    At(NodeId),
}

/// An operation or operand.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    Number(f64),
    /// A number by name: a parameter, or pi.
    Named(f64),
    /// `t`.
    Time,
    /// `dt`.
    Length,
    /// An input.
    Input(usize),
    /// `i`.
    Coordinate,
    /// A state; beyond those a sum over sub-steps, and then a draw.
    State {
        first: usize,
        length: usize,
        element: Element,
    },
    Definition {
        number: usize,
        length: usize,
        element: Element,
    },
    /// An argument of the function whose formula it is.
    Argument(usize),
    /// A function of the file, by its number among the definitions.
    Call {
        number: usize,
        arguments: Vec<NodeId>,
    },
    /// An entry of a list, by its indices.
    Entry {
        list: usize,
        indices: Vec<NodeId>,
    },
    OfOne(Unary, NodeId),
    OfTwo(Binary, NodeId, NodeId),
    /// The second where the first is not 0, else the third.
    If([NodeId; 3]),
    /// A distribution: the only one, but for those in others.
    Random(&'static Family, Vec<NodeId>),
    /// The formula itself, where it is a distribution that is made of others.
    Compound(&'static Compound, Vec<NodeId>),
    /// A distribution of a measurement that is made of others, with its arguments.
    Wrapped(&'static Wrapper, Vec<NodeId>),
    /// The measurement itself, in its own log density.
    Own,
}

impl Node {
    /// The nodes that it is made of.
    pub(crate) fn operands(&self) -> Vec<NodeId> {
        match self {
            Node::Number(_)
            | Node::Named(_)
            | Node::Time
            | Node::Length
            | Node::Input(_)
            | Node::Coordinate
            | Node::Own
            | Node::Argument(_) => Vec::new(),
            Node::State { element, .. } | Node::Definition { element, .. } => match element {
                Element::Whole => Vec::new(),
                Element::At(index) => vec![*index],
            },
            Node::OfOne(_, a) => vec![*a],
            Node::OfTwo(_, a, b) => vec![*a, *b],
            Node::If(operands) => operands.to_vec(),
            Node::Call { arguments, .. }
            | Node::Entry { indices: arguments, .. }
            | Node::Random(_, arguments)
            | Node::Wrapped(_, arguments)
            | Node::Compound(_, arguments) => arguments.clone(),
        }
    }
}

/// A formula. Its operands come before the operations on them; the last node is its value.
#[derive(Debug, Clone)]
pub(crate) struct Formula {
    pub(crate) text: String,
    pub(crate) nodes: Vec<Node>,
    /// For each node, where it stands in the text.
    pub(crate) spans: Vec<Range<usize>>,
    /// For each node, whether the distribution is in it.
    pub(crate) is_random: Vec<bool>,
}

impl Formula {
    /// The text of a node.
    pub(crate) fn text_of(&self, node: NodeId) -> &str {
        self.spans.get(node).and_then(|span| self.text.get(span.clone())).unwrap_or(&self.text)
    }

    /// Whether it has a distribution.
    pub(crate) fn has_noise(&self) -> bool {
        self.is_random.last() == Some(&true)
    }

    /// Whether its distribution has several parts.
    pub(crate) fn has_parts(&self) -> bool {
        matches!(self.nodes.last(), Some(Node::Compound(compound, _)) if compound.parts.is_some())
    }

    /// The node that is its value.
    pub(crate) fn root(&self) -> NodeId {
        self.nodes.len().saturating_sub(1)
    }

    /// The numbers of the definitions and functions that it uses.
    pub(crate) fn definitions(&self) -> impl Iterator<Item = usize> {
        self.nodes.iter().filter_map(|node| match node {
            Node::Definition { number, .. } | Node::Call { number, .. } => Some(*number),
            _ => None,
        })
    }
}
