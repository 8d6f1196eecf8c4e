//! Heads: what a network's outputs are the parameters of.
//!
//! A head is one file with one type that implements [`Head`], and one line in [`HeadConfig`].

mod flow;
mod gaussian;
mod mixture;
mod normal;
mod spline;

use motes_models::equations::Lanes;
use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

pub use flow::FlowHead;
pub use gaussian::GaussianHead;
pub use mixture::MixtureHead;

use crate::settings::check_count;

/// A density `h(u | θ)` on ℝᴺ whose parameters `θ` a network emits; `u` is the state in units of the base.
///
/// Numbers of 32 particles stand side by side in [`Lanes`]; a matrix has one of them for each entry.
pub trait Head: Send + Sync {
    /// How many numbers `θ` are.
    fn outputs(&self) -> usize;

    /// The `θ` that an untrained network emits (as many as [`Head::outputs`]).
    fn start(&self) -> Vec<f64>;

    /// How many uniform numbers a draw takes beside `N` normal ones.
    fn uniforms(&self) -> usize {
        0
    }

    /// Replaces standard normal numbers by a draw of `u` (`N`).
    fn draw(&self, theta: &[Lanes], uniforms: &[Lanes], normals: &mut [Lanes]);

    /// `log h(u | θ)`; `scratch` has [`Head::scratch`] entries.
    fn log_density(&self, theta: &[Lanes], u: &[Lanes], scratch: &mut [Lanes]) -> Lanes;

    /// The same, with `∂ log h / ∂θ` into `d_theta`.
    fn gradient(&self, theta: &[Lanes], u: &[Lanes], d_theta: &mut [Lanes], scratch: &mut [Lanes]) -> Lanes;

    /// How many entries of scratch a density takes.
    fn scratch(&self) -> usize;
}

/// A head and its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum HeadConfig {
    /// One Gaussian.
    Gaussian {
        /// The shape of its covariance.
        covariance: Covariance,
    },
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

/// The shape of a covariance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Covariance {
    /// Any, by its Cholesky factor: `N(N+1)/2` numbers.
    Full,
    /// Coordinates of `u` are independent: `N` numbers.
    Diagonal,
}

impl HeadConfig {
    /// The head for states of `n` coordinates.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] for a setting that no head can be made from.
    pub fn head(self, n: usize) -> Result<Box<dyn Head>, ProposalError> {
        Ok(match self {
            HeadConfig::Gaussian { covariance } => Box::new(GaussianHead::new(n, covariance)),
            HeadConfig::Mixture { components, covariance } => {
                check_count("the number of components of the mixture", components)?;
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
