//! A Gaussian family in training.

use motes_models::{Stream, fill_standard_normal};
use motes_networks::{HiddenReader, Inputs, NetworkTape, Parameters, Workspace};
use motes_smc::{GaussianBatch, ProposalError};

use super::covariance::KernelCovariance;
use super::networks::GaussianNetworks;
use super::proposal::GaussianProposal;
use crate::family::Parametric;
use crate::learnable::{Learnable, Tape};
use crate::settings::of_networks;

impl<F: GaussianNetworks> Parametric for GaussianProposal<F> {
    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    fn hidden_readers(&self) -> Vec<HiddenReader> {
        self.networks.hidden_readers()
    }

    /// Those of the networks. `C` is none: a smaller one is a narrower distribution, not a simpler network.
    fn weight_matrices(&self) -> Vec<usize> {
        let names = self.parameters.names();
        let is_weight = |index: &usize| !names[*index].ends_with("bias") && !self.mixings.contains(index);
        (0..names.len()).filter(is_weight).collect()
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
}

impl<F: GaussianNetworks> Learnable for GaussianProposal<F> {
    fn fill_noise(&self, stream: &mut Stream, noise: &mut [f64]) {
        fill_standard_normal(stream, noise);
    }

    fn tape(&self, particles: usize, workspace: Workspace) -> Result<Box<dyn Tape + '_>, ProposalError> {
        let networks = NetworkTape::new(&self.networks, &self.parameters, particles, workspace);
        let networks = networks.map_err(of_networks)?;
        Ok(Box::new(GaussianTape { proposal: self, networks, covariances: Vec::new(), draws: Vec::new() }))
    }
}

/// Everything that the way back needs.
struct GaussianTape<'p, F: GaussianNetworks> {
    proposal: &'p GaussianProposal<F>,
    networks: NetworkTape<'p, F>,
    /// By the index of their `C`; formed at the first draw with it, which can report an error.
    covariances: Vec<(usize, KernelCovariance)>,
    draws: Vec<Draw>,
}

/// What is probabilistic of one step.
struct Draw {
    time: usize,
    /// Which of the covariances.
    covariance: usize,
    representations: Vec<f64>,
    lowers: Vec<f64>,
    noise: Vec<f64>,
}

impl<F: GaussianNetworks> Tape for GaussianTape<'_, F> {
    fn draw(
        &mut self,
        inputs: &Inputs<'_>,
        noise: &[f64],
        states: &mut [f64],
        log_density: Option<&mut [f64]>,
    ) -> Result<(), ProposalError> {
        let proposal = self.proposal;
        proposal.check(inputs.time, inputs.measurement)?;
        let mixing = proposal.mixing(inputs.time);
        let at = match self.covariances.iter().position(|(index, _)| *index == mixing) {
            Some(at) => at,
            None => {
                self.covariances.push((mixing, proposal.covariance(inputs.time)?));
                self.covariances.len() - 1
            }
        };
        let (_, covariance) = &self.covariances[at];
        let n = proposal.state_dim;
        let mut representations = vec![0.0; inputs.particles * n];
        let mut batch = GaussianBatch::default();
        let (means, lowers) = batch.places(n, inputs.particles);
        let outputs = &mut [means, representations.as_mut_slice()];
        self.networks.forward(inputs, outputs).map_err(of_networks)?;
        covariance.factor(&representations, lowers)?;
        batch.transform(noise, states);
        if let Some(log_density) = log_density {
            batch.log_density_of_noise(noise, log_density);
        }
        let (time, lowers, noise) = (inputs.time, batch.into_lowers(), noise.to_vec());
        self.draws.push(Draw { time, covariance: at, representations, lowers, noise });
        Ok(())
    }

    fn pull_back(
        &mut self,
        d_states: &[f64],
        d_log_density: Option<&[f64]>,
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError> {
        let Some(draw) = self.draws.pop() else { panic!("there is no draw left to pull back") };
        let (mixing, covariance) = &self.covariances[draw.covariance];
        let (d_representations, d_mixing) =
            covariance.pull_back(&draw.representations, &draw.lowers, &draw.noise, d_states, d_log_density);
        self.networks.gradients().add_wide(*mixing, &d_mixing);
        self.networks.backward(&[d_states, &d_representations], d_previous).map_err(of_networks)?;
        if draw.time == 0 {
            d_previous.fill(0.0);
        }
        Ok(())
    }

    fn detach(&mut self) {
        self.networks.detach();
    }

    fn finish(self: Box<Self>) -> Workspace {
        self.networks.finish()
    }
}
