//! One step of networks as it is computed: every matrix of rows, with how it came about.

use super::buffers::Buffers;
use crate::arithmetic::Activation;
use crate::graph::{Graph, Shape};
use crate::parameters::Matrices;
use crate::values::Real;

/// The place of a matrix of rows among those of its step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct At(pub(super) usize);

/// A matrix of rows, with how it came about.
pub(super) struct Node<T> {
    pub(super) kind: Kind<T>,
    pub(super) rows: usize,
    pub(super) width: usize,
    /// `rows×width`.
    pub(super) values: Vec<T>,
}

/// How a matrix of rows came about.
pub(super) enum Kind<T> {
    /// It was given.
    Given,
    /// `x_{t−1}` beside a measurement.
    Stacked(At),
    Affine {
        inputs: [Option<(At, usize)>; 2],
        bias: Option<usize>,
        activation: Activation,
    },
    /// `c'`; the gates are kept after their activation.
    LstmCells {
        gates: At,
        cells: At,
    },
    /// `h'` from gates and `c'`; with `tanh c'`.
    LstmHidden {
        gates: At,
        cells: At,
        bounded: Vec<T>,
    },
    /// `h'`, with `r`, `s`, `ĥ` and `h X + d` side by side.
    Gru {
        from_input: At,
        from_hidden: At,
        offset: usize,
        hidden: At,
        parts: Vec<T>,
    },
    /// Inputs of a graph network, from `x_{t−1}`, a measurement and a learned adapter.
    AtNodes {
        previous: At,
        measurement: At,
        adapter: Option<usize>,
    },
    /// Inputs of a graph network, from blocks of states and of measurements.
    BlocksAtNodes {
        inputs: At,
        graph: Graph,
        blocks: [usize; 2],
    },
    Filter(GraphFilterOutput<T>),
    ByParticle(At),
}

/// One step of a batch, as far as it is computed.
pub(crate) struct Step<T> {
    pub(super) nodes: Vec<Node<T>>,
}

impl<T> Default for Step<T> {
    fn default() -> Self {
        Step { nodes: Vec::new() }
    }
}

impl<T: Real> Step<T> {
    pub(super) fn give(&mut self, rows: usize, width: usize, values: Vec<T>) -> At {
        self.push(Kind::Given, rows, width, values)
    }

    pub(super) fn push(&mut self, kind: Kind<T>, rows: usize, width: usize, values: Vec<T>) -> At {
        self.nodes.push(Node { kind, rows, width, values });
        At(self.nodes.len() - 1)
    }

    pub(super) fn values(&self, At(at): At) -> &[T] {
        &self.nodes[at].values
    }

    pub(super) fn size(&self, At(at): At) -> (usize, usize) {
        (self.nodes[at].rows, self.nodes[at].width)
    }

    /// Gives all memory back.
    pub(super) fn release(&mut self, buffers: &mut Buffers<T>) {
        for node in self.nodes.drain(..) {
            buffers.put(node.values);
            match node.kind {
                Kind::LstmHidden { bounded: kept, .. } | Kind::Gru { parts: kept, .. } => buffers.put(kept),
                Kind::Filter(filtered) => filtered.release(buffers),
                _ => {}
            }
        }
    }
}

/// Computes one step.
pub(crate) struct Native<'a, T> {
    pub(super) weights: Matrices<'a, T>,
    pub(super) step: &'a mut Step<T>,
    pub(super) buffers: &'a mut Buffers<T>,
}

/// A filter that was computed.
pub(super) struct GraphFilterOutput<T> {
    pub(super) graph: Graph,
    pub(super) input: At,
    pub(super) shape: Shape,
    pub(super) taps: usize,
    pub(super) activation: Activation,
    pub(super) kept: BackwardCache<T>,
}

/// What a way of computing a filter keeps for the way back.
pub(super) enum BackwardCache<T> {
    /// `[X, S X, …]`.
    Stacked(Vec<T>),
    Products,
    /// `Uᵀ X`.
    Spectral(Vec<T>),
}

impl<T: Real> GraphFilterOutput<T> {
    fn release(self, buffers: &mut Buffers<T>) {
        match self.kept {
            BackwardCache::Stacked(kept) | BackwardCache::Spectral(kept) => buffers.put(kept),
            BackwardCache::Products => {}
        }
    }
}
