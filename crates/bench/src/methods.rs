//! The method registry as units see it: what the result of a method depends on, and how it is run.

use motes_models::GraphDiffusion;
use motes_proposals::{
    Adapter, Cell, Family, Fcnn, FcnnConfig, Gnn, GnnConfig, Psi, PsiConfig, Rnn, RnnConfig,
};
use motes_smc::{Bootstrap, MinDegeneracy, Proposal};
use serde::{Deserialize, Serialize};

use crate::config::{self, Backend, Method, Plan, Training};
use crate::evaluate::{UnitError, failed};

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
    /// The transform of uniform noise.
    Psi(LearnedUnit<PsiConfig>),
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
}

/// What a unit does with the proposal of its method.
pub(crate) trait Visitor {
    type Output;

    /// A proposal that is ready for use.
    fn designed(self, proposal: impl Proposal<GraphDiffusion>) -> Result<Self::Output, UnitError>;

    /// A family that is to be trained first.
    fn learned<F: Family + Proposal<GraphDiffusion>>(
        self,
        unit: &LearnedUnit<F::Config>,
    ) -> Result<Self::Output, UnitError>;
}

impl MethodConfig {
    /// The method of a plan's units, as the plan's files and profile set it.
    pub(crate) fn of(method: Method, plan: &Plan) -> MethodConfig {
        let (settings, sizes) = (&plan.experiment.proposals, &plan.profile.sizes);
        match method {
            Method::MinDegeneracy => MethodConfig::MinDegeneracy,
            Method::Bootstrap => MethodConfig::Bootstrap,
            Method::Fcnn => MethodConfig::Fcnn(LearnedUnit::of(
                plan,
                FcnnConfig { widths: sizes.fcnn.clone(), ridge: settings.fcnn.ridge },
            )),
            Method::Rnn => MethodConfig::Rnn(LearnedUnit::of(
                plan,
                RnnConfig {
                    cell: match settings.rnn.cell {
                        config::Cell::Lstm => Cell::Lstm,
                        config::Cell::Gru => Cell::Gru,
                        config::Cell::Elman => Cell::Elman,
                    },
                    hidden: sizes.rnn,
                    depth: settings.rnn.depth,
                    ridge: settings.rnn.ridge,
                },
            )),
            Method::Gnn => MethodConfig::Gnn(LearnedUnit::of(
                plan,
                GnnConfig {
                    features: sizes.gnn.clone(),
                    order: settings.gnn.order,
                    adapter: match settings.gnn.adapter {
                        config::Adapter::Fixed => Adapter::Fixed,
                        config::Adapter::Learned => Adapter::Learned,
                    },
                    ridge: settings.gnn.ridge,
                },
            )),
            Method::Psi => MethodConfig::Psi(LearnedUnit::of(
                plan,
                PsiConfig { layers: sizes.psi, ridge: settings.psi.ridge },
            )),
        }
    }

    /// Which method this is.
    pub fn method(&self) -> Method {
        match self {
            MethodConfig::MinDegeneracy => Method::MinDegeneracy,
            MethodConfig::Bootstrap => Method::Bootstrap,
            MethodConfig::Fcnn(_) => Method::Fcnn,
            MethodConfig::Rnn(_) => Method::Rnn,
            MethodConfig::Gnn(_) => Method::Gnn,
            MethodConfig::Psi(_) => Method::Psi,
        }
    }

    /// The number of training steps, if it is trained.
    pub(crate) fn steps_mut(&mut self) -> Option<&mut usize> {
        match self {
            MethodConfig::MinDegeneracy | MethodConfig::Bootstrap => None,
            MethodConfig::Fcnn(unit) => Some(&mut unit.steps),
            MethodConfig::Rnn(unit) => Some(&mut unit.steps),
            MethodConfig::Gnn(unit) => Some(&mut unit.steps),
            MethodConfig::Psi(unit) => Some(&mut unit.steps),
        }
    }

    /// Hands the method's proposal to `visitor`.
    pub(crate) fn visit<V: Visitor>(
        &self,
        model: &GraphDiffusion,
        visitor: V,
    ) -> Result<V::Output, UnitError> {
        match self {
            MethodConfig::MinDegeneracy => visitor.designed(MinDegeneracy::new(model).map_err(failed)?),
            MethodConfig::Bootstrap => visitor.designed(Bootstrap),
            MethodConfig::Fcnn(unit) => visitor.learned::<Fcnn>(unit),
            MethodConfig::Rnn(unit) => visitor.learned::<Rnn>(unit),
            MethodConfig::Gnn(unit) => visitor.learned::<Gnn>(unit),
            MethodConfig::Psi(unit) => visitor.learned::<Psi>(unit),
        }
    }
}

impl<Config> LearnedUnit<Config> {
    fn of(plan: &Plan, proposal: Config) -> Self {
        LearnedUnit {
            proposal,
            training: plan.experiment.training.clone(),
            steps: plan.profile.training_steps,
            backend: plan.backend,
        }
    }
}
