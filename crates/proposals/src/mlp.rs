//! A fully connected network: a cascade of affine maps, tanh between them, none after the last.

use burn::tensor::Tensor;
use motes_models::Seed;

use crate::affine::Weights;
use crate::initial_weights::fan_in_bound;
use crate::parameters::Parameters;

/// `z_ℓ = tanh(z_{ℓ−1} W_ℓ + b_ℓ)`, the last layer without tanh (the paper's equation "meanNN", with samples as rows).
///
/// It is a view of consecutive matrices in some [`Parameters`], `W_1, b_1, W_2, b_2, …`, so that several networks can
/// live in one set of weights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mlp {
    first: usize,
    layers: usize,
}

impl Mlp {
    /// Adds the weights of a network with the given widths, inputs first and outputs last, uniform on `±1/√fan_in`.
    pub(crate) fn draw(parameters: &mut Parameters, name: &str, widths: &[usize], seed: &Seed) -> Self {
        let mlp = Mlp { first: parameters.len(), layers: widths.len() - 1 };
        for (layer, pair) in widths.windows(2).enumerate() {
            let bound = fan_in_bound(pair[0]);
            parameters.draw(format!("{name}.{layer}.weight"), [pair[0], pair[1]], bound, seed);
            parameters.draw(format!("{name}.{layer}.bias"), [1, pair[1]], bound, seed);
        }
        mlp
    }

    /// Maps `R` rows of inputs to `R` rows of outputs with the given `weights`, those of the whole proposal.
    pub(crate) fn forward(self, weights: &mut Weights<'_>, input: Tensor<2>) -> Tensor<2> {
        (0..self.layers).fold(input, |values, layer| {
            let at = self.first + 2 * layer;
            let affine = weights.affine(values, at, Some(at + 1));
            if layer + 1 == self.layers { affine } else { affine.tanh() }
        })
    }
}
