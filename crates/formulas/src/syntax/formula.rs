//! A formula as a tree, in the order in which it is computed.

use std::ops::Range;

use crate::operations::{Binary, Unary};
use crate::tables::{Family, Wrapper};

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
    /// `i`.
    Coordinate,
    /// A state; beyond those a draw.
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
    /// A distribution of a measurement that is made of others, with its arguments.
    Wrapped(&'static Wrapper, Vec<NodeId>),
    /// The measurement itself, in its own log density.
    Own,
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

    /// The node that is its value.
    pub(crate) fn root(&self) -> NodeId {
        self.nodes.len().saturating_sub(1)
    }

    /// The numbers of the definitions that it uses.
    pub(crate) fn definitions(&self) -> impl Iterator<Item = usize> {
        self.nodes.iter().filter_map(|node| match node {
            Node::Definition { number, .. } => Some(*number),
            _ => None,
        })
    }
}
