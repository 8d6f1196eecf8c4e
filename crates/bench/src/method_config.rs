//! The method registry as units see it: what the result of a method depends on.

use motes_proposals::{Backend, FcnnConfig, GnnConfig, Origin, OverTime, PsiConfig, RnnConfig};
use serde::{Deserialize, Serialize};

use crate::config::{Densities, Experiment, Method, Plan, ShortSteps, Training};
use crate::learned_once::LearnedOnce;

/// A method with the settings that it depends on, and no others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MethodConfig {
    /// The designed proposal.
    MinDegeneracy,
    /// The transition.
    Bootstrap,
    /// The fully connected proposal.
    Fcnn(LearnedUnit<FcnnConfig>),
    /// The recurrent proposal.
    Rnn(LearnedUnit<RnnConfig>),
    /// The graph proposal.
    Gnn(LearnedUnit<GnnConfig>),
    /// The graph proposal, trained in shorter steps.
    GnnShortSteps(LearnedUnit<GnnConfig>),
    /// The transform of uniform noise.
    Psi(LearnedUnit<PsiConfig>),
    /// A Gaussian by one Fisher-scoring step.
    Linearised,
    /// A family that is learned once for a system.
    Once(Box<LearnedOnce>),
    /// Potentials of a smoother.
    LookAhead,
    /// Potentials that are learned once for a system.
    LookAheadLearned {
        /// Gradient steps.
        steps: usize,
    },
    /// The transition, under the densities that data were drawn with.
    ReferenceFilter,
    /// The same, with as many later measurements as this.
    ReferenceSmoother {
        /// How many.
        lag: usize,
    },
}

/// What the result of a learned proposal depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LearnedUnit<Config> {
    /// The family's settings and sizes.
    pub proposal: Config,
    /// How it is trained.
    pub training: Training,
    /// For how many steps.
    pub steps: usize,
    /// What computes its networks.
    pub backend: Backend,
    /// In which units they work; in those of the system if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameSettings>,
}

/// In which units networks work.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FrameSettings {
    /// What they speak relative to.
    pub origin: Origin,
    /// How many trajectories of the system are simulated.
    pub trajectories: usize,
    /// The largest size of a state in them: a trajectory that goes beyond is drawn again.
    pub largest_state: f64,
}

impl MethodConfig {
    /// The method of a plan's units, as the plan's files and profile set it; `None` if they do not say what it needs.
    pub(crate) fn of(method: Method, plan: &Plan, densities: Densities) -> Option<MethodConfig> {
        let is_family = method.is_learned() && !method.looks_ahead();
        if let Some(learning) = plan.experiment.learning.as_ref().filter(|_| is_family) {
            return LearnedOnce::of(method, plan, learning, densities)
                .map(|once| MethodConfig::Once(Box::new(once)));
        }
        let (settings, sizes) = (&plan.experiment.proposals, &plan.profile.sizes);
        Some(match method {
            Method::MinDegeneracy => MethodConfig::MinDegeneracy,
            Method::Bootstrap => MethodConfig::Bootstrap,
            Method::Linearised => MethodConfig::Linearised,
            Method::Fcnn | Method::FcnnAnchored => MethodConfig::Fcnn(LearnedUnit::of(
                plan,
                method,
                FcnnConfig {
                    widths: sizes.fcnn.clone(),
                    ridge: settings.fcnn.ridge,
                    networks: OverTime::EachTime,
                },
            )),
            Method::Rnn | Method::RnnAnchored => MethodConfig::Rnn(LearnedUnit::of(
                plan,
                method,
                RnnConfig {
                    cell: settings.rnn.cell,
                    hidden: sizes.rnn,
                    depth: settings.rnn.depth,
                    ridge: settings.rnn.ridge,
                },
            )),
            Method::Gnn => MethodConfig::Gnn(LearnedUnit::of(plan, method, graph_proposal(plan)?)),
            Method::GnnShortSteps => {
                let ShortSteps { learning_rate } = *settings.gnn_short_steps.as_ref()?;
                let gnn = LearnedUnit::of(plan, method, graph_proposal(plan)?);
                let training = Training { learning_rate, ..gnn.training };
                MethodConfig::GnnShortSteps(LearnedUnit { training, ..gnn })
            }
            Method::Psi | Method::PsiAnchored => MethodConfig::Psi(LearnedUnit::of(
                plan,
                method,
                PsiConfig { layers: sizes.psi, ridge: settings.psi.ridge, networks: OverTime::EachTime },
            )),
            Method::LookAhead => MethodConfig::LookAhead,
            Method::LookAheadLearned => {
                MethodConfig::LookAheadLearned { steps: plan.profile.potential_steps? }
            }
            Method::ReferenceFilter => MethodConfig::ReferenceFilter,
            Method::ReferenceSmoother => {
                MethodConfig::ReferenceSmoother { lag: plan.experiment.reference.as_ref()?.smoother_lag }
            }
        })
    }

