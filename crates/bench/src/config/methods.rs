//! The method registry as experiment files see it: names, settings shared by all profiles, and a profile's sizes.

use serde::{Deserialize, Serialize};

use super::ConfigError;
use super::check::Checks;

/// A way of sampling particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The designed proposal p(x_t | x_{t−1}, y_t).
    MinDegeneracy,
    /// The transition p(x_t | x_{t−1}).
    Bootstrap,
    /// The learned fully connected proposal.
    Fcnn,
    /// The learned recurrent proposal.
    Rnn,
    /// The learned graph proposal.
    Gnn,
    /// The learned transform of uniform noise.
    Psi,
    /// The fully connected proposal around a linear prediction.
    FcnnAnchored,
    /// The recurrent proposal around a linear prediction.
    RnnAnchored,
    /// The transform of uniform noise around a linear prediction.
    PsiAnchored,
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
            Method::Fcnn => "fcnn",
            Method::Rnn => "rnn",
            Method::Gnn => "gnn",
            Method::Psi => "psi",
            Method::FcnnAnchored => "fcnn-anchored",
            Method::RnnAnchored => "rnn-anchored",
            Method::PsiAnchored => "psi-anchored",
            Method::ReferenceFilter => "reference-filter",
            Method::ReferenceSmoother => "reference-smoother",
        }
    }

    /// Its colour in figures: colours that stay apart for colour-blind eyes (Okabe and Ito's), greys for designed proposals.
    pub fn colour(self) -> [u8; 3] {
        match self {
            Method::MinDegeneracy => [70, 70, 70],
            Method::Bootstrap => [160, 160, 160],
            Method::Fcnn => [0, 114, 178],
            Method::Rnn => [213, 94, 0],
            Method::Gnn => [0, 158, 115],
            Method::Psi => [204, 121, 167],
            // Darker than the families that they are of.
            Method::FcnnAnchored => [0, 62, 110],
            Method::RnnAnchored => [140, 52, 0],
            Method::PsiAnchored => [122, 52, 98],
            Method::ReferenceFilter => [86, 180, 233],
            Method::ReferenceSmoother => [230, 159, 0],
        }
    }

    /// Whether it is trained.
    pub fn is_learned(self) -> bool {
        use Method::{Fcnn, FcnnAnchored, Gnn, Psi, PsiAnchored, Rnn, RnnAnchored};
        matches!(self, Fcnn | Rnn | Gnn | Psi | FcnnAnchored | RnnAnchored | PsiAnchored)
    }

    /// Whether it is a family around a linear prediction.
    pub fn is_anchored(self) -> bool {
        matches!(self, Method::FcnnAnchored | Method::RnnAnchored | Method::PsiAnchored)
    }

    /// Whether others are held against it.
    pub fn is_reference(self) -> bool {
        matches!(self, Method::ReferenceFilter | Method::ReferenceSmoother)
    }
}

/// `[proposals]`: settings of the learned families that all profiles share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Proposals {
    /// The fully connected proposal.
    pub fcnn: Fcnn,
    /// The recurrent proposal.
    pub rnn: Rnn,
    /// The graph proposal, where there is a graph.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gnn: Option<Gnn>,
    /// The transform of uniform noise.
    pub psi: Psi,
    /// In which units networks work; in those of the system if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standardised: Option<Standardised>,
}

/// Networks in the units of simulated trajectories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Standardised {
    /// What the outputs of `fcnn`, `rnn` and `psi` are counted from.
    pub origin: Origin,
    /// How many trajectories of the system are simulated.
    pub trajectories: usize,
}

/// What the outputs of networks are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The mean over trajectories and times.
    Mean,
    /// The mean over trajectories, at each time.
    MeanAtEachTime,
}

/// Settings of the fully connected proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fcnn {
    /// Added to the diagonal of the covariance.
    pub ridge: f64,
}

/// Settings of the recurrent proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rnn {
    /// What a layer computes.
    pub cell: Cell,
    /// Layers on top of each other.
    pub depth: usize,
    /// Added to the diagonal of the covariance.
    pub ridge: f64,
}

/// What a recurrent layer computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cell {
    /// Long short-term memory.
    Lstm,
    /// Gated recurrent unit.
    Gru,
    /// One affine map and tanh.
    Elman,
}

/// Settings of the graph proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gnn {
    /// D: filters have D + 1 taps.
    pub order: usize,
    /// How measurements are brought to the nodes.
    pub adapter: Adapter,
    /// Added to the diagonal of the covariance.
    pub ridge: f64,
}

/// How measurements are brought to the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Adapter {
    /// By the transposed measurement matrix, rescaled to ones.
    Fixed,
    /// By learned matrices.
    Learned,
}

/// Settings of the transform of uniform noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Psi {
    /// Added to the diagonal of each matrix that is inverted.
    pub ridge: f64,
}

/// `[profiles.*.sizes]`: how large the networks of a profile are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sizes {
    /// Hidden widths of the fully connected proposal.
    pub fcnn: Vec<usize>,
    /// Hidden units of the recurrent proposal.
    pub rnn: usize,
    /// Features of the graph proposal, where there is a graph.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gnn: Option<Vec<usize>>,
    /// Square layers of the transform.
    pub psi: usize,
}

/// The largest width of a layer.
const LARGEST: usize = 65_536;

impl Proposals {
    pub(super) fn check(&self, checks: &Checks<'_>) -> Result<(), ConfigError> {
        let Proposals { fcnn, rnn, gnn, psi, standardised } = self;
        let ridges = [("fcnn", fcnn.ridge), ("rnn", rnn.ridge), ("psi", psi.ridge)];
        for (family, ridge) in ridges.into_iter().chain(gnn.iter().map(|gnn| ("gnn", gnn.ridge))) {
            let fine = ridge >= 0.0 && ridge.is_finite();
            let key = format!("proposals.{family}.ridge");
            checks.that(fine, &key, ridge, "it must be at least 0 and finite")?;
        }
        checks.within("proposals.rnn.depth", rnn.depth, 1, 64)?;
        if let Some(gnn) = gnn {
            checks.within("proposals.gnn.order", gnn.order, 0, 64)?;
        }
        if let Some(standardised) = standardised {
            let key = "proposals.standardised.trajectories";
            checks.within(key, standardised.trajectories, 1, 100_000)?;
        }
        Ok(())
    }
}

impl Sizes {
    pub(super) fn check(&self, profile: &str, checks: &Checks<'_>) -> Result<(), ConfigError> {
        let key = |family: &str| format!("profiles.{profile}.sizes.{family}");
        let gnn = self.gnn.iter().map(|widths| ("gnn", widths));
        for (family, widths) in [("fcnn", &self.fcnn)].into_iter().chain(gnn) {
            let fine = !widths.is_empty() && widths.iter().all(|width| (1..=LARGEST).contains(width));
            let expected = "it must be one or more widths from 1 to 65536";
            checks.that(fine, &key(family), format!("{widths:?}"), expected)?;
        }
        checks.within(&key("rnn"), self.rnn, 1, LARGEST)?;
        checks.within(&key("psi"), self.psi, 1, 1024)
    }
}
