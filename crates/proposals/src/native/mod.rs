//! Networks computed here, on the host, by whole layers: the backend that experiments use.
//!
//! Products of a batch of particles with weights are our own, others faer's. Around them are layers fused with their activations,
//! derivatives taken from outputs, gradients of shared weights formed once from many times, memory that is used again.

mod across;
mod affine;
mod alike;
mod buffers;
mod by_faer;
mod cells;
mod graph;
mod infer;
mod large;
mod outer;
mod panels;
mod products;
mod shared;
mod skinny;
mod tape;
mod vectors;
mod waiting;

pub(crate) use infer::{Inference, infer};
pub(crate) use products::Products;
pub(crate) use tape::NativeTape;
pub(crate) use waiting::Waiting;

use crate::arithmetic::{Activation, Arithmetic};
use crate::gnn::{Graph, Shape};
use crate::parameters::Matrices;
use crate::values::Real;
pub(crate) use buffers::Buffers;

/// The place of a matrix of rows among those of its step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct At(usize);

/// A matrix of rows, with how it came about.
struct Node<T> {
    kind: Kind<T>,
    rows: usize,
    width: usize,
    /// `rows×width`.
    values: Vec<T>,
}

/// How a matrix of rows came about.
enum Kind<T> {
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
    Filter(graph::Filtered<T>),
    ByParticle(At),
}

/// One step of a batch, as far as it is computed.
pub(crate) struct Step<T> {
    nodes: Vec<Node<T>>,
}

impl<T> Default for Step<T> {
    fn default() -> Self {
        Step { nodes: Vec::new() }
    }
}

impl<T: Real> Step<T> {
    fn give(&mut self, rows: usize, width: usize, values: Vec<T>) -> At {
        self.push(Kind::Given, rows, width, values)
    }

    fn push(&mut self, kind: Kind<T>, rows: usize, width: usize, values: Vec<T>) -> At {
        self.nodes.push(Node { kind, rows, width, values });
        At(self.nodes.len() - 1)
    }

    fn values(&self, At(at): At) -> &[T] {
        &self.nodes[at].values
    }

    fn size(&self, At(at): At) -> (usize, usize) {
        (self.nodes[at].rows, self.nodes[at].width)
    }

    /// Gives all memory back.
    fn release(&mut self, buffers: &mut Buffers<T>) {
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
    weights: Matrices<'a, T>,
    step: &'a mut Step<T>,
    buffers: &'a mut Buffers<T>,
}

impl<T: Real> Arithmetic for Native<'_, T> {
    type Rows = At;

    fn stacked(&mut self, previous: &At, measurement: &At) -> At {
        let (rows, n) = self.step.size(*previous);
        let m = self.step.size(*measurement).1;
        let mut values = self.buffers.take(rows * (n + m));
        let previous_rows = self.step.values(*previous).chunks_exact(n);
        for (row, previous) in values.chunks_exact_mut(n + m).zip(previous_rows) {
            row[..n].copy_from_slice(previous);
            row[n..].copy_from_slice(self.step.values(*measurement));
        }
        self.step.push(Kind::Stacked(*previous), rows, n + m, values)
    }

    fn affine(&mut self, inputs: &[(&At, usize)], bias: Option<usize>, activation: Activation) -> At {
        let mut terms = [None; 2];
        terms.iter_mut().zip(inputs).for_each(|(term, (at, weight))| *term = Some((**at, *weight)));
        affine::forward(self, terms, bias, activation)
    }

    fn lstm(&mut self, gates: At, cells: &At) -> (At, At) {
        cells::lstm(self.step, self.buffers, gates, *cells)
    }

    fn gru(&mut self, from_input: &At, from_hidden: &At, offset: usize, hidden: &At) -> At {
        cells::gru(self, *from_input, *from_hidden, offset, *hidden)
    }

    fn at_nodes(&mut self, previous: &At, measurement: &At, graph: &Graph, adapter: Option<usize>) -> At {
        graph::at_nodes(self, *previous, *measurement, graph, adapter)
    }

    fn graph_filter(
        &mut self,
        graph: &Graph,
        values: &At,
        shape: Shape,
        taps: usize,
        activation: Activation,
    ) -> At {
        graph::filter(self, graph, *values, shape, taps, activation)
    }

    fn by_particle(&mut self, values: &At, nodes: usize) -> At {
        let particles = self.step.size(*values).0 / nodes;
        let mut rows = self.buffers.take(particles * nodes);
        products::transpose(self.step.values(*values), nodes, particles, &mut rows);
        self.step.push(Kind::ByParticle(*values), particles, nodes, rows)
    }
}
