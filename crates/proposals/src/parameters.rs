//! A proposal's weights by name, and their gradients.

use burn::tensor::Tensor;
use motes_models::Seed;
use motes_smc::ProposalError;

use crate::backend::{Compute, to_host};
use crate::initial_weights::uniform;

/// The weights of a proposal: named matrices, in a fixed order.
#[derive(Clone)]
pub struct Parameters {
    compute: Compute,
    names: Vec<String>,
    values: Vec<Tensor<2>>,
}

impl Parameters {
    pub(crate) fn new(compute: Compute) -> Self {
        Parameters { compute, names: Vec::new(), values: Vec::new() }
    }

    /// Adds a `shape` matrix drawn uniformly from `±bound`, by the stream that `seed` has for its name.
    pub(crate) fn draw(&mut self, name: String, shape: [usize; 2], bound: f64, seed: &Seed) {
        let values = uniform(shape[0] * shape[1], bound, &mut seed.child(&name).stream());
        self.names.push(name);
        self.values.push(self.compute.tensor(&values, shape));
    }

    /// Where and in which precision the weights live.
    pub fn compute(&self) -> Compute {
        self.compute
    }

    /// Number of matrices.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no matrix.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The name of each matrix.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The matrices, for an optimiser to read.
    pub fn tensors(&self) -> &[Tensor<2>] {
        &self.values
    }

    /// Puts a matrix of the same shape in the place of matrix `index`.
    ///
    /// # Panics
    /// If there is no such matrix or its shape differs.
    pub fn replace(&mut self, index: usize, value: Tensor<2>) {
        assert_eq!(self.values[index].dims(), value.dims(), "a parameter keeps its shape");
        self.values[index] = value;
    }

    /// Matrix `index` on the host, row-major.
    ///
    /// # Errors
    /// [`ProposalError::Backend`] if the backend could not read it back.
    pub fn host(&self, index: usize) -> Result<Vec<f64>, ProposalError> {
        to_host(self.values[index].clone())
    }

    /// Sets matrix `index` from row-major host values.
    ///
    /// # Errors
    /// [`ProposalError::Mismatch`] if their number is not that of the matrix.
    pub fn set_host(&mut self, index: usize, values: &[f64]) -> Result<(), ProposalError> {
        let shape = self.values[index].dims();
        ProposalError::unless_same("the number of weights", values.len(), shape[0] * shape[1])?;
        self.values[index] = self.compute.tensor(values, shape);
        Ok(())
    }
}

/// The derivative of a scalar with respect to each matrix of some [`Parameters`], in their order.
#[derive(Clone)]
pub struct Gradients {
    values: Vec<Option<Tensor<2>>>,
}

impl Gradients {
    pub(crate) fn none(parameters: usize) -> Self {
        Gradients { values: vec![None; parameters] }
    }

    pub(crate) fn add(&mut self, index: usize, gradient: Tensor<2>) {
        self.values[index] = Some(match self.values[index].take() {
            None => gradient,
            Some(sum) => sum + gradient,
        });
    }

    /// The gradient of each matrix; `None` where the scalar does not depend on it.
    pub fn tensors(&self) -> &[Option<Tensor<2>>] {
        &self.values
    }

    /// Multiplies all of them by `factor`.
    pub fn scale(&mut self, factor: f64) {
        for gradient in self.values.iter_mut().flatten() {
            *gradient = gradient.clone() * factor;
        }
    }

    /// The Euclidean norm of all gradients taken together.
    ///
    /// # Errors
    /// [`ProposalError::Backend`] if the backend could not read it back.
    pub fn norm(&self) -> Result<f64, ProposalError> {
        let mut sum = 0.0;
        for gradient in self.values.iter().flatten() {
            let square = gradient.clone().square().sum().reshape([1, 1]);
            sum += to_host(square)?.iter().sum::<f64>();
        }
        if sum.is_finite() {
            return Ok(sum.sqrt());
        }
        // The squares may be too large for 32 bits where their root is not.
        let mut sum = 0.0;
        for gradient in self.values.iter().flatten() {
            sum += to_host(gradient.clone())?.iter().map(|value| value * value).sum::<f64>();
        }
        Ok(sum.sqrt())
    }
}
