//! The experiment file: one TOML for a figure, every key known and typed.

use std::collections::BTreeMap;

use motes_models::{Drift, Noise};
use motes_smc::Resampling;
use motes_train::{Objective, Schedule};
use serde::{Deserialize, Serialize};

use super::densities::Densities;
use super::learning::Learning;
use super::method::Method;
use super::proposals::{Proposals, Sizes};

/// A whole file, `experiments/<figure>.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// What the figure shows.
    pub title: String,
    /// What its x axis varies.
    pub axis: Axis,
    /// What is estimated of each sequence.
    #[serde(default, skip_serializing_if = "Estimand::is_of_filters")]
    pub estimand: Estimand,
    /// The methods it compares, in the order of its legend.
    pub methods: Vec<Method>,
    /// Other names that the experiment goes by: a figure that shows the same runs as a table, say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<String>,
    /// The system, if it lives on a graph.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<System>,
    /// The system, if it is an epidemic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epidemic: Option<Epidemic>,
    /// The filter.
    pub filter: Filter,
    /// The filter and smoother with exact densities that others are held against, where they are among the methods.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// How proposals are trained.
    pub training: Training,
    /// How they are learned once instead, where they are judged on sequences that they never saw.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learning: Option<Learning>,
    /// Settings of the learned families.
    pub proposals: Proposals,
    /// The panels side by side; one named `all` where the figure has none.
    pub panels: Vec<Panel>,
    /// What the figure shows over time, where that is what it shows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub series: Option<SeriesFigure>,
    /// What the paper prints: by method, the value of each metric.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub printed: BTreeMap<Method, BTreeMap<String, f64>>,
    /// What smoke, quick and paper runs do.
    pub profiles: BTreeMap<String, Profile>,
}

impl Experiment {
    /// N and T, where neither a panel nor the x axis says otherwise; `None` if the file describes no system.
    pub(super) fn sizes(&self) -> Option<(usize, usize)> {
        let of_graph = self.system.as_ref().map(|system| (system.dimension, system.horizon));
        of_graph.or_else(|| self.epidemic.as_ref().map(|epidemic| (Epidemic::DIMENSION, epidemic.horizon)))
    }
}

/// What is estimated of a sequence of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimand {
    /// `E[x_t | y_{0:t}]`.
    #[default]
    Filtering,
    /// `E[x_t | y_{0:T−1}]` by the paths of the last particles, and `log p(y_{0:T−1})`.
    Smoothing,
}

impl Estimand {
    /// Whether it is what filters estimate as they go.
    pub(crate) fn is_of_filters(&self) -> bool {
        *self == Estimand::Filtering
    }
}

/// What the x axis varies; it overrides the fixed value of the same quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The number of particles, K.
    Particles,
    /// The length of the trajectory, T.
    Horizon,
    /// The number of state coordinates, N.
    Dimension,
}

impl Axis {
    /// The letter that it has in formulas.
    pub fn symbol(self) -> &'static str {
        match self {
            Axis::Particles => "K",
            Axis::Horizon => "T",
            Axis::Dimension => "N",
        }
    }
}

/// `x_t = φ(A x_{t−1}) + v_t`, `y_t = C x_t + w_t` on a random geometric graph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct System {
    /// φ.
    pub drift: Drift,
    /// The family of both noises that data are drawn with.
    pub noise: Noise,
    /// What the filter takes the noises to be.
    pub densities: Densities,
    /// Signal-to-noise ratio of both noises, in dB.
    pub snr_db: f64,
    /// Nearest others that a node is joined to.
    pub neighbours: usize,
    /// N − M, the number of coordinates that are not measured by themselves.
    pub unmeasured: usize,
    /// N; a panel or the x axis may say otherwise.
    pub dimension: usize,
    /// T; the x axis may say otherwise.
    pub horizon: usize,
}

/// Susceptible, infected and removed people, of which the first and the last are measured; every noise is centred.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Epidemic {
    /// β.
    pub infection_rate: f64,
    /// γ.
    pub removal_rate: f64,
    /// Δ, the step of Euler's method.
    pub time_step: f64,
    /// The means of S_0, I_0 and R_0.
    pub initial_means: [f64; Epidemic::DIMENSION],
    /// The variance of each of them.
    pub initial_variance: f64,
    /// The variance of the noise of each coordinate of the state.
    pub state_variance: f64,
    /// The variance of the noise of each measurement.
    pub measurement_variance: f64,
    /// The family of all noises that data are drawn with.
    pub noise: Noise,
    /// What the filter takes the noises to be.
    pub densities: Densities,
    /// T.
    pub horizon: usize,
    /// A trajectory in which a coordinate becomes larger than this, or smaller than its negative, is drawn again.
    pub largest_state: f64,
}

impl Epidemic {
    /// N.
    pub const DIMENSION: usize = Epidemic::STATES.len();

    /// Susceptible, infected and removed people.
    pub const STATES: [&str; 3] = ["S", "I", "R"];
}

/// What is held against all other methods, because none can tune it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// How many later measurements the smoother waits for.
    pub smoother_lag: usize,
}

/// A figure of estimates over time, those of the first repetition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeriesFigure {
    /// Which coordinate of the state.
    pub state: String,
    /// The first and the last time of each plot.
    pub windows: Vec<[usize; 2]>,
}

/// The particle filter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Filter {
    /// K; the x axis may say otherwise.
    pub particles: usize,
    /// How ancestors are drawn.
    pub resampling: Resampling,
    /// Resample when the effective sample size is below this fraction of K.
    pub ess_threshold: f64,
    /// Draw from a mixture with this share of the transition; from the proposal alone if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub defensive_weight: Option<f64>,
}

/// How proposals are trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Training {
    /// What is maximised.
    pub objective: Objective,
    /// How far back in time its gradient reaches.
    pub gradient: Gradient,
    /// Times in a window of a truncated gradient; absent for a full one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient_window: Option<usize>,
    /// The largest norm of the gradient; absent for no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_norm: Option<f64>,
    /// Adam's step size.
    pub learning_rate: f64,
    /// How it changes in the course of the training; absent where it does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schedule: Option<Schedule>,
    /// Adam's first forgetting factor.
    pub beta_1: f64,
    /// Adam's second forgetting factor.
    pub beta_2: f64,
    /// Adam's ε.
    pub epsilon: f64,
    /// The weight penalty; absent for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight_penalty: Option<f64>,
    /// The share of hidden units that a step leaves out; absent for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dropout: Option<f64>,
}

/// How far back in time a gradient reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gradient {
    /// To the first time.
    Full,
    /// To the beginning of its window.
    Truncated,
}

/// One of the plots side by side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// Its name on the command line and in files.
    pub name: String,
    /// N in this panel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dimension: Option<usize>,
    /// What the filter takes the noises to be in this panel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub densities: Option<Densities>,
}

/// How much of the experiment a run does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Values of the x axis.
    pub x: Vec<usize>,
    /// Panels by name; all if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub panels: Option<Vec<String>>,
    /// Repetitions, each with a new graph, trajectory and initial weights.
    pub repetitions: usize,
    /// Independent filters whose estimates are averaged.
    pub filter_runs: usize,
    /// Training steps.
    pub training_steps: usize,
    /// Gradient steps of the potentials that are learned once for a system, where a method needs them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub potential_steps: Option<usize>,
    /// Particles in each of the two reference filters that stand in for a posterior mean where there is no exact one, and in the
    /// filter and smoother with exact densities.
    pub reference_particles: usize,
    /// How large the networks are.
    pub sizes: Sizes,
}
