//! Derivatives by burn's automatic differentiation, each step's graph cut off from those of the others.

use burn::tensor::Tensor;

use super::library::{Library, to_host};
use super::operations::{Operations, count};
use crate::error::NetworkError;
use crate::fit::{D_OUTPUTS, HIDDEN, OUTPUTS, check_inputs, unless_alike, unless_same};
use crate::gradients::Gradients;
use crate::networks::{Inputs, Known, Networks, Outputs};
use crate::parameters::Parameters;

/// The steps of a batch of particles, from `t = 0` on.
pub(crate) struct BurnTape<'p, F> {
    networks: &'p F,
    library: Library,
    weights: Vec<Tensor<2>>,
    gradients: Gradients,
    steps: Vec<Recorded>,
    particles: usize,
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
    outputs: Vec<Tensor<2>>,
}

impl<'p, F: Networks> BurnTape<'p, F> {
    pub(crate) fn new(
        library: Library,
        networks: &'p F,
        parameters: &Parameters,
        particles: usize,
        gradients: Gradients,
    ) -> Self {
        let zeros = |&width: &usize| library.tensor(&vec![0.0; particles * width], [particles, width]);
        BurnTape {
            weights: library.weights(parameters),
            gradients,
            steps: Vec::new(),
            particles,
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

impl<F: Networks> BurnTape<'_, F> {
    pub(crate) fn forward(
        &mut self,
        inputs: &Inputs<'_>,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), NetworkError> {
        check_inputs(self.networks, inputs)?;
        unless_same("the number of particles", inputs.particles, self.particles)?;
        let (previous, measurement) = self.library.known(inputs);
        let (previous, measurement) = (leaf(previous), measurement.autodiff());
        let hidden_in: Vec<Tensor<2>> = self.hidden.drain(..).map(leaf).collect();
        let weights: Vec<Tensor<2>> = self.weights.iter().cloned().map(leaf).collect();
        let known = Known { previous: previous.clone(), measurement, hidden: &hidden_in };
        let mut operations = Operations { library: &self.library, weights: &weights };
        let Outputs { values, hidden: hidden_out } =
            self.networks.forward(&mut operations, inputs.time, known);
        let places = outputs.iter().map(|output| output.len());
        let fits = unless_alike(OUTPUTS, places, values.iter().map(count))
            .and_then(|()| unless_alike(HIDDEN, hidden_out.iter().map(count), hidden_in.iter().map(count)));
        if let Err(error) = fits {
            self.hidden = hidden_in.into_iter().map(Tensor::inner).collect();
            return Err(error);
        }
        self.hidden = hidden_out.iter().map(|tensor| tensor.clone().inner()).collect();
        for (tensor, output) in values.iter().zip(outputs) {
            output.copy_from_slice(&to_host(tensor.clone().inner())?);
        }
        let (hidden_out, outputs) = (hidden_out.into_vec(), values.into_vec());
        self.steps.push(Recorded { weights, previous, hidden_in, hidden_out, outputs });
        Ok(())
    }

    pub(crate) fn backward(
        &mut self,
        d_outputs: &[&[f64]],
        d_previous: &mut [f64],
    ) -> Result<(), NetworkError> {
        let Some(last) = self.steps.last() else { panic!("there is no step left to pull back") };
        unless_alike(D_OUTPUTS, d_outputs.iter().map(|d| d.len()), last.outputs.iter().map(count))?;
        unless_same("the length of the derivative of x_{t−1}", d_previous.len(), count(&last.previous))?;
        let Some(recorded) = self.steps.pop() else { return Ok(()) };
        // The scalar whose gradient is the vector–Jacobian product that is wanted.
        let weigh = |tensor: Tensor<2>, d: Tensor<2>| (tensor * d.autodiff()).sum();
        let of_outputs = recorded.outputs.into_iter().zip(d_outputs).map(|(tensor, d)| {
            let shape = tensor.dims();
            weigh(tensor, self.library.tensor(d, shape))
        });
        let of_hidden = recorded.hidden_out.into_iter().zip(self.d_hidden.drain(..));
        let terms = of_outputs.chain(of_hidden.map(|(tensor, d)| weigh(tensor, d)));
        let Some(scalar) = terms.reduce(|sum, term| sum + term) else { panic!("networks have an output") };
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

    pub(crate) fn backward_to_weights(&mut self, d_outputs: &[&[f64]]) -> Result<(), NetworkError> {
        let width = self.steps.last().map_or(0, |last| count(&last.previous));
        self.backward(d_outputs, &mut vec![0.0; width])
    }

    pub(crate) fn detach(&mut self) {
        self.d_hidden.clear();
    }

    pub(crate) fn gradients(&mut self) -> &mut Gradients {
        &mut self.gradients
    }

    pub(crate) fn finish(self) -> Gradients {
        self.gradients
    }
}
