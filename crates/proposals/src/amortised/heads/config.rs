//! Heads by their settings.

use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use super::covariance::Covariance;
use super::flow::FlowHead;
use super::gaussian::GaussianHead;
use super::head::Head;
use super::kernel::KernelHead;
use super::mixture::MixtureHead;
use crate::settings::check_count;

/// A head and its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum HeadConfig {
    /// One Gaussian.
    Gaussian {
        /// The shape of its covariance.
        covariance: Covariance,
    },
    /// One Gaussian with the covariance of the paper: a kernel of a representation, mixed by a matrix.
    Kernel,
    /// Several Gaussians.
    Mixture {
        /// How many.
        components: usize,
        /// The shape of their covariances.
        covariance: Covariance,
    },
    /// A Gaussian bent by a monotone spline along each of its axes: one that can be skewed, or have several modes along each.
    Flow {
        /// Of how many pieces a spline is made.
        pieces: usize,
        /// The shape of the Gaussian's covariance.
        covariance: Covariance,
    },
}

impl HeadConfig {
    /// The head for states of `n` coordinates.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] for a setting that no head can be made from.
    pub fn head(self, n: usize) -> Result<Box<dyn Head>, ProposalError> {
        Ok(match self {
            HeadConfig::Gaussian { covariance } => Box::new(GaussianHead::new(n, covariance)),
            HeadConfig::Kernel => Box::new(KernelHead::new(n)),
            HeadConfig::Mixture { components, covariance } => {
                check_count("the number of components of the mixture", components)?;
                if covariance == Covariance::Shared {
                    return Err(ProposalError::Setting {
                        name: "the covariance of a mixture's components",
                        value: "shared".into(),
                        expected: "full or diagonal: one that all particles share is for a gaussian or a flow",
                    });
                }
                Box::new(MixtureHead::new(n, components, covariance))
            }
            HeadConfig::Flow { pieces, covariance } => {
                if !(2..=MOST_PIECES).contains(&pieces) {
                    return Err(ProposalError::Setting {
                        name: "the number of pieces of the flow's splines",
                        value: pieces.to_string(),
                        expected: "from 2 to 100",
                    });
                }
                Box::new(FlowHead::new(n, pieces, covariance))
            }
        })
    }
}

/// More pieces would each be narrower than the least share allows.
const MOST_PIECES: usize = 100;
