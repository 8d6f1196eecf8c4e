//! The fully connected proposal in training.

use burn::tensor::Tensor;
use motes_models::Stream;
use motes_smc::{Past, ProposalError};

use super::Fcnn;
use crate::backend::to_host;
use crate::covariance::KernelCovariance;
use crate::gaussian::{GaussianBatch, fill_standard_normal};
use crate::{Gradients, Learnable, Parameters, Tape};

impl Learnable for Fcnn {
    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    fn horizon(&self) -> Option<usize> {
        Some(self.means.len())
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
        Box::new(FcnnTape {
            proposal: self,
            particles,
            weights: self.parameters.tracked(),
            covariance: None,
            draws: Vec::new(),
            gradients: Gradients::none(self.parameters.len()),
        })
    }
}

/// Everything that the way back needs.
struct FcnnTape<'p> {
    proposal: &'p Fcnn,
    particles: usize,
    weights: Vec<Tensor<2>>,
    /// The same at all times; formed at the first draw, which can report an error.
    covariance: Option<KernelCovariance>,
    draws: Vec<Draw>,
    gradients: Gradients,
}

struct Draw {
    time: usize,
    inputs: Tensor<2>,
    means: Tensor<2>,
    representations: Tensor<2>,
    representation_values: Vec<f64>,
    lowers: Vec<f64>,
    noise: Vec<f64>,
}

impl Tape for FcnnTape<'_> {
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
        let shape = [self.particles, proposal.state_dim + proposal.measurement_dim];
        let inputs = proposal.parameters.compute().tensor(&proposal.inputs(&past)?, shape);
        let inputs = inputs.autodiff().require_grad();
        let means = proposal.means[past.time].forward(&self.weights, inputs.clone());
        let representations = proposal.representation.forward(&self.weights, inputs.clone());
        let representation_values = to_host(representations.clone().inner())?;
        let lowers = covariance.factors(&representation_values)?;
        let batch = GaussianBatch::new(proposal.state_dim, to_host(means.clone().inner())?, lowers);
        batch.transform(noise, states, log_density);
        self.covariance = Some(covariance);
        self.draws.push(Draw {
            time: past.time,
            inputs,
            means,
            representations,
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
        let (n, m) = (proposal.state_dim, proposal.measurement_dim);
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
        let seed = |tensor: Tensor<2>, d: &[f64]| (tensor * compute.tensor(d, shape)).sum();
        let scalar = seed(draw.means, d_states) + seed(draw.representations, &d_representations);
        let mut found = scalar.backward();
        let networks = [proposal.means[draw.time], proposal.representation];
        for index in networks.into_iter().flat_map(|network| network.indices()) {
            if let Some(gradient) = self.weights[index].grad_remove(&mut found) {
                self.gradients.add(index, gradient);
            }
        }
        d_previous.fill(0.0);
        if draw.time > 0
            && let Some(d_inputs) = draw.inputs.grad_remove(&mut found)
        {
            let d_inputs = to_host(d_inputs)?;
            for (d, d_input) in d_previous.chunks_exact_mut(n).zip(d_inputs.chunks_exact(n + m)) {
                d.copy_from_slice(&d_input[..n]);
            }
        }
        Ok(())
    }

    fn into_gradients(self: Box<Self>) -> Gradients {
        self.gradients
    }
}
