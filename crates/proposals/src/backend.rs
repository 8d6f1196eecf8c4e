//! Where networks are computed, and in which precision.

use burn::tensor::{DType, Device, Tensor, TensorData};
use motes_smc::ProposalError;

/// What computes the networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backend {
    /// burn's own CPU backend: the faster one, and maintained.
    #[default]
    Flex,
    /// The backend on top of `ndarray`, deprecated upstream: kept as an independent second opinion.
    NdArray,
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

/// A backend together with a precision: all that is needed to make a tensor.
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

impl Compute {
    /// The device, named explicitly: nothing here depends on burn's idea of a default.
    pub(crate) fn device(self) -> Device {
        match self.backend {
            Backend::Flex => Device::flex(),
            #[allow(deprecated, reason = "kept on purpose, see `Backend::NdArray`")]
            Backend::NdArray => Device::ndarray(),
        }
    }

    /// A constant `rows×columns` tensor from row-major values.
    pub(crate) fn tensor(self, values: &[f64], [rows, columns]: [usize; 2]) -> Tensor<2> {
        match self.precision {
            Precision::F32 => {
                let narrow: Vec<f32> = values.iter().map(|&value| value as f32).collect();
                let data = TensorData::new(narrow, [rows, columns]);
                Tensor::from_data(data, (&self.device(), DType::F32))
            }
            Precision::F64 => {
                let data = TensorData::new(values.to_vec(), [rows, columns]);
                Tensor::from_data(data, (&self.device(), DType::F64))
            }
        }
    }
}

/// Reads a tensor back to the host, row-major.
///
/// # Errors
/// [`ProposalError::Backend`] if the backend could not compute it.
pub(crate) fn to_host(tensor: Tensor<2>) -> Result<Vec<f64>, ProposalError> {
    tensor.try_into_vec_as::<f64>().map_err(|error| ProposalError::Backend { reason: error.to_string() })
}
