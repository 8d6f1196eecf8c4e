//! A Gaussian family in training.

use burn::tensor::Tensor;
use motes_models::Stream;
use motes_smc::{Past, ProposalError};

use super::batch::{GaussianBatch, fill_standard_normal};
use super::{GaussianProposal, Hidden, KernelCovariance, Known, Networks};
use crate::affine::{Gathering, Record, Weights};
use crate::backend::to_host;
use crate::{Gradients, Learnable, Parameters, Tape};

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

    fn tape(&self, particles: usize) -> Box<dyn Tape + '_> {
        let hidden = Hidden::zeros(self.parameters.compute(), particles, &self.networks.hidden_widths());
        Box::new(GaussianTape {
            proposal: self,
            particles,
            covariance: None,
            hidden: hidden.tensors,
            d_hidden: Vec::new(),
            draws: Vec::new(),
            gradients: Gathering::none(self.parameters.len()),
        })
    }
}

/// Everything that the way back needs.
struct GaussianTape<'p, F, Config> {
    proposal: &'p GaussianProposal<F, Config>,
    particles: usize,
    /// The same at all times; formed at the first draw, which can report an error.
    covariance: Option<KernelCovariance>,
    /// What the particles carry into the next draw.
    hidden: Vec<Tensor<2>>,
    /// The derivative with respect to what they carried out of the last draw not yet undone; empty if it is zero.
    d_hidden: Vec<Tensor<2>>,
    draws: Vec<Draw>,
    gradients: Gathering,
}

/// One step's graph of the networks, cut off from those of the other steps.
struct Draw {
    time: usize,
    weights: Record,
    previous: Tensor<2>,
    hidden_in: Vec<Tensor<2>>,
    hidden_out: Vec<Tensor<2>>,
    means: Tensor<2>,
    representations: Tensor<2>,
    representation_values: Vec<f64>,
    lowers: Vec<f64>,
    noise: Vec<f64>,
}

impl<F: Networks, Config: Clone> Tape for GaussianTape<'_, F, Config> {
    fn draw(
        &mut self,
        past: Past<'_>,
        noise: &[f64],
        states: &mut [f64],
        log_density: &mut [f64],
    ) -> Result<(), ProposalError> {
        let proposal = self.proposal;
        let covariance = match self.covariance.take() {
            Some(covariance) => covariance,
            None => proposal.covariance()?,
        };
        let leaf = |tensor: Tensor<2>| tensor.autodiff().require_grad();
        let (previous, measurement) = proposal.known(&past)?;
        let (previous, measurement) = (leaf(previous), measurement.autodiff());
        let hidden_in: Vec<Tensor<2>> = self.hidden.drain(..).map(leaf).collect();
        let known = Known { previous: previous.clone(), measurement, hidden: &hidden_in };
        let mut weights = Weights::recorded(proposal.parameters.tensors());
        let emission = proposal.networks.forward(&mut weights, past.time, known);
        self.hidden = emission.hidden.iter().map(|tensor| tensor.clone().inner()).collect();
        let representation_values = to_host(emission.representations.clone().inner())?;
        let lowers = covariance.factors(&representation_values)?;
        let means = to_host(emission.means.clone().inner())?;
        let batch = GaussianBatch::new(proposal.state_dim, means, lowers);
        batch.transform(noise, states, log_density);
        self.covariance = Some(covariance);
        self.draws.push(Draw {
            time: past.time,
            weights: weights.into_record(),
            previous,
            hidden_in,
            hidden_out: emission.hidden,
            means: emission.means,
            representations: emission.representations,
            representation_values,
            lowers: batch.into_lowers(),
            noise: noise.to_vec(),
        });
        Ok(())
    }

    fn pull_back(
        &mut self,
        d_states: &[f64],
        d_log_density: &[f64],
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError> {
        let (draw, covariance) = match (self.draws.pop(), &self.covariance) {
            (Some(draw), Some(covariance)) => (draw, covariance),
            _ => panic!("there is no draw left to pull back"),
        };
        let (proposal, compute) = (self.proposal, self.proposal.parameters.compute());
        let n = proposal.state_dim;
        let (d_representations, d_mixing) = covariance.pull_back(
            &draw.representation_values,
            &draw.lowers,
            &draw.noise,
            d_states,
            d_log_density,
        );
        self.gradients.add(proposal.mixing, compute.tensor(&d_mixing, [n, n]));

        // The scalar whose gradient is the vector–Jacobian product that is wanted.
        let shape = [self.particles, n];
        let weigh = |tensor: Tensor<2>, d: Tensor<2>| (tensor * d.autodiff()).sum();
        let mut scalar = weigh(draw.means, compute.tensor(d_states, shape))
            + weigh(draw.representations, compute.tensor(&d_representations, shape));
        for (tensor, d) in draw.hidden_out.into_iter().zip(self.d_hidden.drain(..)) {
            scalar = scalar + weigh(tensor, d);
        }
        let mut found = scalar.backward();
        self.gradients.gather(draw.weights, &mut found);
        self.d_hidden = draw
            .hidden_in
            .iter()
            .map(|tensor| {
                tensor.grad_remove(&mut found).unwrap_or_else(|| tensor.clone().inner().zeros_like())
            })
            .collect();
        d_previous.fill(0.0);
        if draw.time > 0
            && let Some(d) = draw.previous.grad_remove(&mut found)
        {
            d_previous.copy_from_slice(&to_host(d)?);
        }
        Ok(())
    }

    fn cut(&mut self) {
        self.d_hidden.clear();
    }

    fn into_gradients(self: Box<Self>) -> Gradients {
        self.gradients.finish()
    }
}
