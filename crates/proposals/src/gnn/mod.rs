//! The graph proposal of the paper: networks that compute along the edges of the system's graph.

mod filters;

use burn::tensor::Tensor;
use motes_models::{Seed, StateSpaceModel};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::affine::Weights;
use crate::backend::Compute;
use crate::family::{Family, check_horizon, check_weights, check_widths, count_affine, sizes_of};
use crate::gaussian::{Emission, GaussianProposal, Known, Networks};
use crate::initial_weights::fan_in_bound;
use filters::{GraphNetwork, Shift};

/// The settings of a [`Gnn`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GnnConfig {
    /// Features of each node after the hidden layers.
    pub features: Vec<usize>,
    /// `D`: filters gather what lies up to this many edges away, with `D + 1` taps.
    pub order: usize,
    /// How measurements are brought to the nodes.
    pub adapter: Adapter,
    /// `δ`, added to the diagonal of the covariance.
    pub ridge: f64,
}

/// The `N×M` matrix that brings a measurement to the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Adapter {
    /// That of the system's graph ([`motes_models::SystemGraph`]).
    Fixed,
    /// One for the mean networks and one for that of the covariance, both learned; their number of weights grows with `N·M`.
    Learned,
}

impl GnnConfig {
    /// The paper's sizes: hidden layers of 256, 512 and 1024 features, filters of order 3, a fixed adapter; a ridge of 1e-6.
    pub fn paper() -> Self {
        GnnConfig { features: vec![256, 512, 1024], order: 3, adapter: Adapter::Fixed, ridge: 1e-6 }
    }

    /// Features at the input, two of each node, to those at the output, one.
    fn layers(&self) -> Vec<usize> {
        [&[2], self.features.as_slice(), &[1]].concat()
    }
}

/// `q(x_t | x_{t−1}, y_t) = N(μ_t, C K(z_t) Cᵀ + δI)` with `μ_t = GNN_t([x_{t−1}, A_y y_t]; S)` and `z_t = GNN([x_{t−1}, A_y y_t]; S)`.
///
/// A layer is `Z' = tanh(Σ_d S^d Z W_d + 1 bᵀ)` (the paper's equations "graphFilter" and "meanGNN"), the last without tanh,
/// with `S` the system's graph and two features at the input; `W_0 … W_D` of a layer are stored on top of each other. Each time
/// has a mean network of its own, so the proposal knows its horizon `T`; the covariance network is the same at all times. Its
/// weights do not depend on `N` but for `C` and a learned adapter.
///
/// A particle costs `2N Σ_ℓ (D+1) F_{ℓ−1} F_ℓ` multiplications a step for its two networks (53 million at the paper's sizes and `N = 10`),
/// and `N² D Σ_ℓ min(F_{ℓ−1}, F_ℓ)` for each of them for the shifts.
pub type Gnn = GaussianProposal<GnnNetworks, GnnConfig>;

/// The networks of a [`Gnn`].
#[derive(Clone)]
pub struct GnnNetworks {
    shift: Shift,
    means: Vec<GraphNetwork>,
    representation: GraphNetwork,
    adapters: Adapters,
}

#[derive(Clone)]
enum Adapters {
    /// `N×M`.
    Fixed(Box<Tensor<2>>),
    /// The indices among the parameters of that of the means and that of the representation.
    Learned(usize, usize),
}

