//! What networks are computed by, and in which precision.

use serde::{Deserialize, Serialize};

/// What computes the networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// Our own: whole layers at a time, on the host. Several times faster than the others, and held against them by tests.
    #[default]
    Native,
    /// burn's CPU backend with burn's automatic differentiation: plain, and maintained.
    Flex,
    /// The backend on top of `ndarray`, deprecated upstream: kept as an independent second opinion.
    NdArray,
}

impl Backend {
    /// All of them; the first is the default.
    pub const ALL: [Backend; 3] = [Backend::Native, Backend::Flex, Backend::NdArray];

    /// The name on command lines and in files.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Native => "native",
            Backend::Flex => "flex",
            Backend::NdArray => "ndarray",
        }
    }
}

/// The floating-point type of network weights and activations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32 bits, for work.
    #[default]
    F32,
    /// 64 bits, for tests against finite differences.
    F64,
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
