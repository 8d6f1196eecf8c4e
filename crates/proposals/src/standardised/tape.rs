//! A standardised family in training.

use motes_models::Stream;
use motes_models::batch::Rows;
use motes_networks::{HiddenReader, Inputs, Parameters, Workspace};
use motes_smc::ProposalError;

use super::family::Standardised;
use super::frame::Frame;
use crate::family::{Family, Parametric};
use crate::learnable::{Learnable, Tape};

impl<F: Family> Parametric for Standardised<F> {
    fn parameters(&self) -> &Parameters {
        self.proposal.parameters()
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        self.proposal.parameters_mut()
    }

    fn hidden_readers(&self) -> Vec<HiddenReader> {
        self.proposal.hidden_readers()
    }

    fn weight_matrices(&self) -> Vec<usize> {
        self.proposal.weight_matrices()
    }

    fn horizon(&self) -> Option<usize> {
        let horizons = [self.proposal.horizon(), self.config.frames.horizon()];
        horizons.into_iter().flatten().min()
    }

    fn state_dim(&self) -> usize {
        self.proposal.state_dim()
    }

    fn measurement_dim(&self) -> usize {
        self.proposal.measurement_dim()
    }
}

impl<F: Family + Learnable> Learnable for Standardised<F> {
    fn fill_noise(&self, stream: &mut Stream, noise: &mut [f64]) {
        self.proposal.fill_noise(stream, noise);
    }

    fn tape(&self, particles: usize, workspace: Workspace) -> Result<Box<dyn Tape + '_>, ProposalError> {
        Ok(Box::new(StandardisedTape {
            proposal: self,
            inner: self.proposal.tape(particles, workspace)?,
            frames: Vec::new(),
            standardised: Vec::new(),
            origins: Vec::new(),
            d_outputs: Vec::new(),
        }))
    }
}

struct StandardisedTape<'p, F: Family> {
    proposal: &'p Standardised<F>,
    inner: Box<dyn Tape + 'p>,
    /// Those of the draws that are not yet undone.
    frames: Vec<&'p Frame>,
    /// `ξ_{t−1}`, `R×N`.
    standardised: Vec<f64>,
    origins: Vec<f64>,
    d_outputs: Vec<f64>,
}

impl<F: Family> Tape for StandardisedTape<'_, F> {
    fn draw(
        &mut self,
        inputs: &Inputs<'_>,
        noise: &[f64],
        states: &mut [f64],
        mut log_density: Option<&mut [f64]>,
    ) -> Result<(), ProposalError> {
        let measurement_dim = self.proposal.measurement_dim();
        ProposalError::unless_same("the measurement dimension M", measurement_dim, inputs.measurement.len())?;
        let frame = self.proposal.config.frames.at(inputs.time)?;
        let (measurement, origin) = frame.of_measurement(inputs.measurement);
        let previous = inputs.previous.map(|previous| Rows::all(previous, inputs.width));
        let written = (&mut self.standardised, &mut self.origins);
        frame.of_previous(previous, inputs.particles, &origin, written);
        let previous = inputs.previous.map(|_| self.standardised.as_slice());
        let of_family = Inputs { previous, measurement: &measurement, ..*inputs };
        self.inner.draw(&of_family, noise, states, log_density.as_deref_mut())?;
        frame.leave(&self.origins, states);
        if let Some(log_density) = log_density {
            let log_volume = frame.log_volume();
            log_density.iter_mut().for_each(|log| *log -= log_volume);
        }
        self.frames.push(frame);
        Ok(())
    }

    fn pull_back(
        &mut self,
        d_states: &[f64],
        d_log_density: Option<&[f64]>,
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError> {
        let Some(frame) = self.frames.pop() else { panic!("there is no draw left to pull back") };
        let deviations = frame.output.deviations.iter().cycle();
        self.d_outputs.clear();
        self.d_outputs.extend(d_states.iter().zip(deviations).map(|(d, deviation)| d * deviation));
        self.inner.pull_back(&self.d_outputs, d_log_density, d_previous)?;
        if self.frames.is_empty() {
            // Nothing came before t = 0, and the family has said so.
            return Ok(());
        }
        frame.pull_back(d_states, d_previous);
        Ok(())
    }

    fn detach(&mut self) {
        self.inner.detach();
    }

    fn finish(self: Box<Self>) -> Workspace {
        self.inner.finish()
    }
}
