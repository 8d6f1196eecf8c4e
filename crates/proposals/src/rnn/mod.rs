//! The recurrent proposal of the paper: a hidden state for each particle, the same weights at all times.

mod cell;

pub use cell::Cell;

use motes_models::{Seed, StateSpaceModel};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::Compute;
use crate::arithmetic::Arithmetic;
use crate::family::{Family, check_count, check_weights, count_affine, sizes_of};
use crate::gaussian::{Emission, GaussianProposal, Known, Networks};
use crate::mlp::Mlp;
use cell::Layer;

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
/// proposal runs on a sequence of any length.
pub type Rnn = GaussianProposal<RnnNetworks, RnnConfig>;

/// The networks of an [`Rnn`].
#[derive(Clone)]
pub struct RnnNetworks {
    layers: Vec<Layer>,
    mean: Mlp,
    representation: Mlp,
}

impl Rnn {
    /// Draws initial weights for `model`'s dimensions: those of the cells uniform on `±1/√H`, those of the two affine maps on
    /// `±1/√fan_in`, `C` on `±1/N`, each matrix from the stream that `seed` has for its name.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] if the hidden size or the depth is 0, or the ridge is negative or not finite.
    pub fn new(
        config: &RnnConfig,
        model: &(impl StateSpaceModel + ?Sized),
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        check_count("the hidden size H", config.hidden)?;
        check_count("the depth of the recurrent network", config.depth)?;
        let sizes = sizes_of(model)?;
        let (n, m, hidden) = (sizes.state_dim, sizes.measurement_dim, config.hidden);
        check_weights(Rnn::count(config, (n, m), 0))?;
        GaussianProposal::assemble(config, config.ridge, sizes, compute, seed, |parameters| RnnNetworks {
            layers: (0..config.depth)
                .map(|layer| {
                    let inputs = if layer == 0 { n + m } else { hidden };
                    let name = format!("recurrent.{layer}");
                    Layer::draw(parameters, &name, config.cell, [inputs, hidden], seed)
                })
                .collect(),
            mean: Mlp::draw(parameters, "mean", &[hidden, n], seed),
            representation: Mlp::draw(parameters, "covariance", &[hidden, n], seed),
        })
    }
}

impl Networks for RnnNetworks {
    fn horizon(&self) -> Option<usize> {
        None
    }

    fn hidden_widths(&self) -> Vec<usize> {
        self.layers.iter().flat_map(|layer| layer.carried_widths()).collect()
    }

    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        _time: usize,
        known: Known<'_, A::Rows>,
    ) -> Emission<A::Rows> {
        let mut values = arithmetic.stacked(&known.previous, &known.measurement);
        let (mut hidden, mut carried) = (Vec::new(), known.hidden);
        for layer in &self.layers {
            let (own, others) = carried.split_at(layer.carried_widths().len());
            let next = layer.forward(arithmetic, &values, own);
            values = next[0].clone();
            hidden.extend(next);
            carried = others;
        }
        Emission {
            means: self.mean.forward(arithmetic, values.clone()),
            representations: self.representation.forward(arithmetic, values),
            hidden,
        }
    }
}

impl Family for Rnn {
    const NAME: &'static str = "rnn";
    type Config = RnnConfig;

    fn create(
        config: &RnnConfig,
        model: &dyn StateSpaceModel,
        _horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        Rnn::new(config, model, compute, seed)
    }

    fn count(config: &RnnConfig, (n, m): (usize, usize), _horizon: usize) -> Option<usize> {
        let hidden = config.hidden;
        let first = config.cell.count([n + m, hidden])?;
        let above = config.cell.count([hidden, hidden])?.checked_mul(config.depth.checked_sub(1)?)?;
        let heads = count_affine(&[hidden, n], 1)?.checked_mul(2)?;
        first.checked_add(above)?.checked_add(heads)?.checked_add(n * n)
    }

    fn config(&self) -> &RnnConfig {
        &self.config
    }
}
