//! The transform in a filter.

use std::sync::OnceLock;

use motes_models::batch::Rows;
use motes_models::{StateSpaceModel, Step, Stream};
use motes_smc::{Conditional, Context, Proposal, ProposalError, particles_by_stream};
use rand::RngExt;

use super::inverse::Factored;
use super::transform::{Prepared, Psi};

/// What conditioning a block of particles computes in.
#[derive(Default)]
pub struct PsiScratch {
    /// `B x_{t−1} + C y_t`, `R×N`.
    shifts: Vec<f64>,
    /// `R×N`.
    noise: Vec<f64>,
}

/// The distributions of `R` particles at one time.
pub struct Transformed<'a> {
    prepared: &'a Prepared,
    scratch: &'a mut PsiScratch,
}

impl<M: StateSpaceModel + ?Sized> Proposal<M> for Psi {
    type Memory = ();
    type Scratch = PsiScratch;
    type Conditional<'a>
        = Transformed<'a>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        ProposalError::unless_same("the state dimension N", self.state_dim, model.state_dim())?;
        self.prepared = None;
        let Some(measurement) = measurement.iter().copied().collect::<Option<Vec<f64>>>() else {
            return Ok(false);
        };
        let (map, shift) = self.at_measurement(step.index, &measurement)?;
        let log_abs_det = self.inverses(&map, step.index)?.log_abs_det;
        self.prepared =
            Some(Prepared { time: step.index, map, log_abs_det, factored: OnceLock::new(), shift });
        Ok(true)
    }

    fn condition<'a>(
        &'a self,
        _model: &'a M,
        context: Context<'a>,
        (): (),
        scratch: &'a mut PsiScratch,
    ) -> Result<Transformed<'a>, ProposalError> {
        let prepared = self.prepared.as_ref().filter(|prepared| prepared.time == context.step.index);
        let Some(prepared) = prepared else {
            return Err(ProposalError::NotPrepared { time: context.step.index });
        };
        let Prepared { map, shift, .. } = prepared;
        let PsiScratch { shifts, noise } = scratch;
        noise.resize(context.particles * self.state_dim, 0.0);
        shifts.clear();
        (0..context.particles).for_each(|_| shifts.extend_from_slice(shift));
        if let Some(previous) = context.previous {
            Rows::with_contiguous(&previous, |previous| map.add_previous(Some(previous), shifts));
        }
        Ok(Transformed { prepared, scratch })
    }
}

impl Conditional for Transformed<'_> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let (particles, width) = (log_density.len(), states.len() / log_density.len().max(1));
        let PsiScratch { shifts, noise } = &mut *self.scratch;
        for (stream, noise) in particles_by_stream(streams, noise, width, particles) {
            fill_uniform(stream, noise);
        }
        let Prepared { map, log_abs_det, .. } = self.prepared;
        map.forward(shifts, noise, states, Some((*log_abs_det, log_density)));
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        let PsiScratch { shifts, noise } = &mut *self.scratch;
        let Prepared { map, log_abs_det, factored, .. } = self.prepared;
        let factored = factored.get_or_init(|| Factored::new(map, *log_abs_det));
        map.inverse(factored, shifts, states, noise, log_density);
    }
}

/// Fills `noise` with independent variates uniform on `[0, 1)`.
pub(super) fn fill_uniform(stream: &mut Stream, noise: &mut [f64]) {
    noise.fill_with(|| stream.random());
}
