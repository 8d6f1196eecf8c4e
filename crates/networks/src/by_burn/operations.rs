//! The operations of networks, each handed to burn.

use burn::tensor::Tensor;

use super::library::{Library, to_host};
use crate::arithmetic::{Activation, Arithmetic};
use crate::error::NetworkError;
use crate::fit::{HIDDEN, OUTPUTS, unless_alike};
use crate::graph::{Graph, Shape};
use crate::networks::{Inputs, Known, Networks};
use crate::parameters::Parameters;
use crate::values::{SliceMut, narrow, widen};

/// Each output (`R×width`) of particles that carry `hidden`, which is advanced.
///
/// Inputs and hidden values have been checked; of at least one particle. All weights are made into tensors of burn's at each call, that is
/// for each block of particles: a second opinion keeps nothing from call to call.
///
/// # Errors
/// [`NetworkError::Backend`] if burn failed, [`NetworkError::Shape`] if the networks emit something else than there are places for.
pub(crate) fn infer<F: Networks>(
    library: &Library,
    networks: &F,
    parameters: &Parameters,
    inputs: &Inputs<'_>,
    hidden: &mut [SliceMut<'_>],
    outputs: &mut [&mut [f64]],
) -> Result<(), NetworkError> {
    let weights = library.weights(parameters);
    let (previous, measurement) = library.known(inputs);
    let carried = |values: &SliceMut<'_>| {
        let mut wide = vec![0.0; values.len()];
        match values {
            SliceMut::F32(values) => widen(values, &mut wide),
            SliceMut::F64(values) => widen(values, &mut wide),
        }
        library.tensor(&wide, [inputs.particles, wide.len() / inputs.particles])
    };
    let hidden_in: Vec<Tensor<2>> = hidden.iter().map(carried).collect();
    let mut operations = Operations { library, weights: &weights };
    let found =
        networks.forward(&mut operations, inputs.time, Known { previous, measurement, hidden: &hidden_in });
    unless_alike(OUTPUTS, outputs.iter().map(|output| output.len()), found.values.iter().map(count))?;
    unless_alike(HIDDEN, hidden.iter().map(SliceMut::len), found.hidden.iter().map(count))?;
    for (tensor, output) in found.values.into_iter().zip(outputs) {
        output.copy_from_slice(&to_host(tensor)?);
    }
    for (values, advanced) in hidden.iter_mut().zip(found.hidden) {
        let advanced = to_host(advanced)?;
        match values {
            SliceMut::F32(values) => narrow(&advanced, values),
            SliceMut::F64(values) => narrow(&advanced, values),
        }
    }
    Ok(())
}

/// How many numbers a tensor has.
pub(super) fn count(tensor: &Tensor<2>) -> usize {
    tensor.dims().iter().product()
}

/// Computes one step.
pub(super) struct Operations<'a> {
    pub(super) library: &'a Library,
    pub(super) weights: &'a [Tensor<2>],
}

impl Operations<'_> {
    fn weight(&self, index: usize) -> Tensor<2> {
        self.weights[index].clone()
    }
}

fn activate(values: Tensor<2>, activation: Activation) -> Tensor<2> {
    match activation {
        Activation::Linear => values,
        Activation::Tanh => values.tanh(),
    }
}

/// `σ(a) = (1 + tanh(a/2)) / 2`, which backends compute alike where their own logistic functions differ.
fn sigmoid(values: Tensor<2>) -> Tensor<2> {
    (values * 0.5).tanh() * 0.5 + 0.5
}

/// Some blocks of `width` columns.
fn blocks(tensor: &Tensor<2>, width: usize, first: usize, count: usize) -> Tensor<2> {
    tensor.clone().narrow(1, first * width, count * width)
}

