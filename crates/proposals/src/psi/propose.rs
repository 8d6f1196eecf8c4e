//! The transform in a filter.

use motes_models::{StateSpaceModel, Stream};
use motes_smc::{Conditional, Past, Proposal, ProposalError, particles_by_stream};
use rand::RngExt;

use super::Psi;
use super::map::Map;

/// The distributions of `R` particles at one time.
#[derive(Clone)]
pub struct Transformed {
    map: Map,
    log_abs_det: f64,
    /// `R×N`.
    shifts: Vec<f64>,
    /// `R×N`.
    noise: Vec<f64>,
}

impl<M: StateSpaceModel + ?Sized> Proposal<M> for Psi {
    type Memory = ();
    type Conditional<'a>
        = &'a mut Transformed
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        _memory: &mut (),
    ) -> Result<&'a mut Transformed, ProposalError> {
        ProposalError::unless_same("the state dimension N", self.state_dim, model.state_dim())?;
        let (map, shifts) = self.conditioned(&past)?;
        let log_abs_det = self.inverses(&map, past.time)?.log_abs_det;
        let noise = vec![0.0; shifts.len()];
        Ok(self.conditional.insert(Transformed { map, log_abs_det, shifts, noise }))
    }
}

impl Conditional for Transformed {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let (particles, width) = (log_density.len(), states.len() / log_density.len().max(1));
        for (stream, noise) in particles_by_stream(streams, &mut self.noise, width, particles) {
            fill_uniform(stream, noise);
        }
        let log_density = Some((self.log_abs_det, log_density));
        self.map.forward(&self.shifts, &self.noise, states, log_density);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        self.map.inverse(self.log_abs_det, &self.shifts, states, &mut self.noise, log_density);
    }
}

/// Fills `noise` with independent variates uniform on `[0, 1)`.
pub(super) fn fill_uniform(stream: &mut Stream, noise: &mut [f64]) {
    noise.fill_with(|| stream.random());
}
