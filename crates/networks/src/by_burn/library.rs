//! Tensors of burn's from numbers on the host and back.

use burn::tensor::{DType, Device, Tensor, TensorData};
use faer::Mat;

use crate::backend::{Backend, Compute};
use crate::error::NetworkError;
use crate::networks::Inputs;
use crate::parameters::Parameters;
use crate::precision::Precision;

/// A device of burn's with a precision: all that is needed to make a tensor.
#[derive(Clone)]
pub(crate) struct Library {
    device: Device,
    precision: Precision,
}

impl Library {
    /// The one that was asked for. Nothing depends on burn's idea of a default device.
    ///
    /// # Errors
    /// [`NetworkError::Backend`] for the native backend, which is not burn's, for a graphics processor that is not there, and for 64 bits on
    /// one; [`NetworkError::NotBuilt`] for what was not compiled.
    pub(crate) fn of(Compute { backend, precision }: Compute) -> Result<Self, NetworkError> {
        let fail = |reason: &str| Err(NetworkError::Backend { reason: reason.into() });
        if !backend.has(precision) {
            return fail("graphics processors compute networks in 32 bits; give Precision::F32");
        }
        backend.check()?;
        let device = match backend {
            Backend::Flex => Device::flex(),
            #[allow(deprecated, reason = "kept on purpose, see `Backend::NdArray`")]
            Backend::NdArray => Device::ndarray(),
            #[cfg(feature = "wgpu")]
            Backend::Wgpu => super::graphics::device("wgpu", || Device::wgpu(Default::default()))?,
            #[cfg(feature = "cuda")]
            Backend::Cuda => super::graphics::device("cuda", || Device::cuda(0_usize))?,
            _ => return fail("the native backend is not burn's"),
        };
        Ok(Library { device, precision })
    }

    /// A constant `rows×columns` tensor from row-major values.
    pub(super) fn tensor(&self, values: &[f64], shape: [usize; 2]) -> Tensor<2> {
        match self.precision {
            Precision::F32 => {
                let narrow: Vec<f32> = values.iter().map(|&value| value as f32).collect();
                Tensor::from_data(TensorData::new(narrow, shape), (&self.device, DType::F32))
            }
            Precision::F64 => {
                Tensor::from_data(TensorData::new(values.to_vec(), shape), (&self.device, DType::F64))
            }
        }
    }

    pub(super) fn matrix(&self, matrix: &Mat<f64>) -> Tensor<2> {
        let (rows, columns) = (matrix.nrows(), matrix.ncols());
        let values: Vec<f64> = (0..rows * columns).map(|at| matrix[(at / columns, at % columns)]).collect();
        self.tensor(&values, [rows, columns])
    }

    pub(super) fn weights(&self, parameters: &Parameters) -> Vec<Tensor<2>> {
        (0..parameters.len()).map(|at| self.tensor(&parameters.host(at), parameters.shape(at))).collect()
    }

    /// `x_{t−1}` (zeros at `t = 0`) and `y_t`.
    pub(super) fn known(&self, inputs: &Inputs<'_>) -> (Tensor<2>, Tensor<2>) {
        let shape = [inputs.particles, inputs.width];
        let previous = match inputs.previous {
            Some(previous) => self.tensor(previous, shape),
            None => self.tensor(&vec![0.0; inputs.particles * inputs.width], shape),
        };
        (previous, self.tensor(inputs.measurement, [1, inputs.measurement.len()]))
    }
}

/// Reads a tensor back, row-major.
pub(super) fn to_host(tensor: Tensor<2>) -> Result<Vec<f64>, NetworkError> {
    tensor.try_into_vec_as::<f64>().map_err(|error| NetworkError::Backend { reason: error.to_string() })
}
