//! What learning once maximises.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What learning once maximises.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LearnObjective {
    /// `E log q(x_t | x_{t−1}, y_t)` over steps that the model draws for itself; recorded series add steps of a filter.
    #[default]
    Inclusive,
    /// The same over the weighted particles of a running filter on recorded series alone (reweighted wake, Bornschein and Bengio 2015; neural adaptive
    /// sequential Monte Carlo, Gu, Ghahramani and Turner 2015): what is likely given the data at hand, rather than what the model likes to draw.
    Wake,
    /// The filter's own log-evidence on recorded series, `log Ẑ = Σ_t log Σ_k W_{t−1}^k w_t^k`, by reparametrised draws (filtering variational objectives,
    /// Maddison et al. 2017). Its gradient takes ancestors, weights and states of the time before as given; see [`learn`](crate::learn).
    Fivo,
}

impl LearnObjective {
    /// All of them; the first is the default.
    pub const ALL: [LearnObjective; 3] =
        [LearnObjective::Inclusive, LearnObjective::Wake, LearnObjective::Fivo];

    /// Whether it learns from recorded series alone, and is judged by the evidence of held-out ones.
    pub fn needs_recorded(self) -> bool {
        self != LearnObjective::Inclusive
    }

    pub(super) fn is_inclusive(&self) -> bool {
        *self == LearnObjective::Inclusive
    }
}

impl fmt::Display for LearnObjective {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            LearnObjective::Inclusive => "inclusive",
            LearnObjective::Wake => "wake",
            LearnObjective::Fivo => "fivo",
        })
    }
}
