//! One recurrent layer: Elman, GRU or LSTM.

use motes_models::Seed;
use serde::{Deserialize, Serialize};

use crate::arithmetic::{Activation, Arithmetic};
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
    pub fn count(self, [inputs, hidden]: [usize; 2]) -> Option<usize> {
        let rows = inputs.checked_add(hidden)?.checked_add(1)?;
        let extra = if self == Cell::Gru { hidden } else { 0 };
        rows.checked_mul(hidden)?.checked_mul(self.blocks())?.checked_add(extra)
    }
}

/// A view of one layer's matrices: of the input, of the hidden state, the offset, and for a GRU the offset `d` inside its
/// candidate. Its blocks are in the order of [`Cell`]'s equations.
#[derive(Debug, Clone, Copy)]
pub struct RecurrentLayer {
    cell: Cell,
    hidden: usize,
    first: usize,
}

impl RecurrentLayer {
    /// Adds the weights of a layer, uniform on `±1/√H`.
    pub fn draw(
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
        RecurrentLayer { cell, hidden, first }
    }

    /// The matrix that reads the input.
    pub fn input_matrix(self) -> usize {
        self.first
    }

    /// The widths of what a particle carries for this layer; the first is that of `h`.
    pub fn carried_widths(self) -> Vec<usize> {
        vec![self.hidden; if self.cell == Cell::Lstm { 2 } else { 1 }]
    }

    /// Advances the layer; the first that comes back is `h'`, which is also its output.
    pub fn forward<A: Arithmetic>(
        self,
        arithmetic: &mut A,
        input: &A::Rows,
        carried: &[A::Rows],
    ) -> Vec<A::Rows> {
        let (h, [of_input, of_hidden, bias, offset]) = (&carried[0], [0, 1, 2, 3].map(|at| self.first + at));
        match self.cell {
            Cell::Elman => {
                let inputs = [(input, of_input), (h, of_hidden)];
                vec![arithmetic.affine(&inputs, Some(bias), Activation::Tanh)]
            }
            Cell::Gru => {
                let from_input = arithmetic.affine(&[(input, of_input)], Some(bias), Activation::Linear);
                let from_hidden = arithmetic.affine(&[(h, of_hidden)], None, Activation::Linear);
                vec![arithmetic.gru(&from_input, &from_hidden, offset, h)]
            }
            Cell::Lstm => {
                let inputs = [(input, of_input), (h, of_hidden)];
                let gates = arithmetic.affine(&inputs, Some(bias), Activation::Linear);
                let (h, c) = arithmetic.lstm(gates, &carried[1]);
                vec![h, c]
            }
        }
    }
}
