//! A fully connected network: a cascade of affine maps, tanh between them, none after the last.

use motes_models::Seed;

use crate::arithmetic::{Activation, Arithmetic};
use crate::hidden_reader::HiddenReader;
use crate::initial_weights::fan_in_bound;
use crate::parameters::Parameters;

/// `z_ℓ = tanh(z_{ℓ−1} W_ℓ + b_ℓ)`, the last layer without tanh (the paper's equation "meanNN", with samples as rows).
///
/// It is a view of consecutive matrices in some [`Parameters`], `W_1, b_1, W_2, b_2, …`, so that several networks can
/// live in one set of weights.
#[derive(Debug, Clone, Copy)]
pub struct Mlp {
    first: usize,
    layers: usize,
}

impl Mlp {
    /// Adds the weights of a network with the given widths, inputs first and outputs last, uniform on `±1/√fan_in`.
    pub fn draw(parameters: &mut Parameters, name: &str, widths: &[usize], seed: &Seed) -> Self {
        let mlp = Mlp { first: parameters.len(), layers: widths.len() - 1 };
        for (layer, pair) in widths.windows(2).enumerate() {
            let bound = fan_in_bound(pair[0]);
            parameters.draw(format!("{name}.{layer}.weight"), [pair[0], pair[1]], bound, seed);
            parameters.draw(format!("{name}.{layer}.bias"), [1, pair[1]], bound, seed);
        }
        mlp
    }

    /// The matrix that reads the inputs.
    pub fn first_matrix(self) -> usize {
        self.first
    }

    /// The matrices that read hidden units: all but the first.
    pub fn hidden_readers(self) -> impl Iterator<Item = HiddenReader> {
        (1..self.layers).map(move |layer| {
            let matrix = self.first + 2 * layer;
            HiddenReader::plain(matrix, matrix - 2)
        })
    }

    /// Maps `R` rows of inputs to `R` rows of outputs.
    pub fn forward<A: Arithmetic>(self, arithmetic: &mut A, input: A::Rows) -> A::Rows {
        (0..self.layers).fold(input, |values, layer| {
            let at = self.first + 2 * layer;
            let last = layer + 1 == self.layers;
            let activation = if last { Activation::Linear } else { Activation::Tanh };
            arithmetic.affine(&[(&values, at)], Some(at + 1), activation)
        })
    }
}
