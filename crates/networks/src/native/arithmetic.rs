//! The operations of networks, each computed by whole layers.

use super::products::Multiply;
use super::step::{At, Kind, Native};
use super::{affine, cells, graph};
use crate::arithmetic::{Activation, Arithmetic};
use crate::graph::{Graph, Shape};

impl<T: Multiply> Arithmetic for Native<'_, T> {
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

    fn blocks_at_nodes(&mut self, inputs: &At, graph: &Graph, states: usize, measurements: usize) -> At {
        graph::blocks_at_nodes(self, *inputs, graph, [states, measurements])
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
        let (rows, features) = self.step.size(*values);
        let particles = rows / nodes;
        let mut by_particle = self.buffers.take(rows * features);
        graph::regroup(self.step.values(*values), [nodes, particles, features], &mut by_particle);
        self.step.push(Kind::ByParticle(*values), particles, nodes * features, by_particle)
    }
}
