//! The hidden layers of a network: fully connected, or along the edges of a graph.

use motes_models::Seed;
use motes_networks::layers::GraphNetwork;
use motes_networks::{Activation, Arithmetic, Graph, HiddenReader, Parameters, fan_in_bound};

use super::inputs::Blocks;

/// The hidden layers of a network.
#[derive(Clone)]
pub(super) enum Hidden {
    /// `z_ℓ = tanh(z_{ℓ−1} W_ℓ + b_ℓ)`, `W_ℓ` and `b_ℓ` from `first` on.
    FullyConnected { first: usize, layers: usize },
    /// Graph filters with tanh, and the features of all nodes side by side.
    OnGraph { layers: GraphNetwork, graph: Graph, inputs: Blocks },
}

/// A graph, and `D`: how many edges away a filter gathers from.
pub(super) type Along = (Graph, usize);

impl Hidden {
    /// Adds the weights of layers with the given widths, or features of each node.
    pub(super) fn draw(
        parameters: &mut Parameters,
        name: &str,
        inputs: Blocks,
        widths: &[usize],
        along: Option<&Along>,
        seed: &Seed,
    ) -> Self {
        if let Some((graph, order)) = along {
            let features = [&[inputs.features()], widths].concat();
            let layers = GraphNetwork::draw(parameters, name, &features, *order, seed);
            return Hidden::OnGraph { layers, graph: graph.clone(), inputs };
        }
        let first = parameters.len();
        for (layer, pair) in [&[inputs.count()], widths].concat().windows(2).enumerate() {
            let bound = fan_in_bound(pair[0]);
            parameters.draw(format!("{name}.{layer}.weight"), [pair[0], pair[1]], bound, seed);
            parameters.draw(format!("{name}.{layer}.bias"), [1, pair[1]], bound, seed);
        }
        Hidden::FullyConnected { first, layers: widths.len() }
    }

    /// How many numbers the weights are, and how wide the last layer is; `None` if they cannot be counted.
    pub(super) fn count(inputs: Blocks, widths: &[usize], order: Option<usize>) -> Option<[usize; 2]> {
        let last = *widths.last()?;
        let (inputs, taps, last) = match order {
            Some(order) => (inputs.features(), order.checked_add(1)?, last.checked_mul(inputs.nodes())?),
            None => (inputs.count(), 1, last),
        };
        Some([crate::settings::count_affine(&[&[inputs], widths].concat(), taps)?, last])
    }

    /// How wide the last layer is.
    pub(super) fn width(&self, widths: &[usize]) -> usize {
        let last = widths.last().copied().unwrap_or_default();
        match self {
            Hidden::FullyConnected { .. } => last,
            Hidden::OnGraph { graph, .. } => last * graph.nodes(),
        }
    }

    /// The matrices that read hidden units; `outputs` is the one that reads the last layer. Along a graph all nodes share a feature, which is one unit.
    pub(super) fn readers(&self, outputs: usize) -> Vec<HiddenReader> {
        match self {
            Hidden::FullyConnected { first, layers } => {
                let of_layer = |layer: usize| first + 2 * layer;
                let inner = (1..*layers).map(|at| HiddenReader::plain(of_layer(at), of_layer(at - 1)));
                inner.chain([HiddenReader::plain(outputs, of_layer(layers - 1))]).collect()
            }
            Hidden::OnGraph { layers, graph, .. } => {
                let last =
                    HiddenReader { matrix: outputs, fed_by: layers.last_matrix(), copies: graph.nodes() };
                layers.hidden_readers().chain([last]).collect()
            }
        }
    }

    /// `R` rows of inputs to `R` rows of the last layer.
    pub(super) fn forward<A: Arithmetic>(&self, arithmetic: &mut A, inputs: &A::Rows) -> A::Rows {
        match self {
            Hidden::FullyConnected { first, layers } => (0..*layers).fold(inputs.clone(), |values, layer| {
                let at = first + 2 * layer;
                arithmetic.affine(&[(&values, at)], Some(at + 1), Activation::Tanh)
            }),
            Hidden::OnGraph { layers, graph, inputs: blocks } => {
                let [states, measurements] = blocks.numbers();
                let at_nodes = arithmetic.blocks_at_nodes(inputs, graph, states, measurements);
                let at_nodes = layers.forward(arithmetic, graph, at_nodes, Activation::Tanh);
                arithmetic.by_particle(&at_nodes, graph.nodes())
            }
        }
    }
}
