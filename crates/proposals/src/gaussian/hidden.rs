//! What particles carry beside their state: rows of tensors.

use burn::tensor::{DType, Int, Tensor, TensorData};
use motes_smc::{ParticleMemory, ProposalError};

use crate::Compute;
use crate::backend::to_host;

/// The hidden state of each particle, a row in each of a few tensors; empty for a family without memory.
#[derive(Clone)]
pub struct Hidden {
    compute: Compute,
    pub(crate) tensors: Vec<Tensor<2>>,
}

impl Hidden {
    /// Zeros of the given widths for `particles` particles.
    pub(crate) fn zeros(compute: Compute, particles: usize, widths: &[usize]) -> Self {
        let zeros = |&width: &usize| compute.tensor(&vec![0.0; particles * width], [particles, width]);
        Hidden { compute, tensors: widths.iter().map(zeros).collect() }
    }

    /// Each tensor (`R×width`, row-major) on the host.
    ///
    /// # Errors
    /// [`ProposalError::Backend`] if the backend could not read it back.
    pub fn host(&self) -> Result<Vec<Vec<f64>>, ProposalError> {
        self.tensors.iter().map(|tensor| to_host(tensor.clone())).collect()
    }
}

impl ParticleMemory for Hidden {
    fn resample(&mut self, ancestors: &[usize]) {
        if self.tensors.is_empty() {
            return;
        }
        let rows: Vec<i64> = ancestors.iter().map(|&ancestor| ancestor as i64).collect();
        let data = TensorData::new(rows, [ancestors.len()]);
        let rows = Tensor::<1, Int>::from_data(data, (&self.compute.device(), DType::I64));
        for tensor in &mut self.tensors {
            *tensor = tensor.clone().select(0, rows.clone());
        }
    }
}
