//! The recurrent proposal of the paper: a hidden state for each particle, the same weights at all times.

use motes_models::{ModelShape, Seed};
use motes_networks::layers::{Cell, Mlp, RecurrentLayer};
use motes_networks::{Arithmetic, HiddenReader, Known, Networks, Outputs, Parameters};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::gaussian::{GaussianNetworks, GaussianProposal};
use crate::settings::{check_count, count_affine};

/// The settings of an [`Rnn`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RnnConfig {
    /// What each layer computes.
    pub cell: Cell,
    /// `H`, the number of hidden units in each layer.
    pub hidden: usize,
    /// Layers on top of each other.
    pub depth: usize,
    /// `δ`, added to the diagonal of the covariance.
    pub ridge: f64,
}

impl RnnConfig {
    /// The paper's sizes: one LSTM layer of 1024 hidden units; a ridge of 1e-6.
    pub fn paper() -> Self {
        RnnConfig { cell: Cell::Lstm, hidden: 1024, depth: 1, ridge: 1e-6 }
    }
}

/// `q(x_t | x_{0:t−1}, y_{0:t}) = N(μ_t, C K(z_t) Cᵀ + δI)` with `μ_t` and `z_t` affine in a hidden state
/// `h_t = cell(h_{t−1}, [x_{t−1}; y_t])` (the paper's equations "hiddenRNN", "meanRNN" and "covRNN"; `h_{−1} = 0`, `x_{−1} = 0`).
///
/// The hidden state belongs to a particle and is resampled with it. The weights are the same at all times, so a trained
/// proposal runs on a sequence of any length. Initial weights of the cells are uniform on `±1/√H`, those of the two affine maps on
/// `±1/√fan_in`, `C` on `±1/N`.
pub type Rnn = GaussianProposal<RnnNetworks>;

/// The networks of an [`Rnn`].
#[derive(Clone)]
pub struct RnnNetworks {
    layers: Vec<RecurrentLayer>,
    mean: Mlp,
    representation: Mlp,
}

impl Networks for RnnNetworks {
    fn horizon(&self) -> Option<usize> {
        None
    }

    fn hidden_widths(&self) -> Vec<usize> {
        self.layers.iter().flat_map(|layer| layer.carried_widths()).collect()
    }

    /// What reads a hidden state from outside of its layer: the layer above, and the two affine maps. What a layer remembers of itself is never left out.
    fn hidden_readers(&self) -> Vec<HiddenReader> {
        let above = self.layers.windows(2);
        let mut readers: Vec<HiddenReader> =
            above.map(|pair| HiddenReader::plain(pair[1].input_matrix(), pair[0].input_matrix())).collect();
        if let Some(last) = self.layers.last() {
            let maps = [self.mean, self.representation];
            readers.extend(maps.map(|map| HiddenReader::plain(map.first_matrix(), last.input_matrix())));
        }
        readers
    }

    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        _time: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        let mut values = arithmetic.stacked(&known.previous, &known.measurement);
        let (mut hidden, mut carried) = (Vec::new(), known.hidden);
        for layer in &self.layers {
            let (own, others) = carried.split_at(layer.carried_widths().len());
            let next = layer.forward(arithmetic, &values, own);
            values = next[0].clone();
            hidden.extend(next);
            carried = others;
        }
        let means = self.mean.forward(arithmetic, values.clone());
        let representations = self.representation.forward(arithmetic, values);
        Outputs::new([means, representations], hidden)
    }
}

impl GaussianNetworks for RnnNetworks {
    const NAME: &'static str = "rnn";
    type Config = RnnConfig;

    fn check(config: &RnnConfig, _horizon: usize) -> Result<(), ProposalError> {
        check_count("the hidden size H", config.hidden)?;
        check_count("the depth of the recurrent network", config.depth)
    }

    fn count(config: &RnnConfig, shape: &ModelShape, _horizon: usize) -> Option<usize> {
        let hidden = config.hidden;
        let first = config.cell.count([shape.state_dim + shape.measurement_dim, hidden])?;
        let above = config.cell.count([hidden, hidden])?.checked_mul(config.depth.checked_sub(1)?)?;
        let heads = count_affine(&[hidden, shape.state_dim], 1)?.checked_mul(2)?;
        first.checked_add(above)?.checked_add(heads)
    }

    fn draw(
        config: &RnnConfig,
        shape: &ModelShape,
        _horizon: usize,
        parameters: &mut Parameters,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        let (n, hidden) = (shape.state_dim, config.hidden);
        Ok(RnnNetworks {
            layers: (0..config.depth)
                .map(|layer| {
                    let inputs = if layer == 0 { n + shape.measurement_dim } else { hidden };
                    let name = format!("recurrent.{layer}");
                    RecurrentLayer::draw(parameters, &name, config.cell, [inputs, hidden], seed)
                })
                .collect(),
            mean: Mlp::draw(parameters, "mean", &[hidden, n], seed),
            representation: Mlp::draw(parameters, "covariance", &[hidden, n], seed),
        })
    }

    fn ridge(config: &RnnConfig) -> f64 {
        config.ridge
    }
}
