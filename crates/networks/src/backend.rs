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
    /// burn's backend on Vulkan, Metal or DirectX (feature `wgpu`): graphics processors of any maker, or software that stands for one.
    Wgpu,
    /// burn's backend on CUDA (feature `cuda`).
    Cuda,
}

impl Backend {
    /// All of them; the first is the default.
    pub const ALL: [Backend; 5] =
        [Backend::Native, Backend::Flex, Backend::NdArray, Backend::Wgpu, Backend::Cuda];

    /// Those that compute on the host, and on every machine.
    pub const HOST: [Backend; 3] = [Backend::Native, Backend::Flex, Backend::NdArray];

    /// Those that this build has and that compute in a precision: the native one, and burn's with their features.
    pub fn built(precision: Precision) -> impl Iterator<Item = Backend> {
        Backend::ALL.into_iter().filter(move |backend| backend.check().is_ok() && backend.has(precision))
    }

    /// Whether it computes in a precision: few graphics processors know 64 bits.
    pub fn has(self, precision: Precision) -> bool {
        Backend::HOST.contains(&self) || precision == Precision::F32
    }

    /// The cargo feature of `motes-networks` that it needs.
    pub fn feature(self) -> Option<&'static str> {
        match self {
            Backend::Native => None,
            Backend::Flex | Backend::NdArray => Some("burn"),
            Backend::Wgpu => Some("wgpu"),
            Backend::Cuda => Some("cuda"),
        }
    }

    /// Refuses a backend that was not compiled.
    ///
    /// # Errors
    /// [`NetworkError::NotBuilt`] for one of burn's in a build without its feature.
    pub fn check(self) -> Result<(), NetworkError> {
        let is_built = match self {
            Backend::Native => true,
            Backend::Flex | Backend::NdArray => cfg!(feature = "burn"),
            Backend::Wgpu => cfg!(feature = "wgpu"),
            Backend::Cuda => cfg!(feature = "cuda"),
        };
        match self.feature() {
            Some(feature) if !is_built => Err(NetworkError::NotBuilt { backend: self.to_string(), feature }),
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
            Backend::Wgpu => "wgpu",
            Backend::Cuda => "cuda",
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
