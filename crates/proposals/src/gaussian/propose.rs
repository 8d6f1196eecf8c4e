//! A Gaussian family in a filter.

use motes_models::batch::Rows;
use motes_models::{StateSpaceModel, Step};
use motes_networks::{Inference, Inputs};
use motes_smc::{Context, GaussianBatch, Proposal, ProposalError};

use super::hidden::{Hidden, HiddenRows};
use super::networks::GaussianNetworks;
use super::proposal::{GaussianProposal, Prepared};
use crate::settings::of_networks;

/// What conditioning a block of particles computes in.
#[derive(Default)]
pub struct GaussianScratch {
    conditional: GaussianBatch,
    /// `z_t`, `R×N`.
    representations: Vec<f64>,
    inference: Inference,
}

impl<M: StateSpaceModel + ?Sized, F: GaussianNetworks> Proposal<M> for GaussianProposal<F> {
    type Memory = Hidden;
    type Scratch = GaussianScratch;
    type Conditional<'a>
        = &'a mut GaussianBatch
    where
        F: 'a,
        M: 'a;

    fn initial_memory(&self, particles: usize) -> Hidden {
        let precision = self.parameters.compute().precision;
        Hidden::zeros(precision, particles, &self.networks.hidden_widths())
    }

    fn memory_per_particle(&self) -> usize {
        Hidden::per_particle(self.parameters.compute().precision, &self.networks.hidden_widths())
    }

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
        self.check(step.index, &measurement)?;
        let covariance = self.covariance(step.index)?;
        self.prepared = Some(Prepared { time: step.index, measurement, covariance });
        Ok(true)
    }

    fn condition<'a>(
        &'a self,
        _model: &'a M,
        context: Context<'a>,
        memory: HiddenRows<'_>,
        scratch: &'a mut GaussianScratch,
    ) -> Result<&'a mut GaussianBatch, ProposalError> {
        let Context { step, previous, particles, .. } = context;
        let time = step.index;
        let prepared = self.prepared.as_ref().filter(|prepared| prepared.time == time);
        let Some(Prepared { measurement, covariance, .. }) = prepared else {
            return Err(ProposalError::NotPrepared { time });
        };
        let (width, mut hidden) = (self.state_dim, memory.into_slices());
        let GaussianScratch { conditional, representations, inference } = scratch;
        representations.resize(particles * width, 0.0);
        let (means, lowers) = conditional.places(width, particles);
        let mut run = |previous: Option<&[f64]>| {
            let inputs = Inputs { time, width, previous, measurement, particles };
            let outputs = &mut [&mut *means, representations.as_mut_slice()];
            inference.run(&self.networks, &self.parameters, &inputs, &mut hidden, outputs)
        };
        match previous {
            None => run(None),
            Some(previous) => Rows::with_contiguous(&previous, |previous| run(Some(previous))),
        }
        .map_err(of_networks)?;
        covariance.factor(representations, lowers)?;
        Ok(conditional)
    }
}
