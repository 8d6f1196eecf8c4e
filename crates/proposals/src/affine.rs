//! Weights in use: how networks read them, and how their gradients are gathered where a derivative is wanted.

use burn::tensor::{Gradients as Found, Tensor};

use crate::Gradients;

/// A proposal's weights while its networks compute one step.
///
/// Without derivatives it only looks matrices up. With derivatives it also writes down what the gradients are made of:
/// the input of each affine map, and a zero added to its output, whose gradient is that of the output. The gradient of a
/// matrix that is used at many times is then one product of many rows instead of a sum of as many matrices.
pub struct Weights<'a> {
    tensors: &'a [Tensor<2>],
    record: Option<Record>,
}

/// What one step's gradients are made of.
#[derive(Default)]
pub(crate) struct Record {
    sites: Vec<Site>,
    leaves: Vec<(usize, Tensor<2>)>,
}

/// One affine map that was computed.
struct Site {
    weight: usize,
    bias: Option<usize>,
    input: Tensor<2>,
    output: Tensor<2>,
}

impl<'a> Weights<'a> {
    /// For computing alone.
    pub(crate) fn plain(tensors: &'a [Tensor<2>]) -> Self {
        Weights { tensors, record: None }
    }

    /// For computing with derivatives to come.
    pub(crate) fn recorded(tensors: &'a [Tensor<2>]) -> Self {
        Weights { tensors, record: Some(Record::default()) }
    }

    /// What was written down.
    pub(crate) fn into_record(self) -> Record {
        self.record.unwrap_or_default()
    }

    /// Rows and columns of a matrix.
    pub fn dims(&self, index: usize) -> [usize; 2] {
        self.tensors[index].dims()
    }

    /// `input · W + b`, with `W` and `b` by their indices among the parameters.
    pub fn affine(&mut self, input: Tensor<2>, weight: usize, bias: Option<usize>) -> Tensor<2> {
        // (Wᵀ inputᵀ)ᵀ: the matrix product that burn stands on copies its left factor into another order where it must, and
        // here that is the smaller one, forward and backward.
        let product = self.tensors[weight].clone().transpose().matmul(input.clone().transpose()).transpose();
        let output = match bias {
            Some(bias) => product + self.tensors[bias].clone(),
            None => product,
        };
        let Some(record) = &mut self.record else { return output };
        let zero = output.clone().inner().zeros_like().autodiff().require_grad();
        let output = output + zero.clone();
        record.sites.push(Site { weight, bias, input: input.inner(), output: zero });
        output
    }

    /// A matrix for any other use than [`Weights::affine`], which is cheaper.
    pub fn matrix(&mut self, index: usize) -> Tensor<2> {
        let Some(record) = &mut self.record else { return self.tensors[index].clone() };
        let leaf = self.tensors[index].clone().autodiff().require_grad();
        record.leaves.push((index, leaf.clone()));
        leaf
    }
}

/// Inputs and derivatives of outputs of the affine maps with one matrix, waiting to be multiplied.
struct Waiting {
    bias: Option<usize>,
    rows: usize,
    inputs: Vec<Tensor<2>>,
    d_outputs: Vec<Tensor<2>>,
}

/// Gradients being gathered from many steps.
pub(crate) struct Gathering {
    gradients: Gradients,
    /// By the index of the matrix.
    waiting: Vec<Option<Waiting>>,
}

/// From this many rows on a product is worth its while, and memory stays bounded however long the sequence.
const ROWS: usize = 2048;

impl Gathering {
    pub(crate) fn none(parameters: usize) -> Self {
        Gathering { gradients: Gradients::none(parameters), waiting: (0..parameters).map(|_| None).collect() }
    }

    /// Adds a gradient that is known already.
    pub(crate) fn add(&mut self, index: usize, gradient: Tensor<2>) {
        self.gradients.add(index, gradient);
    }

    /// Adds the gradients of one step.
    pub(crate) fn gather(&mut self, record: Record, found: &mut Found) {
        for (index, leaf) in record.leaves {
            if let Some(gradient) = leaf.grad_remove(found) {
                self.gradients.add(index, gradient);
            }
        }
        for Site { weight, bias, input, output } in record.sites {
            let Some(d_output) = output.grad_remove(found) else { continue };
            let nothing = || Waiting { bias, rows: 0, inputs: Vec::new(), d_outputs: Vec::new() };
            let waiting = self.waiting[weight].get_or_insert_with(nothing);
            waiting.rows += input.dims()[0];
            waiting.inputs.push(input);
            waiting.d_outputs.push(d_output);
            if waiting.rows >= ROWS {
                self.multiply(weight);
            }
        }
    }

    /// `W̄ = inputsᵀ · d_outputs` and `b̄ = Σ_rows d_outputs` of what waits for one matrix.
    fn multiply(&mut self, weight: usize) {
        let Some(Waiting { bias, inputs, d_outputs, .. }) = self.waiting[weight].take() else { return };
        let d_outputs = stacked(d_outputs);
        self.gradients.add(weight, stacked(inputs).transpose().matmul(d_outputs.clone()));
        if let Some(bias) = bias {
            self.gradients.add(bias, d_outputs.sum_dim(0));
        }
    }

    pub(crate) fn finish(mut self) -> Gradients {
        (0..self.waiting.len()).for_each(|weight| self.multiply(weight));
        self.gradients
    }
}

fn stacked(mut rows: Vec<Tensor<2>>) -> Tensor<2> {
    if rows.len() == 1 { rows.remove(0) } else { Tensor::cat(rows, 0) }
}
