//! A unit of work: all that determines its result, and the key that this hashes to.

use motes_models::{Drift, Noise, Seed};
use serde::{Deserialize, Serialize};

use crate::config::{Densities, Epidemic, Estimand, Filter, Method, Plan, Point, System};
use crate::key::key_of;
use crate::method_config::MethodConfig;

/// The newest version of what a unit's configuration means; each method has the one since which it means what it means.
pub const UNIT_FORMAT: u32 = 6;

/// Independent runs of a reference filter, which tell how precise it is.
pub(crate) const REFERENCE_RUNS: usize = 2;

/// The version since which a method's configuration means what it means. Raised by hand, to one above [`UNIT_FORMAT`], whenever the same
/// configuration gives other numbers than before, so that old units are never taken for new ones; not for what no unit was ever stored of.
fn format_of(method: Method) -> u32 {
    match method {
        Method::MinDegeneracy | Method::Bootstrap | Method::Fcnn | Method::Rnn | Method::Psi => 4,
        Method::Linearised
        | Method::FcnnAnchored
        | Method::RnnAnchored
        | Method::PsiAnchored
        | Method::ReferenceFilter
        | Method::ReferenceSmoother => 5,
        // Sums of graph filters in another order.
        Method::Gnn | Method::GnnShortSteps | Method::LookAhead | Method::LookAheadLearned => 6,
    }
}

/// Everything that a unit's result depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnitConfig {
    /// The version of what it means.
    pub format: u32,
    /// The seed of the run.
    pub seed: u64,
    /// The repetition: which graph, trajectory and initial weights; of proposals that are learned once, which sequence.
    pub repetition: usize,
    /// Whether repetitions are sequences of one system, none of which was learned from.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held_out: bool,
    /// The system, with this unit's own N and T.
    pub system: UnitSystem,
    /// The filter, with this unit's own K.
    pub filter: Filter,
    /// Independent filters.
    pub filter_runs: usize,
    /// What is estimated of the sequence.
    #[serde(default, skip_serializing_if = "Estimand::is_of_filters")]
    pub estimand: Estimand,
    /// Particles of the reference filters, where posterior means are not exact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_particles: Option<usize>,
    /// The method with its settings.
    pub method: MethodConfig,
}

/// The system of a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum UnitSystem {
    /// On a graph.
    Graph(System),
    /// An epidemic.
    Epidemic(Epidemic),
}

impl UnitSystem {
    /// N.
    pub fn dimension(&self) -> usize {
        match self {
            UnitSystem::Graph(system) => system.dimension,
            UnitSystem::Epidemic(_) => Epidemic::DIMENSION,
        }
    }

    /// T.
    pub fn horizon(&self) -> usize {
        match self {
            UnitSystem::Graph(system) => system.horizon,
            UnitSystem::Epidemic(epidemic) => epidemic.horizon,
        }
    }

    /// What its filters take the noises to be.
    pub(crate) fn densities(&self) -> Densities {
        match self {
            UnitSystem::Graph(system) => system.densities,
            UnitSystem::Epidemic(epidemic) => epidemic.densities,
        }
    }

    /// Makes it last for another T.
    pub(crate) fn set_horizon(&mut self, horizon: usize) {
        match self {
            UnitSystem::Graph(system) => system.horizon = horizon,
            UnitSystem::Epidemic(epidemic) => epidemic.horizon = horizon,
        }
    }

    /// Whether an estimate is held against a posterior mean that has to be estimated by filters.
    fn has_estimated_means(&self) -> bool {
        match self {
            UnitSystem::Graph(system) => system.drift != Drift::Identity || system.noise != Noise::Gaussian,
            UnitSystem::Epidemic(_) => false,
        }
    }
}

