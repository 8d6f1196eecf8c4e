//! The fully connected proposal of the paper: unrolled mean networks and one covariance network.

use motes_models::{ModelShape, Seed};
use motes_networks::layers::Mlp;
use motes_networks::{Arithmetic, HiddenReader, Known, Networks, Outputs, Parameters};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::gaussian::{GaussianNetworks, GaussianProposal};
use crate::over_time::{OverTime, one_at};
use crate::settings::{check_widths, count_affine};

/// The settings of an [`Fcnn`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FcnnConfig {
    /// Hidden widths of the mean networks and of the covariance network.
    pub widths: Vec<usize>,
    /// `δ`, added to the diagonal of the covariance.
    pub ridge: f64,
    /// Whether each time has networks of its own.
    #[serde(default, skip_serializing_if = "OverTime::is_each_time")]
    pub networks: OverTime,
}

impl FcnnConfig {
    /// The paper's: hidden layers of 256, 512 and 1024, a mean network for each time; a ridge of 1e-6.
    pub fn paper() -> Self {
        FcnnConfig { widths: vec![256, 512, 1024], ridge: 1e-6, networks: OverTime::EachTime }
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
/// at all times (the paper's section on the multivariate normal parametrization). With [`OverTime::Shared`] `t = 0` has both networks and `C` to
/// itself, all later times share theirs, and there is no horizon. Hidden activations are tanh, output
/// layers are linear, and `x_{−1} = 0`. Initial weights and biases are uniform on `±1/√fan_in`, `C` on `±1/N`.
pub type Fcnn = GaussianProposal<FcnnNetworks>;

/// The networks of an [`Fcnn`].
#[derive(Clone)]
pub struct FcnnNetworks {
    over_time: OverTime,
    means: Vec<Mlp>,
    /// One for all times, or one for `t = 0` and one for the others.
    representations: Vec<Mlp>,
}

impl Networks for FcnnNetworks {
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
        let inputs = arithmetic.stacked(&known.previous, &known.measurement);
        let means = self.means[self.over_time.at(time)].forward(arithmetic, inputs.clone());
        let representations = one_at(&self.representations, time).forward(arithmetic, inputs);
        Outputs::new([means, representations], [])
    }
}

impl GaussianNetworks for FcnnNetworks {
    const NAME: &'static str = "fcnn";
    type Config = FcnnConfig;

    fn check(config: &FcnnConfig, horizon: usize) -> Result<(), ProposalError> {
        config.networks.check(horizon)?;
        check_widths("the hidden widths", &config.widths)
    }

    fn count(config: &FcnnConfig, shape: &ModelShape, horizon: usize) -> Option<usize> {
        let networks = config.networks.networks(horizon).checked_add(config.networks.of_one())?;
        count_affine(&config.layers(shape), 1)?.checked_mul(networks)
    }

    fn draw(
        config: &FcnnConfig,
        shape: &ModelShape,
        horizon: usize,
        parameters: &mut Parameters,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        let widths = config.layers(shape);
        let over_time = config.networks;
        let mut draw = |names: Vec<String>| -> Vec<Mlp> {
            names.iter().map(|name| Mlp::draw(parameters, name, &widths, seed)).collect()
        };
        let means = draw(over_time.names("mean", horizon));
        Ok(FcnnNetworks { over_time, means, representations: draw(over_time.names_of_one("covariance")) })
    }

    fn ridge(config: &FcnnConfig) -> f64 {
        config.ridge
    }

    fn over_time(config: &FcnnConfig) -> OverTime {
        config.networks
    }
}
