//! What determines a graph-diffusion system but for its random graph.

use serde::{Deserialize, Serialize};

use crate::Noise;

/// The map `φ` applied to each coordinate of the diffused state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drift {
    /// `φ(x) = x`: a linear system.
    Identity,
    /// `φ(x) = |x|`.
    Abs,
}

impl Drift {
    #[inline]
    pub(super) fn apply(self, value: f64) -> f64 {
        match self {
            Drift::Identity => value,
            Drift::Abs => value.abs(),
        }
    }

    #[inline]
    pub(super) fn slope(self, value: f64) -> f64 {
        match self {
            Drift::Identity => 1.0,
            Drift::Abs => value.signum(),
        }
    }
}

/// What determines a [`crate::GraphDiffusion`] but for its random graph. Set fields after [`GraphDiffusionConfig::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct GraphDiffusionConfig {
    /// `N`, the number of nodes and of state coordinates.
    pub state_dim: usize,
    /// `M`, the number of measured coordinates, at most `N` and at least `N/2`.
    pub measurement_dim: usize,
    /// Nearest others that a node is joined to.
    pub neighbours: usize,
    /// Signal-to-noise ratio of both noises, in dB: `σ² = ‖μ₀‖² / 10^(SNR/10)` with `μ₀ = 1`, so `‖μ₀‖² = N`.
    pub snr_db: f64,
    /// `φ`.
    pub drift: Drift,
    /// The family of both noises; the initial state is Gaussian whatever it is.
    pub noise: Noise,
}

impl GraphDiffusionConfig {
    /// The paper's linear Gaussian system with `N` nodes: `M = N − 2`, 3 neighbours, 5 dB.
    pub fn new(state_dim: usize) -> Self {
        GraphDiffusionConfig {
            state_dim,
            measurement_dim: state_dim.saturating_sub(2),
            neighbours: 3,
            snr_db: 5.0,
            drift: Drift::Identity,
            noise: Noise::Gaussian,
        }
    }
}
