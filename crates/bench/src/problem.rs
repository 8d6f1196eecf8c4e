//! The system that a unit works on, its measurements, and what is known exactly about them.

use motes_models::{
    AdditiveGaussian, Drift, Epidemic, EpidemicConfig, GraphDiffusion, GraphDiffusionConfig, ModelError,
    ModelShape, Noise, OwnModel, Sequence, StateGradients, StepRecord, Trajectory, kalman, simulate,
    simulate_within,
};

use motes_smc::RecordedStep;

use crate::config::{self, Densities};
use crate::diffusion_equations::DiffusionEquations;
use crate::unit::{UnitConfig, UnitSystem};
use crate::unit_error::{UnitError, failed};

/// All that experiments ask of a system.
pub(crate) trait System: StateGradients + AdditiveGaussian + OwnModel + Send {}

impl<S: StateGradients + AdditiveGaussian + OwnModel + Send> System for S {}

/// Any system.
pub(crate) type Model = dyn System;

/// One repetition of an experiment.
pub(crate) struct Problem {
    /// The system that data are drawn from.
    pub(crate) system: Box<Model>,
    /// The model that weights and objective use.
    pub(crate) model: Box<Model>,
    /// What the networks of proposals are made from: the model's sizes, and its graph if it has one.
    pub(crate) shape: ModelShape,
    /// The system with Gaussian noise of the same moments.
    pub(crate) gaussian: Box<Model>,
    /// The Gaussian system by its equations, which a filter can look ahead by; none of an epidemic.
    pub(crate) equations: Option<DiffusionEquations>,
    /// What was drawn from the true system.
    pub(crate) trajectory: Trajectory,
    /// Exact inference in the filter's model, where it is linear and Gaussian.
    pub(crate) exact: Option<Exact>,
    /// Whether the noise of the system is Gaussian, so that the exact means are also those of the system itself.
    pub(crate) has_gaussian_noise: bool,
    /// What errors are taken of.
    pub(crate) judged: ErrorTarget,
}

/// What errors are taken of.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ErrorTarget {
    /// The state as a whole, as a share of its size.
    WholeState,
    /// Each coordinate by itself.
    EachState {
        /// How many trajectories ran away before the one that was kept.
        redrawn: usize,
    },
}

/// Exact inference by the Kalman filter.
pub(crate) struct Exact {
    /// `E[x_t | y_{0:t}]` at each time.
    pub(crate) means: Sequence,
    /// `E[x_t | y_{0:T−1}]` at each time, `T×N`.
    pub(crate) smoothed: Vec<f64>,
    /// `log p(y_{0:T−1})`.
    pub(crate) log_evidence: f64,
}

impl Problem {
    pub(crate) fn draw(unit: &UnitConfig) -> Result<Problem, ModelError> {
        match &unit.system {
            UnitSystem::Graph(system) => Problem::on_graph(unit, system),
            UnitSystem::Epidemic(epidemic) => Problem::epidemic(unit, epidemic),
        }
    }

    fn on_graph(unit: &UnitConfig, settings: &config::System) -> Result<Problem, ModelError> {
        let &config::System { drift, noise, densities, snr_db, neighbours, unmeasured, dimension, horizon } =
            settings;
        let measurement_dim = dimension - unmeasured;
        let settings =
            GraphDiffusionConfig { state_dim: dimension, measurement_dim, neighbours, snr_db, drift, noise };
        let seed = unit.system_seed();
        let system = GraphDiffusion::random(&settings, &mut unit.graph_seed().stream())?;
        let trajectory = simulate(&system, horizon, &mut seed.child("trajectory").stream())?;
        let gaussian = system.with_noise(Noise::Gaussian);
        let model = believed(densities, &system, &gaussian);
        let believes_gaussian = noise == Noise::Gaussian || densities == Densities::Gaussian;
        let exact = if drift == Drift::Identity && believes_gaussian {
            let filtered = kalman::filter(&model.moment_matched()?, &trajectory.measurements)?;
            let means = filtered.steps.iter().flat_map(|step| step.filtered.mean.iter().copied()).collect();
            let smoothed = kalman::smooth(&filtered)?.beliefs;
            let smoothed = smoothed.iter().flat_map(|belief| belief.mean.iter().copied()).collect();
            Some(Exact {
                means: Sequence::new(dimension, means)?,
                smoothed,
                log_evidence: filtered.log_evidence(),
            })
        } else {
            None
        };
        Ok(Problem {
            has_gaussian_noise: noise == Noise::Gaussian,
            equations: Some(DiffusionEquations::of(&gaussian, drift)),
            system: Box::new(system),
            shape: ModelShape::on_graph(&model),
            model: Box::new(model),
            gaussian: Box::new(gaussian),
            trajectory,
            exact,
            judged: ErrorTarget::WholeState,
        })
    }

    fn epidemic(unit: &UnitConfig, settings: &config::Epidemic) -> Result<Problem, ModelError> {
        let noise = settings.noise;
        let system = Epidemic::new(&EpidemicConfig {
            infection_rate: settings.infection_rate,
            removal_rate: settings.removal_rate,
            time_step: settings.time_step,
            initial_means: settings.initial_means,
            initial_variance: settings.initial_variance,
            state_variance: settings.state_variance,
            measurement_variance: settings.measurement_variance,
            noise,
        })?;
        let seed = unit.system_seed().child("trajectory");
        let (trajectory, redrawn) =
            simulate_within(&system, settings.horizon, settings.largest_state, &seed)?;
        let gaussian = system.with_noise(Noise::Gaussian);
        let model = believed(settings.densities, &system, &gaussian);
        Ok(Problem {
            equations: None,
            system: Box::new(system),
            shape: ModelShape::of(&model),
            model: Box::new(model),
            gaussian: Box::new(gaussian),
            trajectory,
            exact: None,
            has_gaussian_noise: noise == Noise::Gaussian,
            judged: ErrorTarget::EachState { redrawn },
        })
    }

    /// The Gaussian system by its equations.
    ///
    /// # Errors
    /// [`UnitError::Failed`] if it has none.
    pub(crate) fn equations(&self) -> Result<&DiffusionEquations, UnitError> {
        self.equations.as_ref().ok_or_else(|| failed("only a diffusion on a graph can be looked ahead of"))
    }

    /// The steps of the filter's model with their measurements.
    pub(crate) fn recorded(&self) -> Vec<RecordedStep> {
        let of_row = |(index, row): (usize, &[f64])| RecordedStep {
            step: StepRecord::of(&self.model.step_of_index(index)),
            measurement: row.iter().copied().map(Some).collect(),
        };
        self.trajectory.measurements.rows().enumerate().map(of_row).collect()
    }

    /// What estimates are held against: the exact posterior means where they exist, else the simulated states.
    pub(crate) fn truth(&self) -> &Sequence {
        match &self.exact {
            Some(exact) if self.has_gaussian_noise => &exact.means,
            _ => &self.trajectory.states,
        }
    }
}

/// The model that filters believe in.
fn believed<S: Clone>(densities: Densities, system: &S, gaussian: &S) -> S {
    match densities {
        Densities::Gaussian => gaussian.clone(),
        Densities::Exact => system.clone(),
    }
}
