//! What a proposal depends on that is learned once for a system.

use motes_proposals::{AmortisedConfig, Backend, OverTime, PsiConfig, RnnConfig, Sees};
use serde::{Deserialize, Serialize};

use crate::config::{Densities, Learning, Method, Plan, Training};

/// A family with all that its learning depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LearnedOnce {
    /// The family's settings and sizes.
    pub family: OnceFamily,
    /// How it is learned.
    pub learning: Learning,
    /// For how many steps.
    pub steps: usize,
    /// What computes its networks.
    pub backend: Backend,
}

/// The families of the paper, in the form in which each is learned once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OnceFamily {
    /// Fully connected hidden layers around a designed proposal.
    Fcnn(AmortisedConfig),
    /// Hidden layers along the system's graph around a designed proposal.
    Gnn(AmortisedConfig),
    /// The recurrent proposal, which serves all times as it is.
    Rnn(RnnConfig, Training),
    /// The transform of uniform noise, shared over time.
    Psi(PsiConfig, Training),
}

impl OnceFamily {
    pub(crate) fn method(&self) -> Method {
        match self {
            OnceFamily::Fcnn(_) => Method::Fcnn,
            OnceFamily::Gnn(_) => Method::Gnn,
            OnceFamily::Rnn(..) => Method::Rnn,
            OnceFamily::Psi(..) => Method::Psi,
        }
    }
}

impl LearnedOnce {
    /// As a plan's files and profile set it; `None` if they do not say what it needs, or if the method has no such form.
    pub(crate) fn of(
        method: Method,
        plan: &Plan,
        learning: &Learning,
        densities: Densities,
    ) -> Option<LearnedOnce> {
        let (settings, sizes) = (&plan.experiment.proposals, &plan.profile.sizes);
        let around = |widths: &[usize], sees| AmortisedConfig {
            widths: widths.to_vec(),
            sees,
            base: learning.base,
            head: learning.head(densities),
            sub_steps: 1,
        };
        let training = || plan.experiment.training.clone();
        let family = match method {
            Method::Fcnn => OnceFamily::Fcnn(around(&sizes.fcnn, Sees::All)),
            Method::Gnn => {
                let order = settings.gnn.as_ref()?.order;
                OnceFamily::Gnn(around(sizes.gnn.as_deref()?, Sees::Graph { order }))
            }
            Method::Rnn => OnceFamily::Rnn(
                RnnConfig {
                    cell: settings.rnn.cell,
                    hidden: sizes.rnn,
                    depth: settings.rnn.depth,
                    ridge: settings.rnn.ridge,
                },
                training(),
            ),
            Method::Psi => OnceFamily::Psi(
                PsiConfig { layers: sizes.psi, ridge: settings.psi.ridge, networks: OverTime::Shared },
                training(),
            ),
            _ => return None,
        };
        let steps = plan.profile.training_steps;
        // The family has its head. What is left of the other one would make two of what is the same.
        let learning = Learning { head: learning.head(densities), exact_head: None, ..learning.clone() };
        Some(LearnedOnce { family, learning, steps, backend: plan.backend })
    }
}
