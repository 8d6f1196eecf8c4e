//! The graph proposal of the paper: networks that compute along the edges of the system's graph.

use motes_models::{ModelShape, Seed};
use motes_networks::layers::GraphNetwork;
use motes_networks::{
    Activation, Arithmetic, Graph, HiddenReader, Known, Networks, Outputs, Parameters, fan_in_bound,
};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::gaussian::{GaussianNetworks, GaussianProposal};
use crate::over_time::{OverTime, one_at};
use crate::settings::{check_widths, count_affine, graph_of};

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
    /// Whether each time has networks of its own.
    #[serde(default, skip_serializing_if = "OverTime::is_each_time")]
    pub networks: OverTime,
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
    /// The paper's: hidden layers of 256, 512 and 1024 features, filters of order 3, a fixed adapter, a mean network for each time; a ridge of 1e-6.
    pub fn paper() -> Self {
        GnnConfig {
            features: vec![256, 512, 1024],
            order: 3,
            adapter: Adapter::Fixed,
            ridge: 1e-6,
            networks: OverTime::EachTime,
        }
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
/// has a mean network of its own, so the proposal knows its horizon `T`; the covariance network is the same at all times. With
/// [`OverTime::Shared`] `t = 0` has both networks and `C` to itself, all later times share theirs, and there is no horizon. Learned adapters serve all
/// times either way. The weights do not depend on `N` but for `C` and a learned adapter. Initial weights and biases are uniform on `±1/√(F(D+1))`, a learned
/// adapter on `±1/√M`, `C` on `±1/N`.
///
/// A particle costs `2N Σ_ℓ (D+1) F_{ℓ−1} F_ℓ` multiplications a step for its two networks (53 million at the paper's sizes and `N = 10`),
/// and `N² D Σ_ℓ min(F_{ℓ−1}, F_ℓ)` for each of them for the shifts.
pub type Gnn = GaussianProposal<GnnNetworks>;

/// The networks of a [`Gnn`].
#[derive(Clone)]
pub struct GnnNetworks {
    graph: Graph,
    over_time: OverTime,
    means: Vec<GraphNetwork>,
    /// One for all times, or one for `t = 0` and one for the others.
    representations: Vec<GraphNetwork>,
    /// The indices among the parameters of the learned adapters, of the means' and of the representation's.
    adapters: Option<[usize; 2]>,
}

impl Networks for GnnNetworks {
    fn horizon(&self) -> Option<usize> {
        self.over_time.horizon(self.means.len())
    }

    fn hidden_readers(&self) -> Vec<HiddenReader> {
        self.means.iter().chain(&self.representations).flat_map(|network| network.hidden_readers()).collect()
    }

    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        time: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        let Known { previous, measurement, .. } = &known;
        let of_means = self.adapters.map(|[of_means, _]| of_means);
        let inputs = arithmetic.at_nodes(previous, measurement, &self.graph, of_means);
        let of_representations = match self.adapters {
            None => inputs.clone(),
            Some([_, index]) => arithmetic.at_nodes(previous, measurement, &self.graph, Some(index)),
        };
        let mut outputs = |network: &GraphNetwork, inputs: A::Rows| {
            let at_nodes = network.forward(arithmetic, &self.graph, inputs, Activation::Linear);
            arithmetic.by_particle(&at_nodes, self.graph.nodes())
        };
        let means = outputs(&self.means[self.over_time.at(time)], inputs);
        let representations = outputs(one_at(&self.representations, time), of_representations);
        Outputs::new([means, representations], [])
    }
}

impl GaussianNetworks for GnnNetworks {
    const NAME: &'static str = "gnn";
    type Config = GnnConfig;

    fn check(config: &GnnConfig, horizon: usize) -> Result<(), ProposalError> {
        config.networks.check(horizon)?;
        check_widths("the features of the hidden layers", &config.features)
    }

    fn count(config: &GnnConfig, shape: &ModelShape, horizon: usize) -> Option<usize> {
        let networks = count_affine(&config.layers(), config.order.checked_add(1)?)?;
        let adapters = match config.adapter {
            Adapter::Fixed => 0,
            Adapter::Learned => 2 * shape.state_dim * shape.measurement_dim,
        };
        let number = config.networks.networks(horizon).checked_add(config.networks.of_one())?;
        networks.checked_mul(number)?.checked_add(adapters)
    }

    /// # Errors
    /// [`ProposalError::NoGraph`] if the model has none, [`ProposalError::Mismatch`] for a graph of other sizes.
    fn draw(
        config: &GnnConfig,
        shape: &ModelShape,
        horizon: usize,
        parameters: &mut Parameters,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        let &ModelShape { state_dim: n, measurement_dim: m, .. } = shape;
        let graph = graph_of(shape)?;
        let features = config.layers();
        let over_time = config.networks;
        let mut draw = |names: Vec<String>| -> Vec<GraphNetwork> {
            let mut draw = |name| GraphNetwork::draw(parameters, name, &features, config.order, seed);
            names.iter().map(|name| draw(name)).collect()
        };
        let means = draw(over_time.names("mean", horizon));
        let representations = draw(over_time.names_of_one("covariance"));
        let adapters = match config.adapter {
            Adapter::Fixed => None,
            Adapter::Learned => {
                let first = parameters.len();
                parameters.draw("mean.adapter".into(), [n, m], fan_in_bound(m), seed);
                parameters.draw("covariance.adapter".into(), [n, m], fan_in_bound(m), seed);
                Some([first, first + 1])
            }
        };
        Ok(GnnNetworks { graph, over_time, means, representations, adapters })
    }

    fn ridge(config: &GnnConfig) -> f64 {
        config.ridge
    }

    fn over_time(config: &GnnConfig) -> OverTime {
        config.networks
    }
}
