//! Networks computed forward only, as a filter does, by the backend that the weights ask for.

use crate::backend::Backend;
#[cfg(feature = "burn")]
use crate::by_burn::{self, Library};
use crate::error::NetworkError;
use crate::fit::{OUTPUTS, check_hidden, check_inputs, unless_same};
use crate::native::{self, Memory};
use crate::networks::{Inputs, Networks};
use crate::parameters::Parameters;
use crate::precision::Precision;
use crate::values::SliceMut;

/// Computes networks, with memory that is used again from call to call.
#[derive(Default)]
pub struct Inference {
    memory: Memory,
}

impl Clone for Inference {
    /// A copy has memory of its own.
    fn clone(&self) -> Self {
        Inference::default()
    }
}

impl Inference {
    /// Computes the outputs of particles that carry `hidden` (`R×width` each), which is advanced; each output (`R×width`) goes into a slice of
    /// `outputs`. Particles that know the same and lie side by side are computed once.
    ///
    /// # Errors
    /// [`NetworkError::NotBuilt`] if the backend of the weights is not there, [`NetworkError::Backend`] if it failed. [`NetworkError::Shape`],
    /// [`NetworkError::Precision`], [`NetworkError::Empty`] or [`NetworkError::PastHorizon`] for what does not fit the networks; nothing was
    /// written then.
    ///
    /// # Panics
    /// Perhaps if states or the measurement are not as wide as the weights were made for. Only the networks' owner knows these widths.
    pub fn run<F: Networks>(
        &mut self,
        networks: &F,
        parameters: &Parameters,
        inputs: &Inputs<'_>,
        hidden: &mut [SliceMut<'_>],
        outputs: &mut [&mut [f64]],
    ) -> Result<(), NetworkError> {
        let compute = parameters.compute();
        compute.backend.check()?;
        check_inputs(networks, inputs)?;
        check_hidden(networks, compute.precision, inputs.particles, hidden)?;
        if inputs.particles == 0 {
            return outputs.iter().try_for_each(|output| unless_same(OUTPUTS[1], output.len(), 0));
        }
        match (compute.backend, compute.precision) {
            (Backend::Native, Precision::F32) => {
                native::infer::<F, f32>(networks, parameters, inputs, hidden, &mut self.memory, outputs)
            }
            (Backend::Native, Precision::F64) => {
                native::infer::<F, f64>(networks, parameters, inputs, hidden, &mut self.memory, outputs)
            }
            #[cfg(feature = "burn")]
            (_, _) => by_burn::infer(&Library::of(compute)?, networks, parameters, inputs, hidden, outputs),
            // Refused by the check above.
            #[cfg(not(feature = "burn"))]
            (backend, _) => Err(NetworkError::Backend { reason: format!("{backend} is not in this build") }),
        }
    }
}
