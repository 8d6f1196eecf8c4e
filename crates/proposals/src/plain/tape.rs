//! Derivatives by burn's automatic differentiation, each step's graph cut off from those of the others.

use burn::tensor::Tensor;
use motes_smc::{Past, ProposalError};

use super::{Library, Plain, to_host};
use crate::gaussian::{Known, NetworkTape, Networks};
use crate::workspace::Workspace;
use crate::{Gradients, Parameters};

/// The steps of a batch of particles, from `t = 0` on.
pub(crate) struct PlainTape<'p, F> {
    networks: &'p F,
    library: Library,
    weights: Vec<Tensor<2>>,
    gradients: Gradients,
    steps: Vec<Recorded>,
    /// What the particles carry into the next step.
    hidden: Vec<Tensor<2>>,
    /// The derivative with respect to what they carried out of the last step not yet undone; empty if it is zero.
    d_hidden: Vec<Tensor<2>>,
}

struct Recorded {
    weights: Vec<Tensor<2>>,
    previous: Tensor<2>,
    hidden_in: Vec<Tensor<2>>,
    hidden_out: Vec<Tensor<2>>,
    means: Tensor<2>,
    representations: Tensor<2>,
}

impl<'p, F: Networks> PlainTape<'p, F> {
    pub(crate) fn new(
        library: Library,
        networks: &'p F,
        parameters: &Parameters,
        particles: usize,
        workspace: Workspace,
    ) -> Self {
        let zeros = |&width: &usize| library.tensor(&vec![0.0; particles * width], [particles, width]);
        PlainTape {
            weights: library.weights(parameters),
            gradients: workspace.open_gradients(),
            steps: Vec::new(),
            hidden: networks.hidden_widths().iter().map(zeros).collect(),
            d_hidden: Vec::new(),
            networks,
            library,
        }
    }
}

fn leaf(tensor: Tensor<2>) -> Tensor<2> {
    tensor.autodiff().require_grad()
}

impl<F: Networks> NetworkTape for PlainTape<'_, F> {
    fn forward(
        &mut self,
        past: &Past<'_>,
        width: usize,
        means: &mut [f64],
        representations: &mut [f64],
    ) -> Result<(), ProposalError> {
        let (previous, measurement) = self.library.known(past, width);
        let (previous, measurement) = (leaf(previous), measurement.autodiff());
        let hidden_in: Vec<Tensor<2>> = self.hidden.drain(..).map(leaf).collect();
        let weights: Vec<Tensor<2>> = self.weights.iter().cloned().map(leaf).collect();
        let known = Known { previous: previous.clone(), measurement, hidden: &hidden_in };
        let mut plain = Plain { library: &self.library, weights: &weights };
        let emission = self.networks.forward(&mut plain, past.time, known);
        self.hidden = emission.hidden.iter().map(|tensor| tensor.clone().inner()).collect();
        means.copy_from_slice(&to_host(emission.means.clone().inner())?);
        representations.copy_from_slice(&to_host(emission.representations.clone().inner())?);
        let crate::gaussian::Emission { means, representations, hidden: hidden_out } = emission;
        self.steps.push(Recorded { weights, previous, hidden_in, hidden_out, means, representations });
        Ok(())
    }

    fn backward(
        &mut self,
        d_means: &[f64],
        d_representations: &[f64],
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError> {
        let Some(recorded) = self.steps.pop() else { panic!("there is no step left to pull back") };
        // The scalar whose gradient is the vector–Jacobian product that is wanted.
        let shape = recorded.means.dims();
        let weigh = |tensor: Tensor<2>, d: Tensor<2>| (tensor * d.autodiff()).sum();
        let mut scalar = weigh(recorded.means, self.library.tensor(d_means, shape))
            + weigh(recorded.representations, self.library.tensor(d_representations, shape));
        for (tensor, d) in recorded.hidden_out.into_iter().zip(self.d_hidden.drain(..)) {
            scalar = scalar + weigh(tensor, d);
        }
        let mut found = scalar.backward();
        for (index, weight) in recorded.weights.iter().enumerate() {
            if let Some(gradient) = weight.grad_remove(&mut found) {
                self.gradients.add_wide(index, &to_host(gradient)?);
            }
        }
        let gradient_of = |tensor: &Tensor<2>, found: &mut _| {
            tensor.grad_remove(found).unwrap_or_else(|| tensor.clone().inner().zeros_like())
        };
        self.d_hidden = recorded.hidden_in.iter().map(|tensor| gradient_of(tensor, &mut found)).collect();
        d_previous.copy_from_slice(&to_host(gradient_of(&recorded.previous, &mut found))?);
        Ok(())
    }

    fn cut(&mut self) {
        self.d_hidden.clear();
    }

    fn gradients(&mut self) -> &mut Gradients {
        &mut self.gradients
    }

    fn finish(self: Box<Self>) -> Workspace {
        Workspace::closed_gradients(self.gradients)
    }
}