impl UnitConfig {
    /// The unit at a point of a plan's figure; `None` if the figure has no such panel.
    pub fn at(plan: &Plan, point: &Point) -> Option<UnitConfig> {
        let (n, t, k) = plan.sizes(&point.panel, point.x)?;
        let (experiment, profile) = (&plan.experiment, &plan.profile);
        let system = match (&experiment.system, &experiment.epidemic) {
            (Some(system), _) => UnitSystem::Graph(System {
                dimension: n,
                horizon: t,
                densities: plan.densities(&point.panel).unwrap_or(system.densities),
                ..system.clone()
            }),
            (None, Some(epidemic)) => UnitSystem::Epidemic(Epidemic {
                densities: plan.densities(&point.panel).unwrap_or(epidemic.densities),
                ..epidemic.clone()
            }),
            (None, None) => return None,
        };
        // What others are held against does not depend on how many particles they have.
        let (particles, filter_runs) = match point.method.is_reference() {
            true => (profile.reference_particles, REFERENCE_RUNS),
            false => (k, profile.filter_runs),
        };
        Some(UnitConfig {
            format: format_of(point.method),
            seed: plan.seed,
            repetition: point.repetition,
            reference_particles: system.has_estimated_means().then_some(profile.reference_particles),
            filter: Filter { particles, ..experiment.filter.clone() },
            filter_runs,
            estimand: experiment.estimand,
            held_out: experiment.learning.is_some(),
            method: MethodConfig::of(point.method, plan, system.densities())?,
            system,
        })
    }

    /// The unit's key: 32 hexadecimal digits of the BLAKE3 hash of this configuration as JSON.
    pub fn key(&self) -> String {
        key_of(self)
    }

    /// The streams of the system and its trajectory: the same for every method and every K, so that repetitions are paired.
    ///
    /// T is left out too: a longer trajectory begins with the shorter one.
    pub fn system_seed(&self) -> Seed {
        self.systems_seed().nth(self.repetition as u64)
    }

    /// Where the graph comes from: of each repetition another, or the same of all where proposals are learned once.
    pub(crate) fn graph_seed(&self) -> Seed {
        let seed = if self.held_out { self.systems_seed() } else { self.system_seed() };
        seed.child("graph")
    }

    /// The streams of what has to do with systems of this size.
    fn systems_seed(&self) -> Seed {
        let label = if self.held_out { "held-out" } else { "system" };
        Seed::from_u64(self.seed).child(label).nth(self.system.dimension() as u64)
    }

    /// All that a proposal depends on that is learned once, and the streams that learning draws from; none for other methods.
    ///
    /// Neither K nor T nor the repetition is part of it: all of these units have one proposal.
    pub(crate) fn learned_once(&self) -> Option<(String, Seed)> {
        let MethodConfig::Once(method) = &self.method else { return None };
        let mut system = self.system.clone();
        system.set_horizon(0);
        // Under Gaussian densities what data are drawn with is of no account: the model of the filters is learned from.
        if let (UnitSystem::Graph(system), Densities::Gaussian) = (&mut system, self.system.densities()) {
            system.noise = Noise::Gaussian;
        }
        let key = key_of(&(self.format, self.seed, &system, method));
        Some((key, self.systems_seed().child("learned once").child(self.method.method().name())))
    }

    /// All that potentials depend on that are learned once for a system, and the streams that learning draws from; none for other methods. All K have the same.
    pub(crate) fn learned_potentials(&self) -> Option<(String, Seed)> {
        let MethodConfig::LookAheadLearned { .. } = &self.method else { return None };
        let key =
            key_of(&(self.format, self.seed, self.held_out, self.repetition, &self.system, &self.method));
        Some((key, self.system_seed().child("learned potentials")))
    }

    /// What the posterior means depend on that estimates are held against, where they have to be estimated.
    pub(crate) fn reference_key(&self) -> Option<String> {
        let particles = self.reference_particles?;
        Some(key_of(&(self.seed, self.held_out, self.repetition, &self.system, particles, self.estimand)))
    }

