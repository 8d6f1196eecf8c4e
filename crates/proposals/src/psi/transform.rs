//! The family: its settings, its weights, and the transform that they make at each time.

use std::sync::OnceLock;

use motes_models::{ModelShape, Seed};
use motes_networks::{Compute, Inputs, Parameters, fan_in_bound};
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use super::inverse::Factored;
use super::map::{Inverses, Map};
use crate::family::Family;
use crate::over_time::OverTime;
use crate::settings::{check_compute, check_count, check_ridge, check_shape, check_weights};

/// The settings of a [`Psi`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PsiConfig {
    /// `L`, the number of square layers after the first affine map.
    pub layers: usize,
    /// Added to the diagonal of each matrix that is to be inverted.
    pub ridge: f64,
    /// Whether each time has a transform of its own.
    #[serde(default, skip_serializing_if = "OverTime::is_each_time")]
    pub networks: OverTime,
}

impl PsiConfig {
    /// The paper's: 9 layers, a transform for each time; a ridge of 1e-3.
    pub fn paper() -> Self {
        PsiConfig { layers: 9, ridge: 1e-3, networks: OverTime::EachTime }
    }
}

/// `x_t = NN_t(tanh(A_t u + B_t x_{t−1} + C_t y_t))` with `u` uniform on the unit cube (the paper's equation
/// "arbitraryTransform"; `x_{−1} = 0`).
///
/// Samples are rows, so that each matrix multiplies from the right (`u A`), and the ridge is part of `A` and of each `W_ℓ`.
/// `NN_t` has `L` layers with square matrices, tanh after each but the last. With `ρ = tanh` and the values `a_ℓ` that it is
/// applied to, `log q(x_t) = −(log|det A| + Σ_ℓ log|det W_ℓ| + Σ_ℓ Σᵢ log ρ′(a_ℓᵢ))`. The image of the cube is bounded: outside
/// it the density is 0. Each time has a transform of its own, so the proposal knows its horizon `T`; with [`OverTime::Shared`] `t = 0` has one and
/// all later times have another, and there is no horizon. The ridge makes a
/// singular matrix unlikely, not impossible: [`ProposalError::Singular`], where a density is asked for.
#[derive(Clone)]
pub struct Psi {
    pub(super) config: PsiConfig,
    pub(super) state_dim: usize,
    pub(super) measurement_dim: usize,
    /// How many times it has transforms for; `None` if any number.
    pub(super) horizon: Option<usize>,
    pub(super) parameters: Parameters,
    /// What a filter prepared for its step.
    pub(super) prepared: Option<Prepared>,
}

/// What all particles of a step have in common.
#[derive(Clone)]
pub(super) struct Prepared {
    pub(super) time: usize,
    pub(super) map: Map,
    pub(super) log_abs_det: f64,
    /// For densities at given states, formed when the first block asks for one.
    pub(super) factored: OnceLock<Factored>,
    /// `C y_t`.
    pub(super) shift: Vec<f64>,
}

/// How many matrices the first affine map has: `A`, `B` and `C`.
pub(super) const FIRST: usize = 3;

impl Psi {
    /// Where the matrices of time `t` begin.
    pub(super) fn first(&self, time: usize) -> usize {
        self.config.networks.at(time) * (FIRST + 2 * self.config.layers)
    }

    /// The transform of time `t`, for the current weights.
    pub(super) fn map(&self, time: usize) -> Result<Map, ProposalError> {
        let n = self.state_dim;
        if let Some(horizon) = self.horizon
            && time >= horizon
        {
            return Err(ProposalError::PastHorizon { horizon, time });
        }
        let first = self.first(time);
        let host = |at: usize| self.parameters.host(first + at);
        let with_ridge = |at: usize| {
            let mut matrix = host(at);
            matrix.iter_mut().step_by(n + 1).for_each(|entry| *entry += self.config.ridge);
            matrix
        };
        let layers = (0..self.config.layers).map(|layer| FIRST + 2 * layer);
        Ok(Map {
            width: n,
            noise: with_ridge(0),
            previous: host(1),
            measurement: host(2),
            layers: layers.map(|at| (with_ridge(at), host(at + 1))).collect(),
        })
    }

