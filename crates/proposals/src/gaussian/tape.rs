//! A Gaussian family in training.

use motes_models::{Stream, fill_standard_normal};
use motes_smc::{Past, ProposalError};

use super::batch::GaussianBatch;
use super::{GaussianProposal, KernelCovariance, NetworkTape, Networks};
use crate::native::NativeTape;
use crate::plain::{Library, PlainTape};
use crate::{Learnable, Parameters, Precision, Tape, Workspace};

impl<F: Networks, Config: Clone> Learnable for GaussianProposal<F, Config> {
    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    fn horizon(&self) -> Option<usize> {
        self.networks.horizon()
    }

    fn state_dim(&self) -> usize {
        self.state_dim
    }

    fn measurement_dim(&self) -> usize {
        self.measurement_dim
    }

    fn fill_noise(&self, stream: &mut Stream, noise: &mut [f64]) {
        fill_standard_normal(stream, noise);
    }

    fn tape(&self, particles: usize, workspace: Workspace) -> Box<dyn Tape + '_> {
        let (networks, parameters) = (&self.networks, &self.parameters);
        let networks: Box<dyn NetworkTape + '_> = match Library::of(parameters) {
            Some(library) => Box::new(PlainTape::new(library, networks, parameters, particles, workspace)),
            None => match parameters.compute().precision {
                Precision::F32 => {
                    Box::new(NativeTape::<F, f32>::new(networks, parameters, particles, workspace))
                }
                Precision::F64 => {
                    Box::new(NativeTape::<F, f64>::new(networks, parameters, particles, workspace))
                }
            },
        };
        Box::new(GaussianTape { proposal: self, networks, covariance: None, draws: Vec::new() })
    }
}

/// Everything that the way back needs.
struct GaussianTape<'p, F, Config> {
    proposal: &'p GaussianProposal<F, Config>,
    networks: Box<dyn NetworkTape + 'p>,
    /// The same at all times; formed at the first draw, which can report an error.
    covariance: Option<KernelCovariance>,
    draws: Vec<Draw>,
}

/// What is probabilistic of one step.
struct Draw {
    time: usize,
    representations: Vec<f64>,
    lowers: Vec<f64>,
    noise: Vec<f64>,
}

impl<F: Networks, Config: Clone> Tape for GaussianTape<'_, F, Config> {
    fn draw(
        &mut self,
        past: Past<'_>,
        noise: &[f64],
        states: &mut [f64],
        log_density: Option<&mut [f64]>,
    ) -> Result<(), ProposalError> {
        let proposal = self.proposal;
        proposal.check(&past)?;
        let covariance = match self.covariance.take() {
            Some(covariance) => covariance,
            None => proposal.covariance()?,
        };
        let n = proposal.state_dim;
        let mut representations = vec![0.0; past.particles * n];
        let mut batch = GaussianBatch::default();
        let (means, lowers) = batch.places(n, past.particles);
        self.networks.forward(&past, n, means, &mut representations)?;
        covariance.factor(&representations, lowers)?;
        batch.transform(noise, states);
        if let Some(log_density) = log_density {
            batch.log_density_of_noise(noise, log_density);
        }
        self.covariance = Some(covariance);
        let (time, lowers, noise) = (past.time, batch.into_lowers(), noise.to_vec());
        self.draws.push(Draw { time, representations, lowers, noise });
        Ok(())
    }

    fn pull_back(
        &mut self,
        d_states: &[f64],
        d_log_density: Option<&[f64]>,
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError> {
        let (draw, covariance) = match (self.draws.pop(), &self.covariance) {
            (Some(draw), Some(covariance)) => (draw, covariance),
            _ => panic!("there is no draw left to pull back"),
        };
        let (d_representations, d_mixing) =
            covariance.pull_back(&draw.representations, &draw.lowers, &draw.noise, d_states, d_log_density);
        self.networks.gradients().add_wide(self.proposal.mixing, &d_mixing);
        self.networks.backward(d_states, &d_representations, d_previous)?;
        if draw.time == 0 {
            d_previous.fill(0.0);
        }
        Ok(())
    }

    fn cut(&mut self) {
        self.networks.cut();
    }

    fn finish(self: Box<Self>) -> Workspace {
        self.networks.finish()
    }
}
