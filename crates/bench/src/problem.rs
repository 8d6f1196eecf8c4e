//! The system that a unit works on, its measurements, and what is known exactly about them.

use motes_models::{
    Drift, GraphDiffusion, GraphDiffusionConfig, ModelError, Noise, Sequence, Trajectory, kalman, simulate,
};

use crate::UnitConfig;
use crate::config;

/// One repetition of an experiment.
pub(crate) struct Problem {
    /// The system that data are drawn from.
    pub(crate) system: GraphDiffusion,
    /// The model that weights and objective use.
    pub(crate) model: GraphDiffusion,
    /// What was drawn from the true system.
    pub(crate) trajectory: Trajectory,
    /// Exact inference in the filter's model, where it is linear and Gaussian.
    pub(crate) exact: Option<Exact>,
    /// Whether the noise of the system is Gaussian, so that the exact means are also those of the system itself.
    pub(crate) has_gaussian_noise: bool,
}

/// Exact inference by the Kalman filter.
pub(crate) struct Exact {
    /// `E[x_t | y_{0:t}]` at each time.
    pub(crate) means: Sequence,
    /// `log p(y_{0:T−1})`.
    pub(crate) log_evidence: f64,
}

impl Problem {
    pub(crate) fn draw(unit: &UnitConfig) -> Result<Problem, ModelError> {
        let config::System { drift, noise, densities, snr_db, neighbours, unmeasured, dimension, horizon } =
            unit.system;
        let noise = match noise {
            config::Noise::Gaussian => Noise::Gaussian,
            config::Noise::Exponential => Noise::Exponential,
            config::Noise::Uniform => Noise::Uniform,
        };
        let drift = match drift {
            config::Drift::Identity => Drift::Identity,
            config::Drift::Abs => Drift::Abs,
        };
        let measurement_dim = dimension - unmeasured;
        let settings =
            GraphDiffusionConfig { state_dim: dimension, measurement_dim, neighbours, snr_db, drift, noise };
        let seed = unit.system_seed();
        let system = GraphDiffusion::random(&settings, &mut seed.child("graph").stream())?;
        let trajectory = simulate(&system, horizon, &mut seed.child("trajectory").stream())?;
        let model = match densities {
            config::Densities::Gaussian => system.with_noise(Noise::Gaussian),
            config::Densities::Exact => system.clone(),
        };
        let believes_gaussian = noise == Noise::Gaussian || densities == config::Densities::Gaussian;
        let exact = if drift == Drift::Identity && believes_gaussian {
            let filtered = kalman::filter(&model.moment_matched()?, &trajectory.measurements)?;
            let means = filtered.steps.iter().flat_map(|step| step.filtered.mean.iter().copied()).collect();
            Some(Exact { means: Sequence::new(dimension, means)?, log_evidence: filtered.log_evidence() })
        } else {
            None
        };
        Ok(Problem { system, model, trajectory, exact, has_gaussian_noise: noise == Noise::Gaussian })
    }

    /// What estimates are held against: the exact posterior means where they exist, else the simulated states.
    pub(crate) fn truth(&self) -> &Sequence {
        match &self.exact {
            Some(exact) if self.has_gaussian_noise => &exact.means,
            _ => &self.trajectory.states,
        }
    }
}
