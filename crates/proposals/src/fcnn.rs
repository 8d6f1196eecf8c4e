//! The fully connected proposal of the paper: unrolled mean networks and one covariance network.

use motes_models::{ModelShape, Seed};
use motes_networks::layers::Mlp;
use motes_networks::{Arithmetic, Known, Networks, Outputs, Parameters};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::gaussian::{GaussianNetworks, GaussianProposal};
use crate::settings::{check_horizon, check_widths, count_affine};

/// The settings of an [`Fcnn`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FcnnConfig {
    /// Hidden widths of the mean networks and of the covariance network.
    pub widths: Vec<usize>,
    /// `δ`, added to the diagonal of the covariance.
    pub ridge: f64,
}

impl FcnnConfig {
    /// The paper's sizes: hidden layers of 256, 512 and 1024; a ridge of 1e-6.
    pub fn paper() -> Self {
        FcnnConfig { widths: vec![256, 512, 1024], ridge: 1e-6 }
    }

    /// Widths from the input `[x_{t−1}; y_t]` to the output.
    fn layers(&self, shape: &ModelShape) -> Vec<usize> {
        let inputs = shape.state_dim + shape.measurement_dim;
        [&[inputs], self.widths.as_slice(), &[shape.state_dim]].concat()
    }
}

/// `q(x_t | x_{t−1}, y_t) = N(μ_t, Σ_t)` with `μ_t = NN_t(x_{t−1}, y_t)` and `Σ_t = C K(z_t) Cᵀ + δI`, `z_t = NN(x_{t−1}, y_t)`.
///
/// Each time has a mean network of its own, so the proposal knows its horizon `T`; the covariance network is the same
/// at all times (the paper's section on the multivariate normal parametrization). Hidden activations are tanh, output
/// layers are linear, and `x_{−1} = 0`. Initial weights and biases are uniform on `±1/√fan_in`, `C` on `±1/N`.
pub type Fcnn = GaussianProposal<FcnnNetworks>;

/// The networks of an [`Fcnn`].
#[derive(Clone)]
pub struct FcnnNetworks {
    means: Vec<Mlp>,
    representation: Mlp,
}

impl Networks for FcnnNetworks {
    fn horizon(&self) -> Option<usize> {
        Some(self.means.len())
    }

    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        time: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        let inputs = arithmetic.stacked(&known.previous, &known.measurement);
        let means = self.means[time].forward(arithmetic, inputs.clone());
        let representations = self.representation.forward(arithmetic, inputs);
        Outputs { values: vec![means, representations], hidden: Vec::new() }
    }
}

impl GaussianNetworks for FcnnNetworks {
    const NAME: &'static str = "fcnn";
    type Config = FcnnConfig;

    fn check(config: &FcnnConfig, horizon: usize) -> Result<(), ProposalError> {
        check_horizon(horizon)?;
        check_widths("the hidden widths", &config.widths)
    }

    fn count(config: &FcnnConfig, shape: &ModelShape, horizon: usize) -> Option<usize> {
        count_affine(&config.layers(shape), 1)?.checked_mul(horizon.checked_add(1)?)
    }

    fn draw(
        config: &FcnnConfig,
        shape: &ModelShape,
        horizon: usize,
        parameters: &mut Parameters,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        let widths = config.layers(shape);
        Ok(FcnnNetworks {
            means: (0..horizon).map(|t| Mlp::draw(parameters, &format!("mean.{t}"), &widths, seed)).collect(),
            representation: Mlp::draw(parameters, "covariance", &widths, seed),
        })
    }

    fn ridge(config: &FcnnConfig) -> f64 {
        config.ridge
    }
}
