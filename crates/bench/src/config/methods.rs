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
        }
    }

    /// Whether it is trained.
    pub fn is_learned(self) -> bool {
        !matches!(self, Method::MinDegeneracy | Method::Bootstrap)
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
    /// The graph proposal.
    pub gnn: Gnn,
    /// The transform of uniform noise.
    pub psi: Psi,
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
    /// Features of the graph proposal.
    pub gnn: Vec<usize>,
    /// Square layers of the transform.
    pub psi: usize,
}

/// The largest width of a layer.
const LARGEST: usize = 65_536;

impl Proposals {
    pub(super) fn check(&self, checks: &Checks<'_>) -> Result<(), ConfigError> {
        let Proposals { fcnn, rnn, gnn, psi } = self;
        for (family, ridge) in
            [("fcnn", fcnn.ridge), ("rnn", rnn.ridge), ("gnn", gnn.ridge), ("psi", psi.ridge)]
        {
            let fine = ridge >= 0.0 && ridge.is_finite();
            let key = format!("proposals.{family}.ridge");
            checks.that(fine, &key, ridge, "it must be at least 0 and finite")?;
        }
        checks.within("proposals.rnn.depth", rnn.depth, 1, 64)?;
        checks.within("proposals.gnn.order", gnn.order, 0, 64)
    }
}

impl Sizes {
    pub(super) fn check(&self, profile: &str, checks: &Checks<'_>) -> Result<(), ConfigError> {
        let key = |family: &str| format!("profiles.{profile}.sizes.{family}");
        for (family, widths) in [("fcnn", &self.fcnn), ("gnn", &self.gnn)] {
            let fine = !widths.is_empty() && widths.iter().all(|width| (1..=LARGEST).contains(width));
            let expected = "it must be one or more widths from 1 to 65536";
            checks.that(fine, &key(family), format!("{widths:?}"), expected)?;
        }
        checks.within(&key("rnn"), self.rnn, 1, LARGEST)?;
        checks.within(&key("psi"), self.psi, 1, 1024)
    }
}