impl Gnn {
    /// Draws initial weights for `model`'s graph and `horizon` times: weights and biases uniform on `±1/√(F(D+1))`, a learned
    /// adapter on `±1/√M`, `C` on `±1/N`, each matrix from the stream that `seed` has for its name.
    ///
    /// # Errors
    /// [`ProposalError::NoGraph`] if the model has none; [`ProposalError::Setting`] if the horizon or a number of features is 0, or the
    /// ridge is negative or not finite.
    pub fn new(
        config: &GnnConfig,
        model: &(impl StateSpaceModel + ?Sized),
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        check_horizon(horizon)?;
        check_widths("the features of the hidden layers", &config.features)?;
        let sizes = sizes_of(model)?;
        let (n, m) = (sizes.state_dim, sizes.measurement_dim);
        check_weights(Gnn::count(config, (n, m), horizon))?;
        let graph = model.graph().ok_or(ProposalError::NoGraph)?;
        for (what, found, expected) in [
            ("the rows of the graph's matrix", graph.shift.nrows(), n),
            ("the columns of the graph's matrix", graph.shift.ncols(), n),
            ("the rows of the graph's adapter", graph.adapter.nrows(), n),
            ("the columns of the graph's adapter", graph.adapter.ncols(), m),
        ] {
            ProposalError::unless_same(what, found, expected)?;
        }
        let matrix = |matrix: &faer::Mat<f64>| {
            let (rows, columns) = (matrix.nrows(), matrix.ncols());
            let values: Vec<f64> =
                (0..rows * columns).map(|at| matrix[(at / columns, at % columns)]).collect();
            compute.tensor(&values, [rows, columns])
        };
        let features = config.layers();
        GaussianProposal::assemble(config, config.ridge, sizes, compute, seed, |parameters| {
            let means = (0..horizon)
                .map(|t| GraphNetwork::draw(parameters, &format!("mean.{t}"), &features, config.order, seed))
                .collect();
            let representation = GraphNetwork::draw(parameters, "covariance", &features, config.order, seed);
            let adapters = match config.adapter {
                Adapter::Fixed => Adapters::Fixed(Box::new(matrix(&graph.adapter))),
                Adapter::Learned => {
                    let first = parameters.len();
                    parameters.draw("mean.adapter".into(), [n, m], fan_in_bound(m), seed);
                    parameters.draw("covariance.adapter".into(), [n, m], fan_in_bound(m), seed);
                    Adapters::Learned(first, first + 1)
                }
            };
            GnnNetworks { shift: Shift::new(matrix(&graph.shift)), means, representation, adapters }
        })
    }
}

impl Networks for GnnNetworks {
    fn horizon(&self) -> Option<usize> {
        Some(self.means.len())
    }

    fn forward(&self, weights: &mut Weights<'_>, time: usize, known: Known<'_>) -> Emission {
        // All inside is node by node: row `i·R + k` is node i of particle k, so that a shift along the edges and a
        // mixture of features are each one product of matrices.
        let [particles, nodes] = known.previous.dims();
        let column = |by_node: Tensor<2>| by_node.reshape([nodes * particles, 1]);
        let states = column(known.previous.clone().transpose());
        let inputs = |adapter: Tensor<2>| {
            let at_nodes = adapter.matmul(known.measurement.clone().transpose());
            Tensor::cat(vec![states.clone(), column(at_nodes.repeat_dim(1, particles))], 1)
        };
        let (of_mean, of_representation) = match &self.adapters {
            Adapters::Fixed(adapter) => {
                let inputs = inputs((**adapter).clone());
                (inputs.clone(), inputs)
            }
            Adapters::Learned(mean, representation) => {
                (inputs(weights.matrix(*mean)), inputs(weights.matrix(*representation)))
            }
        };
        let mut outputs = |network: &GraphNetwork, inputs: Tensor<2>| {
            network.forward(weights, &self.shift, inputs).reshape([nodes, particles]).transpose()
        };
        Emission {
            means: outputs(&self.means[time], of_mean),
            representations: outputs(&self.representation, of_representation),
            hidden: Vec::new(),
        }
    }
}

impl Family for Gnn {
    const NAME: &'static str = "gnn";
    type Config = GnnConfig;

    fn create(
        config: &GnnConfig,
        model: &dyn StateSpaceModel,
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        Gnn::new(config, model, horizon, compute, seed)
    }

    fn count(config: &GnnConfig, (n, m): (usize, usize), horizon: usize) -> Option<usize> {
        let networks = count_affine(&config.layers(), config.order.checked_add(1)?)?;
        let adapters = if config.adapter == Adapter::Learned { 2 * n * m } else { 0 };
        networks.checked_mul(horizon.checked_add(1)?)?.checked_add(adapters + n * n)
    }

    fn config(&self) -> &GnnConfig {
        &self.config
    }
}
