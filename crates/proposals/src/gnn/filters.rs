//! Graph filters and networks of them.

use burn::tensor::Tensor;
use motes_models::Seed;

use crate::affine::Weights;
use crate::initial_weights::fan_in_bound;
use crate::parameters::Parameters;

/// `S`, applied to rows that are node by node.
#[derive(Clone)]
pub(super) struct Shift {
    matrix: Tensor<2>,
}

impl Shift {
    pub(super) fn new(matrix: Tensor<2>) -> Self {
        Shift { matrix }
    }

    /// `S X` for each particle: `rows` is `(N·R)×F`, node by node, so all particles are one product.
    fn apply(&self, rows: Tensor<2>) -> Tensor<2> {
        let [count, features] = rows.dims();
        let nodes = self.matrix.dims()[0];
        let wide = rows.reshape([nodes, count / nodes * features]);
        self.matrix.clone().matmul(wide).reshape([count, features])
    }
}

/// A cascade of graph filters with tanh between them, none after the last.
///
/// It is a view of consecutive matrices: for each layer the taps `W_0 … W_D` on top of each other and an offset for each feature.
#[derive(Clone, Copy)]
pub(super) struct GraphNetwork {
    first: usize,
    layers: usize,
    taps: usize,
}

impl GraphNetwork {
    /// Adds the weights of a network with the given features, inputs first and outputs last.
    pub(super) fn draw(
        parameters: &mut Parameters,
        name: &str,
        features: &[usize],
        order: usize,
        seed: &Seed,
    ) -> Self {
        let taps = order + 1;
        let network = GraphNetwork { first: parameters.len(), layers: features.len() - 1, taps };
        for (layer, pair) in features.windows(2).enumerate() {
            let bound = fan_in_bound(pair[0] * taps);
            parameters.draw(format!("{name}.{layer}.taps"), [taps * pair[0], pair[1]], bound, seed);
            parameters.draw(format!("{name}.{layer}.bias"), [1, pair[1]], bound, seed);
        }
        network
    }

    /// Maps `(N·R)×F_0` inputs, node by node, to `(N·R)×F_L` outputs.
    pub(super) fn forward(self, weights: &mut Weights<'_>, shift: &Shift, inputs: Tensor<2>) -> Tensor<2> {
        (0..self.layers).fold(inputs, |values, layer| {
            let affine = self.filter(weights, layer, shift, values);
            if layer + 1 == self.layers { affine } else { affine.tanh() }
        })
    }

    /// `Σ_d S^d X W_d + 1 bᵀ`, shifting whichever of `X` and `X W_d` has fewer features.
    fn filter(self, weights: &mut Weights<'_>, layer: usize, shift: &Shift, values: Tensor<2>) -> Tensor<2> {
        let at = self.first + 2 * layer;
        let [rows, fan_out] = weights.dims(at);
        let fan_in = rows / self.taps;
        if fan_in <= fan_out {
            // [X, S X, S² X, …] in one product with all taps.
            let mut shifted = vec![values];
            while shifted.len() < self.taps {
                shifted.push(shift.apply(shifted[shifted.len() - 1].clone()));
            }
            return weights.affine(Tensor::cat(shifted, 1), at, Some(at + 1));
        }
        // X W_0 + S (X W_1 + S (X W_2 + …)), from the inside.
        let taps = weights.matrix(at);
        let tap = |d: usize| taps.clone().narrow(0, d * fan_in, fan_in);
        let products = values.matmul(Tensor::cat((0..self.taps).map(tap).collect(), 1));
        let product = |d: usize| products.clone().narrow(1, d * fan_out, fan_out);
        let sum =
            (0..self.taps - 1).rev().fold(product(self.taps - 1), |sum, d| product(d) + shift.apply(sum));
        sum + weights.matrix(at + 1)
    }
}