    /// Which method this is.
    pub fn method(&self) -> Method {
        match self {
            MethodConfig::MinDegeneracy => Method::MinDegeneracy,
            MethodConfig::Bootstrap => Method::Bootstrap,
            MethodConfig::Linearised => Method::Linearised,
            MethodConfig::Once(once) => once.family.method(),
            MethodConfig::Fcnn(unit) => unit.anchored_or(Method::FcnnAnchored, Method::Fcnn),
            MethodConfig::Rnn(unit) => unit.anchored_or(Method::RnnAnchored, Method::Rnn),
            MethodConfig::Gnn(_) => Method::Gnn,
            MethodConfig::GnnShortSteps(_) => Method::GnnShortSteps,
            MethodConfig::Psi(unit) => unit.anchored_or(Method::PsiAnchored, Method::Psi),
            MethodConfig::LookAhead => Method::LookAhead,
            MethodConfig::LookAheadLearned { .. } => Method::LookAheadLearned,
            MethodConfig::ReferenceFilter => Method::ReferenceFilter,
            MethodConfig::ReferenceSmoother { .. } => Method::ReferenceSmoother,
        }
    }

    /// The number of training steps, if it is trained.
    pub(crate) fn steps_mut(&mut self) -> Option<&mut usize> {
        match self {
            MethodConfig::MinDegeneracy
            | MethodConfig::Bootstrap
            | MethodConfig::Linearised
            | MethodConfig::LookAhead
            | MethodConfig::ReferenceFilter
            | MethodConfig::ReferenceSmoother { .. } => None,
            MethodConfig::LookAheadLearned { steps } => Some(steps),
            MethodConfig::Once(once) => Some(&mut once.steps),
            MethodConfig::Fcnn(unit) => Some(&mut unit.steps),
            MethodConfig::Rnn(unit) => Some(&mut unit.steps),
            MethodConfig::Gnn(unit) | MethodConfig::GnnShortSteps(unit) => Some(&mut unit.steps),
            MethodConfig::Psi(unit) => Some(&mut unit.steps),
        }
    }
}

/// The graph proposal that a plan sets; `None` if it sets none.
fn graph_proposal(plan: &Plan) -> Option<GnnConfig> {
    let settings = plan.experiment.proposals.gnn.as_ref()?;
    Some(GnnConfig {
        features: plan.profile.sizes.gnn.clone()?,
        order: settings.order,
        adapter: settings.adapter,
        ridge: settings.ridge,
        networks: OverTime::EachTime,
    })
}

impl<Config: Clone> LearnedUnit<Config> {
    fn of(plan: &Plan, method: Method, proposal: Config) -> Self {
        let Experiment { training, proposals, epidemic, .. } = &plan.experiment;
        let frames = proposals.standardised.as_ref().zip(epidemic.as_ref()).map(|(settings, epidemic)| {
            let origin = if method.is_anchored() { Origin::Prediction } else { settings.origin };
            let (trajectories, largest_state) = (settings.trajectories, epidemic.largest_state);
            FrameSettings { origin, trajectories, largest_state }
        });
        let (training, steps, backend) = (training.clone(), plan.profile.training_steps, plan.backend);
        LearnedUnit { proposal, training, steps, backend, frames }
    }

    fn anchored_or(&self, anchored: Method, plain: Method) -> Method {
        match self.frames {
            Some(FrameSettings { origin: Origin::Prediction, .. }) => anchored,
            _ => plain,
        }
    }
}
