//! The fully connected proposal of the paper: unrolled mean networks and one covariance network.

mod propose;
mod tape;

use motes_models::{Seed, StateSpaceModel};
use motes_smc::{Past, ProposalError};

use crate::backend::Compute;
use crate::covariance::KernelCovariance;
use crate::mlp::Mlp;
use crate::parameters::Parameters;

/// The settings of an [`Fcnn`].
#[derive(Debug, Clone, PartialEq)]
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
}

/// `q(x_t | x_{t−1}, y_t) = N(μ_t, Σ_t)` with `μ_t = NN_t(x_{t−1}, y_t)` and `Σ_t = C K(z_t) Cᵀ + δI`, `z_t = NN(x_{t−1}, y_t)`.
///
/// Each time has a mean network of its own, so the proposal knows its horizon `T`; the covariance network is the same
/// at all times (the paper's section on the multivariate normal parametrization). Hidden activations are tanh, output
/// layers are linear, and `x_{−1} = 0`.
#[derive(Clone)]
pub struct Fcnn {
    state_dim: usize,
    measurement_dim: usize,
    ridge: f64,
    parameters: Parameters,
    means: Vec<Mlp>,
    representation: Mlp,
    /// Index of `C` among the parameters.
    mixing: usize,
    conditional: crate::GaussianBatch,
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
        let setting = |name, value: String, expected| Err(ProposalError::Setting { name, value, expected });
        if horizon == 0 {
            return setting("the horizon T of an unrolled proposal", "0".into(), "at least 1");
        }
        if config.widths.is_empty() || config.widths.contains(&0) {
            return setting(
                "the hidden widths",
                format!("{:?}", config.widths),
                "one or more, each at least 1",
            );
        }
        if !(config.ridge >= 0.0 && config.ridge.is_finite()) {
            return setting("the ridge", config.ridge.to_string(), "at least 0 and finite");
        }
        let (n, m) = (model.state_dim(), model.measurement_dim());
        let widths: Vec<usize> = [&[n + m], config.widths.as_slice(), &[n]].concat();
        let mut parameters = Parameters::new(compute);
        let means =
            (0..horizon).map(|t| Mlp::draw(&mut parameters, &format!("mean.{t}"), &widths, seed)).collect();
        let representation = Mlp::draw(&mut parameters, "covariance", &widths, seed);
        let mixing = parameters.len();
        parameters.draw("covariance.mixing".into(), [n, n], 1.0 / n as f64, seed);
        Ok(Fcnn {
            state_dim: n,
            measurement_dim: m,
            ridge: config.ridge,
            parameters,
            means,
            representation,
            mixing,
            conditional: crate::GaussianBatch::default(),
        })
    }

    /// `[x_{t−1}; y_t]` of each particle, row-major; `x_{−1} = 0`.
    fn inputs(&self, past: &Past<'_>) -> Result<Vec<f64>, ProposalError> {
        if past.time >= self.means.len() {
            return Err(ProposalError::PastHorizon { horizon: self.means.len(), time: past.time });
        }
        let (n, m) = (self.state_dim, self.measurement_dim);
        let (found, expected) = (m, past.measurement.len());
        if found != expected {
            return Err(ProposalError::Mismatch { what: "the measurement dimension M", found, expected });
        }
        let mut inputs = vec![0.0; past.particles * (n + m)];
        for (row, input) in inputs.chunks_exact_mut(n + m).enumerate() {
            if let Some(previous) = past.previous {
                input[..n].copy_from_slice(&previous[row * n..(row + 1) * n]);
            }
            input[n..].copy_from_slice(past.measurement);
        }
        Ok(inputs)
    }

    /// The covariance for the current `C`.
    fn covariance(&self) -> Result<KernelCovariance, ProposalError> {
        KernelCovariance::new(self.state_dim, &self.parameters.host(self.mixing)?, self.ridge)
    }
}
