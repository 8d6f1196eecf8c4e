//! Networks computed forward along a sequence with derivatives to come, by the backend that the weights ask for.

use crate::backend::Backend;
#[cfg(feature = "burn")]
use crate::by_burn::{BurnTape, Library};
use crate::error::NetworkError;
use crate::gradients::Gradients;
use crate::native::NativeTape;
use crate::networks::{Inputs, Networks};
use crate::parameters::Parameters;
use crate::precision::Precision;
use crate::workspace::Workspace;

/// A recording of one batch of particles from `t = 0` on.
pub struct NetworkTape<'p, F>(By<'p, F>);

enum By<'p, F> {
    Narrow(NativeTape<'p, F, f32>),
    Wide(NativeTape<'p, F, f64>),
    #[cfg(feature = "burn")]
    Burn(Box<BurnTape<'p, F>>),
}

impl<'p, F: Networks> NetworkTape<'p, F> {
    /// Starts recording `particles` particles, with the memory of a recording that is over.
    ///
    /// # Errors
    /// [`NetworkError::NotBuilt`] if the backend of the weights is not there, [`NetworkError::Empty`] without particles,
    /// [`NetworkError::Workspace`] for one that was made for other weights ([`Workspace::fits`]).
    pub fn new(
        networks: &'p F,
        parameters: &'p Parameters,
        particles: usize,
        workspace: Workspace,
    ) -> Result<Self, NetworkError> {
        let compute = parameters.compute();
        compute.backend.check()?;
        if particles == 0 {
            return Err(NetworkError::Empty { what: "the number of particles" });
        }
        if !workspace.fits(parameters) {
            return Err(NetworkError::Workspace);
        }
        Ok(NetworkTape(match (compute.backend, compute.precision) {
            (Backend::Native, Precision::F32) => {
                By::Narrow(NativeTape::new(networks, parameters, particles, workspace.open(parameters)))
            }
            (Backend::Native, Precision::F64) => {
                By::Wide(NativeTape::new(networks, parameters, particles, workspace.open(parameters)))
            }
            #[cfg(feature = "burn")]
            (_, _) => {
                let gradients = workspace.into_cleared_gradients();
                let library = Library::of(compute)?;
                By::Burn(Box::new(BurnTape::new(library, networks, parameters, particles, gradients)))
            }
            // Refused by the check above.
            #[cfg(not(feature = "burn"))]
            (backend, _) => {
                return Err(NetworkError::Backend { reason: format!("{backend} is not in this build") });
            }
        }))
    }

    /// Computes one step, each of its outputs (`R×width`) into a slice of `outputs`.
    ///
    /// # Errors
    /// [`NetworkError::Backend`] if the backend failed. [`NetworkError::Shape`], [`NetworkError::Empty`] or [`NetworkError::PastHorizon`] for
    /// what does not fit the networks or the recording; nothing was recorded then.
    ///
    /// # Panics
    /// Perhaps if states or the measurement are not as wide as the weights were made for. Only the networks' owner knows these widths.
    pub fn forward(&mut self, inputs: &Inputs<'_>, outputs: &mut [&mut [f64]]) -> Result<(), NetworkError> {
        match &mut self.0 {
            By::Narrow(tape) => tape.forward(inputs, outputs),
            By::Wide(tape) => tape.forward(inputs, outputs),
            #[cfg(feature = "burn")]
            By::Burn(tape) => tape.forward(inputs, outputs),
        }
    }

    /// Undoes the last step that is not yet undone: takes the derivative with respect to each output, adds to the gradients of the weights, and
    /// writes the derivative with respect to `x_{t−1}` into `d_previous` (`R×N`; it means nothing at `t = 0`).
    ///
    /// # Errors
    /// [`NetworkError::Backend`] if the backend failed, [`NetworkError::Shape`] for derivatives that are not those of the step; it is then not
    /// undone.
    ///
    /// # Panics
    /// If no step is left.
    pub fn backward(&mut self, d_outputs: &[&[f64]], d_previous: &mut [f64]) -> Result<(), NetworkError> {
        match &mut self.0 {
            By::Narrow(tape) => tape.backward(d_outputs, Some(d_previous)),
            By::Wide(tape) => tape.backward(d_outputs, Some(d_previous)),
            #[cfg(feature = "burn")]
            By::Burn(tape) => tape.backward(d_outputs, d_previous),
        }
    }

    /// [`NetworkTape::backward`] where nobody asks for the derivative with respect to `x_{t−1}`.
    ///
    /// # Errors
    /// As [`NetworkTape::backward`].
    ///
    /// # Panics
    /// If no step is left.
    pub fn backward_to_weights(&mut self, d_outputs: &[&[f64]]) -> Result<(), NetworkError> {
        match &mut self.0 {
            By::Narrow(tape) => tape.backward(d_outputs, None),
            By::Wide(tape) => tape.backward(d_outputs, None),
            #[cfg(feature = "burn")]
            By::Burn(tape) => tape.backward_to_weights(d_outputs),
        }
    }

    /// Forgets what would flow into earlier steps through what the particles carry.
    pub fn detach(&mut self) {
        match &mut self.0 {
            By::Narrow(tape) => tape.detach(),
            By::Wide(tape) => tape.detach(),
            #[cfg(feature = "burn")]
            By::Burn(tape) => tape.detach(),
        }
    }

    /// The gradients gathered so far, to be added to; some may still wait for [`NetworkTape::finish`].
    pub fn gradients(&mut self) -> &mut Gradients {
        match &mut self.0 {
            By::Narrow(tape) => tape.gradients(),
            By::Wide(tape) => tape.gradients(),
            #[cfg(feature = "burn")]
            By::Burn(tape) => tape.gradients(),
        }
    }

    /// Ends the recording; the workspace then holds the gradients.
    pub fn finish(self) -> Workspace {
        match self.0 {
            By::Narrow(tape) => Workspace::closed(tape.finish()),
            By::Wide(tape) => Workspace::closed(tape.finish()),
            #[cfg(feature = "burn")]
            By::Burn(tape) => tape.finish().into(),
        }
    }
}
