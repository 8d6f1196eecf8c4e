//! One recurrent layer: Elman, GRU or LSTM.

use burn::tensor::Tensor;
use motes_models::Seed;
use serde::{Deserialize, Serialize};

use crate::affine::Weights;
use crate::initial_weights::fan_in_bound;
use crate::parameters::Parameters;

/// What a recurrent layer computes from its input `u` and its hidden state `h`; `σ` is the logistic function, `∘` the
/// elementwise product, and samples are rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cell {
    /// `h' = tanh(u W + h U + b)`: the paper's equation "hiddenRNN".
    Elman,
    /// `r, s = σ(u W + h U + b)` (a half each), `ĥ = tanh(u V + v + r ∘ (h X + d))`, `h' = (1 − s) ∘ ĥ + s ∘ h` (Cho et al. 2014,
    /// with the reset gate after the product). `V`, `X` and `v` are the third blocks of columns beside `W`, `U` and `b`.
    Gru,
    /// `i, f, g, o = u W + h U + b` (a quarter each), `c' = σ(f) ∘ c + σ(i) ∘ tanh(g)`, `h' = σ(o) ∘ tanh(c')`
    /// (Hochreiter and Schmidhuber 1997, Gers et al. 2000); a particle carries `h` and `c`.
    Lstm,
}

impl Cell {
    /// How many blocks of `H` columns the products have.
    fn blocks(self) -> usize {
        match self {
            Cell::Elman => 1,
            Cell::Gru => 3,
            Cell::Lstm => 4,
        }
    }

    /// How many numbers the weights of a layer are.
    pub(super) fn count(self, [inputs, hidden]: [usize; 2]) -> Option<usize> {
        let rows = inputs.checked_add(hidden)?.checked_add(1)?;
        let extra = if self == Cell::Gru { hidden } else { 0 };
        rows.checked_mul(hidden)?.checked_mul(self.blocks())?.checked_add(extra)
    }
}

/// A view of one layer's matrices: of the input, of the hidden state, the offset, and for a GRU the offset `d` inside its
/// candidate. Its blocks are in the order of [`Cell`]'s equations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layer {
    cell: Cell,
    hidden: usize,
    first: usize,
}

impl Layer {
    /// Adds the weights of a layer, uniform on `±1/√H`.
    pub(super) fn draw(
        parameters: &mut Parameters,
        name: &str,
        cell: Cell,
        [inputs, hidden]: [usize; 2],
        seed: &Seed,
    ) -> Self {
        let (first, bound, columns) = (parameters.len(), fan_in_bound(hidden), cell.blocks() * hidden);
        parameters.draw(format!("{name}.input"), [inputs, columns], bound, seed);
        parameters.draw(format!("{name}.hidden"), [hidden, columns], bound, seed);
        parameters.draw(format!("{name}.bias"), [1, columns], bound, seed);
        if cell == Cell::Gru {
            parameters.draw(format!("{name}.candidate_bias"), [1, hidden], bound, seed);
        }
        Layer { cell, hidden, first }
    }

    /// The widths of what a particle carries for this layer; the first is that of `h`.
    pub(super) fn carried_widths(self) -> Vec<usize> {
        vec![self.hidden; if self.cell == Cell::Lstm { 2 } else { 1 }]
    }

    /// Advances the layer; the first tensor that comes back is `h'`, which is also its output.
    pub(super) fn forward(
        self,
        weights: &mut Weights<'_>,
        input: Tensor<2>,
        carried: &[Tensor<2>],
    ) -> Vec<Tensor<2>> {
        let h = carried[0].clone();
        let from_input = weights.affine(input, self.first, Some(self.first + 2));
        let from_hidden = weights.affine(h.clone(), self.first + 1, None);
        let block = |tensor: &Tensor<2>, first: usize, blocks: usize| {
            tensor.clone().narrow(1, first * self.hidden, blocks * self.hidden)
        };
        match self.cell {
            Cell::Elman => vec![(from_input + from_hidden).tanh()],
            Cell::Gru => {
                let gates = sigmoid(block(&from_input, 0, 2) + block(&from_hidden, 0, 2));
                let (reset, keep) = (block(&gates, 0, 1), block(&gates, 1, 1));
                let inner = block(&from_hidden, 2, 1) + weights.matrix(self.first + 3);
                let candidate = (block(&from_input, 2, 1) + reset * inner).tanh();
                // (1 − s) ∘ ĥ + s ∘ h
                vec![candidate.clone() + keep * (h - candidate)]
            }
            Cell::Lstm => {
                let gates = from_input + from_hidden;
                let (input, forget) = (sigmoid(block(&gates, 0, 1)), sigmoid(block(&gates, 1, 1)));
                let (new, output) = (block(&gates, 2, 1).tanh(), sigmoid(block(&gates, 3, 1)));
                let c = forget * carried[1].clone() + input * new;
                vec![output * c.clone().tanh(), c]
            }
        }
    }
}

/// `σ(a) = (1 + tanh(a/2)) / 2`, which backends compute alike where their own logistic functions differ.
fn sigmoid(values: Tensor<2>) -> Tensor<2> {
    (values * 0.5).tanh() * 0.5 + 0.5
}
