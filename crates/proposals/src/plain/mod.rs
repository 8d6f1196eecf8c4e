//! Networks computed by burn, operation by operation, with its automatic differentiation: what the native backend is held against.

mod tape;

pub(crate) use tape::PlainTape;

use burn::tensor::{DType, Device, Tensor, TensorData};
use faer::Mat;
use motes_smc::{Past, ProposalError};

use crate::arithmetic::{Activation, Arithmetic};
use crate::gaussian::{Known, Networks};
use crate::gnn::{Graph, Shape};
use crate::values::Values;
use crate::{Backend, Parameters, Precision};

/// A device of burn's with a precision: all that is needed to make a tensor.
#[derive(Clone)]
pub(crate) struct Library {
    device: Device,
    precision: Precision,
}

impl Library {
    /// The one that was asked for; `None` if the host computes by itself. Nothing depends on burn's idea of a default device.
    pub(crate) fn of(parameters: &Parameters) -> Option<Self> {
        let compute = parameters.compute();
        let device = match compute.backend {
            Backend::Native => return None,
            Backend::Flex => Device::flex(),
            #[allow(deprecated, reason = "kept on purpose, see `Backend::NdArray`")]
            Backend::NdArray => Device::ndarray(),
        };
        Some(Library { device, precision: compute.precision })
    }

    /// A constant `rows×columns` tensor from row-major values.
    fn tensor(&self, values: &[f64], shape: [usize; 2]) -> Tensor<2> {
        match self.precision {
            Precision::F32 => {
                let narrow: Vec<f32> = values.iter().map(|&value| value as f32).collect();
                Tensor::from_data(TensorData::new(narrow, shape), (&self.device, DType::F32))
            }
            Precision::F64 => {
                Tensor::from_data(TensorData::new(values.to_vec(), shape), (&self.device, DType::F64))
            }
        }
    }

    fn matrix(&self, matrix: &Mat<f64>) -> Tensor<2> {
        let (rows, columns) = (matrix.nrows(), matrix.ncols());
        let values: Vec<f64> = (0..rows * columns).map(|at| matrix[(at / columns, at % columns)]).collect();
        self.tensor(&values, [rows, columns])
    }

    fn weights(&self, parameters: &Parameters) -> Vec<Tensor<2>> {
        (0..parameters.len()).map(|at| self.tensor(&parameters.host(at), parameters.shape(at))).collect()
    }

    /// `x_{t−1}` (zeros at `t = 0`) and `y_t`.
    fn known(&self, past: &Past<'_>, width: usize) -> (Tensor<2>, Tensor<2>) {
        let shape = [past.particles, width];
        let previous = match past.previous {
            Some(previous) => self.tensor(previous, shape),
            None => self.tensor(&vec![0.0; past.particles * width], shape),
        };
        (previous, self.tensor(past.measurement, [1, past.measurement.len()]))
    }
}

/// Reads a tensor back, row-major.
fn to_host(tensor: Tensor<2>) -> Result<Vec<f64>, ProposalError> {
    tensor.try_into_vec_as::<f64>().map_err(|error| ProposalError::Backend { reason: error.to_string() })
}

/// Means and representations (`R×N` each) of particles that carry `hidden`, which is advanced.
pub(crate) fn infer<F: Networks>(
    library: &Library,
    networks: &F,
    parameters: &Parameters,
    past: &Past<'_>,
    hidden: &mut [Values],
    means: &mut [f64],
    representations: &mut [f64],
) -> Result<(), ProposalError> {
    let weights = library.weights(parameters);
    let rows = past.particles;
    let (previous, measurement) = library.known(past, means.len() / rows.max(1));
    let carried =
        |values: &Values| library.tensor(&values.host(0..values.len()), [rows, values.len() / rows]);
    let hidden_in: Vec<Tensor<2>> = hidden.iter().map(carried).collect();
    let mut plain = Plain { library, weights: &weights };
    let emission =
        networks.forward(&mut plain, past.time, Known { previous, measurement, hidden: &hidden_in });
    means.copy_from_slice(&to_host(emission.means)?);
    representations.copy_from_slice(&to_host(emission.representations)?);
    for (values, advanced) in hidden.iter_mut().zip(emission.hidden) {
        values.set(0, &to_host(advanced)?);
    }
    Ok(())
}

/// Computes one step.
struct Plain<'a> {
    library: &'a Library,
    weights: &'a [Tensor<2>],
}

impl Plain<'_> {
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

impl Arithmetic for Plain<'_> {
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
        let particles = values.dims()[0] / nodes;
        values.clone().reshape([nodes, particles]).transpose()
    }
}
