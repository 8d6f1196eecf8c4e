//! The methods that experiments compare: their names and what they are.

use serde::{Deserialize, Serialize};

/// A way of sampling particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The designed proposal p(x_t | x_{t−1}, y_t).
    MinDegeneracy,
    /// The transition p(x_t | x_{t−1}).
    Bootstrap,
    /// A Gaussian by one Fisher-scoring step from the predicted state.
    Linearised,
    /// The learned fully connected proposal.
    Fcnn,
    /// The learned recurrent proposal.
    Rnn,
    /// The learned graph proposal.
    Gnn,
    /// The learned graph proposal, trained in shorter steps.
    GnnShortSteps,
    /// The learned transform of uniform noise.
    Psi,
    /// The fully connected proposal around a linear prediction.
    FcnnAnchored,
    /// The recurrent proposal around a linear prediction.
    RnnAnchored,
    /// The transform of uniform noise around a linear prediction.
    PsiAnchored,
    /// The proposal that looks ahead by potentials of a smoother.
    LookAhead,
    /// The same by potentials that are learned once for a system.
    LookAheadLearned,
    /// The transition with very many particles and the densities that data were drawn with.
    ReferenceFilter,
    /// The same, with later measurements.
    ReferenceSmoother,
}

impl Method {
    /// The name on the command line, in files and in figures.
    pub fn name(self) -> &'static str {
        match self {
            Method::MinDegeneracy => "min-degeneracy",
            Method::Bootstrap => "bootstrap",
            Method::Linearised => "linearised",
            Method::Fcnn => "fcnn",
            Method::Rnn => "rnn",
            Method::Gnn => "gnn",
            Method::GnnShortSteps => "gnn-short-steps",
            Method::Psi => "psi",
            Method::FcnnAnchored => "fcnn-anchored",
            Method::RnnAnchored => "rnn-anchored",
            Method::PsiAnchored => "psi-anchored",
            Method::LookAhead => "look-ahead",
            Method::LookAheadLearned => "look-ahead-learned",
            Method::ReferenceFilter => "reference-filter",
            Method::ReferenceSmoother => "reference-smoother",
        }
    }

    /// Its colour in figures: colours that stay apart for colour-blind eyes (Okabe and Ito's), greys for designed proposals.
    pub fn colour(self) -> [u8; 3] {
        match self {
            Method::MinDegeneracy => [70, 70, 70],
            Method::Bootstrap => [160, 160, 160],
            Method::Linearised => [115, 95, 60],
            Method::Fcnn => [0, 114, 178],
            Method::Rnn => [213, 94, 0],
            Method::Gnn => [0, 158, 115],
            Method::Psi => [204, 121, 167],
            // Darker than the families that they are of.
            Method::GnnShortSteps => [0, 86, 62],
            Method::FcnnAnchored => [0, 62, 110],
            Method::RnnAnchored => [140, 52, 0],
            Method::PsiAnchored => [122, 52, 98],
            Method::LookAhead => [86, 180, 233],
            Method::LookAheadLearned => [230, 159, 0],
            Method::ReferenceFilter => [86, 180, 233],
            Method::ReferenceSmoother => [230, 159, 0],
        }
    }

    /// Whether it is trained.
    pub fn is_learned(self) -> bool {
        use Method::{
            Fcnn, FcnnAnchored, Gnn, GnnShortSteps, LookAheadLearned, Psi, PsiAnchored, Rnn, RnnAnchored,
        };
        matches!(
            self,
            Fcnn | Rnn
                | Gnn
                | GnnShortSteps
                | Psi
                | FcnnAnchored
                | RnnAnchored
                | PsiAnchored
                | LookAheadLearned
        )
    }

    /// Whether it needs a graph.
    pub(crate) fn is_on_graph(self) -> bool {
        matches!(self, Method::Gnn | Method::GnnShortSteps)
    }

    /// Whether it is a family around a linear prediction.
    pub fn is_anchored(self) -> bool {
        matches!(self, Method::FcnnAnchored | Method::RnnAnchored | Method::PsiAnchored)
    }

    /// Whether its weights say at each time what comes later, so that it estimates nothing of the filter's own times.
    pub fn looks_ahead(self) -> bool {
        matches!(self, Method::LookAhead | Method::LookAheadLearned)
    }

    /// Whether others are held against it.
    pub fn is_reference(self) -> bool {
        matches!(self, Method::ReferenceFilter | Method::ReferenceSmoother)
    }
}
