//! Networks of graph filters.

use motes_models::Seed;

use crate::arithmetic::{Activation, Arithmetic};
use crate::graph::{Graph, Shape};
use crate::hidden_reader::HiddenReader;
use crate::initial_weights::fan_in_bound;
use crate::parameters::Parameters;

/// A cascade of graph filters with tanh between them.
///
/// It is a view of consecutive matrices: for each layer the taps `W_0 … W_D` on top of each other and an offset for each feature.
#[derive(Clone)]
pub struct GraphNetwork {
    first: usize,
    shapes: Vec<Shape>,
}

impl GraphNetwork {
    /// Adds the weights of a network with the given features, inputs first and outputs last.
    pub fn draw(
        parameters: &mut Parameters,
        name: &str,
        features: &[usize],
        order: usize,
        seed: &Seed,
    ) -> Self {
        let shape = |pair: &[usize]| Shape { inputs: pair[0], outputs: pair[1], taps: order + 1 };
        let shapes: Vec<Shape> = features.windows(2).map(shape).collect();
        let first = parameters.len();
        for (layer, Shape { inputs, outputs, taps }) in shapes.iter().enumerate() {
            let bound = fan_in_bound(inputs * taps);
            parameters.draw(format!("{name}.{layer}.taps"), [taps * inputs, *outputs], bound, seed);
            parameters.draw(format!("{name}.{layer}.bias"), [1, *outputs], bound, seed);
        }
        GraphNetwork { first, shapes }
    }

    /// The matrix of the last layer's taps.
    pub fn last_matrix(&self) -> usize {
        self.first + 2 * self.shapes.len().saturating_sub(1)
    }

    /// The matrices that read hidden features, which all nodes share: all but the first.
    pub fn hidden_readers(&self) -> impl Iterator<Item = HiddenReader> {
        self.shapes.iter().enumerate().skip(1).map(|(layer, shape)| {
            let matrix = self.first + 2 * layer;
            HiddenReader { matrix, fed_by: matrix - 2, copies: shape.taps }
        })
    }

    /// Maps `(N·R)×F_0` inputs, node by node, to `(N·R)×F_L` outputs, with `last` applied to these.
    pub fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        graph: &Graph,
        inputs: A::Rows,
        last: Activation,
    ) -> A::Rows {
        self.shapes.iter().enumerate().fold(inputs, |values, (layer, shape)| {
            let activation = if layer + 1 == self.shapes.len() { last } else { Activation::Tanh };
            arithmetic.graph_filter(graph, &values, *shape, self.first + 2 * layer, activation)
        })
    }
}