    /// What `log q` at time `t` needs beside the transform.
    pub(super) fn inverses(&self, map: &Map, time: usize) -> Result<Inverses, ProposalError> {
        map.inverses().map_err(|(number, log_abs_det)| {
            let at = if number == 0 { 0 } else { FIRST + 2 * (number - 1) };
            let matrix = self.parameters.names()[self.first(time) + at].clone();
            ProposalError::Singular { matrix, time, log_abs_det }
        })
    }

    /// The transform of a time together with `C y_t` (`N`).
    pub(super) fn at_measurement(
        &self,
        time: usize,
        measurement: &[f64],
    ) -> Result<(Map, Vec<f64>), ProposalError> {
        let (found, expected) = (self.measurement_dim, measurement.len());
        ProposalError::unless_same("the measurement dimension M", found, expected)?;
        let map = self.map(time)?;
        let shift = map.shift(measurement);
        Ok((map, shift))
    }

    /// The transform of a time together with `B x_{t−1} + C y_t` of each particle (`R×N`).
    pub(super) fn conditioned(&self, inputs: &Inputs<'_>) -> Result<(Map, Vec<f64>), ProposalError> {
        let (map, shift) = self.at_measurement(inputs.time, inputs.measurement)?;
        let mut shifts = shift.repeat(inputs.particles);
        map.add_previous(inputs.previous, &mut shifts);
        Ok((map, shifts))
    }

    /// The noise `u` (`R×N`) that the transform takes to each of the given `states` (`R×N`), into `noise`, with `log q` in
    /// `log_density` (`R`): −∞ where the state lies outside the image of the cube, and `noise` then means nothing.
    ///
    /// # Errors
    /// As [`motes_smc::Proposal`], and [`ProposalError::Numerical`] with the particle if the transform is too ill-conditioned
    /// there to be inverted in floating point.
    pub fn inverse(
        &self,
        inputs: &Inputs<'_>,
        states: &[f64],
        noise: &mut [f64],
        log_density: &mut [f64],
    ) -> Result<(), ProposalError> {
        let (map, shifts) = self.conditioned(inputs)?;
        let log_abs_det = self.inverses(&map, inputs.time)?.log_abs_det;
        map.inverse(&Factored::new(&map, log_abs_det), &shifts, states, noise, log_density);
        match log_density.iter().position(|value| value.is_nan()) {
            None => Ok(()),
            Some(particle) => Err(ProposalError::Numerical {
                computation: "the inverse of the transform",
                particle,
                reason: "it is too ill-conditioned at this state".into(),
            }),
        }
    }
}

impl Family for Psi {
    const NAME: &'static str = "psi";
    type Config = PsiConfig;

    /// Each matrix is uniform on `±1/√fan_in`, biases on the bound of their layer.
    fn create(
        config: &PsiConfig,
        shape: &ModelShape,
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        check_compute(compute)?;
        config.networks.check(horizon)?;
        check_count("the number of layers of the transform", config.layers)?;
        check_ridge("the ridge of the transform", config.ridge)?;
        check_shape(shape)?;
        check_weights(Psi::count(config, shape, horizon))?;
        let &ModelShape { state_dim: n, measurement_dim: m, .. } = shape;
        let mut parameters = Parameters::new(compute);
        let (of_states, of_measurements) = (fan_in_bound(n), fan_in_bound(m));
        for name in config.networks.names("psi", horizon) {
            parameters.draw(format!("{name}.noise"), [n, n], of_states, seed);
            parameters.draw(format!("{name}.previous"), [n, n], of_states, seed);
            parameters.draw(format!("{name}.measurement"), [m, n], of_measurements, seed);
            for layer in 0..config.layers {
                parameters.draw(format!("{name}.{layer}.weight"), [n, n], of_states, seed);
                parameters.draw(format!("{name}.{layer}.bias"), [1, n], of_states, seed);
            }
        }
        let (config, horizon) = (config.clone(), config.networks.horizon(horizon));
        Ok(Psi { config, state_dim: n, measurement_dim: m, horizon, parameters, prepared: None })
    }

    fn count(config: &PsiConfig, shape: &ModelShape, horizon: usize) -> Option<usize> {
        let &ModelShape { state_dim: n, measurement_dim: m, .. } = shape;
        let layers = config.layers.checked_mul(n * n + n)?;
        layers.checked_add(2 * n * n + m * n)?.checked_mul(config.networks.networks(horizon))
    }

    fn config(&self) -> &PsiConfig {
        &self.config
    }
}
