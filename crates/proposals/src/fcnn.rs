//! The fully connected proposal of the paper: unrolled mean networks and one covariance network.

use motes_models::{Seed, StateSpaceModel};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::Compute;
use crate::arithmetic::Arithmetic;
use crate::family::{Family, check_horizon, check_weights, check_widths, count_affine, sizes_of};
use crate::gaussian::{Emission, GaussianProposal, Known, Networks};
use crate::mlp::Mlp;

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
    fn layers(&self, state_dim: usize, measurement_dim: usize) -> Vec<usize> {
        [&[state_dim + measurement_dim], self.widths.as_slice(), &[state_dim]].concat()
    }
}

/// `q(x_t | x_{t−1}, y_t) = N(μ_t, Σ_t)` with `μ_t = NN_t(x_{t−1}, y_t)` and `Σ_t = C K(z_t) Cᵀ + δI`, `z_t = NN(x_{t−1}, y_t)`.
///
/// Each time has a mean network of its own, so the proposal knows its horizon `T`; the covariance network is the same
/// at all times (the paper's section on the multivariate normal parametrization). Hidden activations are tanh, output
/// layers are linear, and `x_{−1} = 0`.
pub type Fcnn = GaussianProposal<FcnnNetworks, FcnnConfig>;

/// The networks of an [`Fcnn`].
#[derive(Clone)]
pub struct FcnnNetworks {
    means: Vec<Mlp>,
    representation: Mlp,
}

impl Fcnn {
    /// Draws initial weights for `model`'s dimensions and `horizon` times: weights and biases uniform on `±1/√fan_in`,
    /// `C` uniform on `±1/N`, each matrix from the stream that `seed` has for its name.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] if the horizon or a width is 0, or the ridge is negative or not finite.
    pub fn new(
        config: &FcnnConfig,
        model: &(impl StateSpaceModel + ?Sized),
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        check_horizon(horizon)?;
        check_widths("the hidden widths", &config.widths)?;
        let sizes = sizes_of(model)?;
        let (n, m) = (sizes.state_dim, sizes.measurement_dim);
        check_weights(Fcnn::count(config, (n, m), horizon))?;
        let widths = config.layers(n, m);
        GaussianProposal::assemble(config, config.ridge, sizes, compute, seed, |parameters| FcnnNetworks {
            means: (0..horizon).map(|t| Mlp::draw(parameters, &format!("mean.{t}"), &widths, seed)).collect(),
            representation: Mlp::draw(parameters, "covariance", &widths, seed),
        })
    }
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
    ) -> Emission<A::Rows> {
        let inputs = arithmetic.stacked(&known.previous, &known.measurement);
        Emission {
            means: self.means[time].forward(arithmetic, inputs.clone()),
            representations: self.representation.forward(arithmetic, inputs),
            hidden: Vec::new(),
        }
    }
}

impl Family for Fcnn {
    const NAME: &'static str = "fcnn";
    type Config = FcnnConfig;

    fn create(
        config: &FcnnConfig,
        model: &dyn StateSpaceModel,
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        Fcnn::new(config, model, horizon, compute, seed)
    }

    fn count(config: &FcnnConfig, (n, m): (usize, usize), horizon: usize) -> Option<usize> {
        count_affine(&config.layers(n, m), 1)?.checked_mul(horizon.checked_add(1)?)?.checked_add(n * n)
    }

    fn config(&self) -> &FcnnConfig {
        &self.config
    }
}