    /// The streams of this unit alone: initial weights, training noise, filters.
    pub fn own_seed(&self) -> Seed {
        let UnitConfig { system, filter, .. } = self;
        [system.dimension(), system.horizon(), filter.particles, self.repetition].into_iter().fold(
            Seed::from_u64(self.seed).child("unit").child(self.method.method().name()),
            |seed, index| seed.nth(index as u64),
        )
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::config::{Gradient, Training};
    use crate::method_config::LearnedUnit;
    use motes_proposals::{Backend, FcnnConfig};
    use motes_smc::Resampling;
    use motes_train::Objective;

    #[test]
    fn the_newest_format_is_some_methods() {
        let all =
            [Method::MinDegeneracy, Method::Bootstrap, Method::Fcnn, Method::Rnn, Method::Gnn, Method::Psi];
        assert_eq!(all.map(format_of).into_iter().max(), Some(UNIT_FORMAT));
    }

    /// A bootstrap unit of the linear Gaussian system.
    pub(crate) fn unit(dimension: usize, horizon: usize, particles: usize) -> UnitConfig {
        UnitConfig {
            format: format_of(Method::Bootstrap),
            seed: 1,
            repetition: 0,
            system: UnitSystem::Graph(System {
                drift: Drift::Identity,
                noise: Noise::Gaussian,
                densities: Densities::Gaussian,
                snr_db: 5.0,
                neighbours: 3,
                unmeasured: 2,
                dimension,
                horizon,
            }),
            filter: Filter {
                particles,
                resampling: Resampling::Multinomial,
                ess_threshold: 1.0 / 3.0,
                defensive_weight: None,
            },
            filter_runs: 3,
            reference_particles: None,
            estimand: Estimand::Filtering,
            held_out: false,
            method: MethodConfig::Bootstrap,
        }
    }

    /// The settings of a unit's system, to be changed.
    pub(crate) fn on_graph(unit: &mut UnitConfig) -> &mut System {
        match &mut unit.system {
            UnitSystem::Graph(system) => system,
            UnitSystem::Epidemic(_) => panic!("the unit is not on a graph"),
        }
    }

    /// A small fully connected unit of the same system.
    pub(crate) fn fcnn_unit(dimension: usize, horizon: usize, particles: usize) -> UnitConfig {
        let training = Training {
            objective: Objective::LogLikelihood,
            gradient: Gradient::Full,
            gradient_window: None,
            clip_norm: None,
            learning_rate: 1e-3,
            schedule: None,
            beta_1: 0.9,
            beta_2: 0.999,
            epsilon: 1e-8,
            weight_penalty: None,
            dropout: None,
        };
        let proposal = FcnnConfig { widths: vec![8, 8], ..FcnnConfig::paper() };
        let fcnn = LearnedUnit { proposal, training, steps: 5, backend: Backend::Native, frames: None };
        UnitConfig { method: MethodConfig::Fcnn(fcnn), ..unit(dimension, horizon, particles) }
    }

    #[test]
    fn the_key_changes_with_everything_that_determines_the_result() {
        let base = unit(10, 12, 20);
        let change = |change: fn(&mut UnitConfig)| {
            let mut unit = base.clone();
            change(&mut unit);
            unit.key()
        };
        let keys = [
            base.key(),
            change(|unit| unit.format += 1),
            change(|unit| unit.seed = 2),
            change(|unit| unit.repetition = 1),
            change(|unit| on_graph(unit).snr_db = 6.0),
            change(|unit| unit.filter.ess_threshold = 0.5),
            change(|unit| unit.filter.defensive_weight = Some(0.2)),
            change(|unit| unit.filter_runs = 4),
            change(|unit| unit.reference_particles = Some(100)),
            change(|unit| unit.method = MethodConfig::MinDegeneracy),
        ];
        for (at, key) in keys.iter().enumerate() {
            assert_eq!(key.len(), 32);
            assert!(!keys[..at].contains(key), "the key of change {at} is not new");
        }
    }

    #[test]
    fn repetitions_are_paired_over_methods_and_particles() {
        let base = unit(10, 12, 20);
        let other = UnitConfig { method: MethodConfig::MinDegeneracy, ..unit(10, 12, 50) };
        assert_eq!(base.system_seed(), other.system_seed());
        assert_ne!(base.own_seed(), other.own_seed());
        assert_ne!(base.system_seed(), UnitConfig { repetition: 1, ..base.clone() }.system_seed());
    }
}
