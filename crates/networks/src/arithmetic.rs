//! What networks are made of: a handful of operations on batches of rows, which every backend knows how to do.

use crate::graph::{Graph, Shape};

/// What a backend does for a network in one step, forward; where a derivative is wanted it remembers what for.
///
/// A family writes its networks once, in these terms. Matrices of weights go by their indices among the parameters. An
/// operation that takes its input by value may use up its memory.
pub trait Arithmetic {
    /// A matrix of rows: one for each particle, or one for each node of each particle, node by node.
    type Rows: Clone;

    /// `[x_{t−1}; y_t]` of each particle, `R×(N+M)`, from `R×N` and `1×M`.
    fn stacked(&mut self, previous: &Self::Rows, measurement: &Self::Rows) -> Self::Rows;

    /// `ρ(Σ_i inputs_i W_i + b)`, one or two inputs with the index of the matrix that each is multiplied by.
    fn affine(
        &mut self,
        inputs: &[(&Self::Rows, usize)],
        bias: Option<usize>,
        activation: Activation,
    ) -> Self::Rows;

    /// `h'` and `c'` of an LSTM layer from its pre-activations (`R×4H`) and `c` (`R×H`); see [`crate::layers::Cell::Lstm`].
    fn lstm(&mut self, gates: Self::Rows, cells: &Self::Rows) -> (Self::Rows, Self::Rows);

    /// `h'` of a GRU layer from the products with its input and its hidden state (`R×3H` each), the index of the offset `d` and
    /// `h` (`R×H`); see [`crate::layers::Cell::Gru`].
    fn gru(
        &mut self,
        from_input: &Self::Rows,
        from_hidden: &Self::Rows,
        offset: usize,
        hidden: &Self::Rows,
    ) -> Self::Rows;

    /// `[x_{t−1}, A_y y_t]` of each node (`(N·R)×2`), from `R×N` and `1×M`, with the adapter of the graph or that of an index.
    fn at_nodes(
        &mut self,
        previous: &Self::Rows,
        measurement: &Self::Rows,
        graph: &Graph,
        adapter: Option<usize>,
    ) -> Self::Rows;

    /// Blocks of inputs at the nodes: `states` blocks of `N` numbers, one for each node, then `measurements` blocks of `M`, which the graph's adapter brings to the
    /// nodes. `R×(states·N + measurements·M)` to `(N·R)×(states + measurements)`.
    fn blocks_at_nodes(
        &mut self,
        inputs: &Self::Rows,
        graph: &Graph,
        states: usize,
        measurements: usize,
    ) -> Self::Rows;

    /// `ρ(Σ_d S^d X W_d + 1 bᵀ)` of each particle, `(N·R)×F_in` to `(N·R)×F_out`: matrix `taps` has the `W_d` on top of each other
    /// and the one after it is `b`.
    fn graph_filter(
        &mut self,
        graph: &Graph,
        values: &Self::Rows,
        shape: Shape,
        taps: usize,
        activation: Activation,
    ) -> Self::Rows;

    /// The values of each node of each particle, `(N·R)×F`, as a row for each particle, node after node: `R×(N·F)`.
    fn by_particle(&mut self, values: &Self::Rows, nodes: usize) -> Self::Rows;
}

/// What is applied to each entry of an affine map's output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activation {
    /// Nothing.
    Linear,
    /// The hyperbolic tangent.
    Tanh,
}
