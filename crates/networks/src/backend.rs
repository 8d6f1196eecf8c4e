//! What networks are computed by, and in which precision.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::NetworkError;
use crate::precision::Precision;

/// What computes the networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// Our own: whole layers at a time, on the host. Several times faster than the others, and held against them by tests.
    #[default]
    Native,
    /// burn's CPU backend (feature `burn`) with burn's automatic differentiation: plain, and maintained. As a second opinion it need not be
    /// fast: inference converts all weights at each block of particles.
    Flex,
    /// burn's backend on top of `ndarray` (feature `burn`), deprecated upstream: kept as an independent second opinion.
    NdArray,
}

impl Backend {
    /// All of them; the first is the default.
    pub const ALL: [Backend; 3] = [Backend::Native, Backend::Flex, Backend::NdArray];

    /// Those that this build has: the native one, and burn's with the feature `burn`.
    pub fn built() -> impl Iterator<Item = Backend> {
        Backend::ALL.into_iter().filter(|backend| backend.check().is_ok())
    }

    /// Refuses a backend that was not compiled.
    ///
    /// # Errors
    /// [`NetworkError::NotBuilt`] for one of burn's in a build without the feature `burn`.
    pub fn check(self) -> Result<(), NetworkError> {
        match self {
            Backend::Flex | Backend::NdArray if !cfg!(feature = "burn") => {
                Err(NetworkError::NotBuilt { backend: self.to_string() })
            }
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Backend::Native => "native",
            Backend::Flex => "flex",
            Backend::NdArray => "ndarray",
        })
    }
}

/// A backend together with a precision: all that a network needs to know of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Compute {
    /// What computes.
    pub backend: Backend,
    /// In which precision.
    pub precision: Precision,
}

impl From<Backend> for Compute {
    fn from(backend: Backend) -> Self {
        Compute { backend, precision: Precision::F32 }
    }
}