impl Arithmetic for Operations<'_> {
    type Rows = Tensor<2>;

    fn stacked(&mut self, previous: &Tensor<2>, measurement: &Tensor<2>) -> Tensor<2> {
        let measurements = measurement.clone().repeat_dim(0, previous.dims()[0]);
        Tensor::cat(vec![previous.clone(), measurements], 1)
    }

    fn affine(
        &mut self,
        inputs: &[(&Tensor<2>, usize)],
        bias: Option<usize>,
        activation: Activation,
    ) -> Tensor<2> {
        let products = inputs.iter().map(|(input, weight)| (*input).clone().matmul(self.weight(*weight)));
        let Some(sum) = products.reduce(|sum, product| sum + product) else {
            panic!("an affine map has an input")
        };
        let sum = match bias {
            Some(bias) => sum + self.weight(bias),
            None => sum,
        };
        activate(sum, activation)
    }

    fn lstm(&mut self, gates: Tensor<2>, cells: &Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let h = cells.dims()[1];
        let (input, forget) = (sigmoid(blocks(&gates, h, 0, 1)), sigmoid(blocks(&gates, h, 1, 1)));
        let (new, output) = (blocks(&gates, h, 2, 1).tanh(), sigmoid(blocks(&gates, h, 3, 1)));
        let next = forget * cells.clone() + input * new;
        (output * next.clone().tanh(), next)
    }

    fn gru(
        &mut self,
        from_input: &Tensor<2>,
        from_hidden: &Tensor<2>,
        offset: usize,
        hidden: &Tensor<2>,
    ) -> Tensor<2> {
        let h = hidden.dims()[1];
        let gates = sigmoid(blocks(from_input, h, 0, 2) + blocks(from_hidden, h, 0, 2));
        let (reset, keep) = (blocks(&gates, h, 0, 1), blocks(&gates, h, 1, 1));
        let inner = blocks(from_hidden, h, 2, 1) + self.weight(offset);
        let candidate = (blocks(from_input, h, 2, 1) + reset * inner).tanh();
        // (1 − s) ∘ ĥ + s ∘ h
        candidate.clone() + keep * (hidden.clone() - candidate)
    }

    fn at_nodes(
        &mut self,
        previous: &Tensor<2>,
        measurement: &Tensor<2>,
        graph: &Graph,
        adapter: Option<usize>,
    ) -> Tensor<2> {
        let [particles, nodes] = previous.dims();
        let column = |by_node: Tensor<2>| by_node.reshape([nodes * particles, 1]);
        let states = column(previous.clone().transpose());
        let adapter = match adapter {
            Some(index) => self.weight(index),
            None => self.library.matrix(graph.adapter()),
        };
        let at_nodes = adapter.matmul(measurement.clone().transpose());
        Tensor::cat(vec![states, column(at_nodes.repeat_dim(1, particles))], 1)
    }

    fn blocks_at_nodes(
        &mut self,
        inputs: &Tensor<2>,
        graph: &Graph,
        states: usize,
        measurements: usize,
    ) -> Tensor<2> {
        let particles = inputs.dims()[0];
        let adapter = self.library.matrix(graph.adapter());
        let [nodes, m] = adapter.dims();
        let column = |by_node: Tensor<2>| by_node.reshape([nodes * particles, 1]);
        let own = (0..states).map(|at| column(inputs.clone().narrow(1, at * nodes, nodes).transpose()));
        let heard = (0..measurements).map(|at| {
            let block = inputs.clone().narrow(1, states * nodes + at * m, m);
            column(adapter.clone().matmul(block.transpose()))
        });
        Tensor::cat(own.chain(heard).collect(), 1)
    }

    fn graph_filter(
        &mut self,
        graph: &Graph,
        values: &Tensor<2>,
        shape: Shape,
        taps: usize,
        activation: Activation,
    ) -> Tensor<2> {
        let (matrix, shift) = (self.weight(taps), self.library.matrix(graph.shift()));
        let [rows, features] = values.dims();
        let nodes = shift.dims()[0];
        let mut shifted = values.clone();
        let mut sum = self.weight(taps + 1).repeat_dim(0, rows);
        for tap in 0..shape.taps {
            if tap > 0 {
                // S X for each particle: the rows are node by node, so all particles are one product.
                let wide = shifted.reshape([nodes, rows / nodes * features]);
                shifted = shift.clone().matmul(wide).reshape([rows, features]);
            }
            let weights = matrix.clone().narrow(0, tap * shape.inputs, shape.inputs);
            sum = sum + shifted.clone().matmul(weights);
        }
        activate(sum, activation)
    }

    fn by_particle(&mut self, values: &Tensor<2>, nodes: usize) -> Tensor<2> {
        let [rows, features] = values.dims();
        let particles = rows / nodes;
        let grouped: Tensor<3> = values.clone().reshape([nodes, particles, features]);
        grouped.swap_dims(0, 1).reshape([particles, nodes * features])
    }
}
