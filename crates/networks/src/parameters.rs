//! A proposal's weights by name.

use std::ops::Range;

use crate::backend::Compute;
use crate::error::NetworkError;
use crate::initial_weights::uniform;
use crate::values::{Real, Values};
use motes_models::Seed;

/// The weights of a proposal: named matrices in a fixed order, row-major, one after another in one piece of memory.
#[derive(Debug, Clone)]
pub struct Parameters {
    compute: Compute,
    names: Vec<String>,
    layout: Layout,
    values: Values,
}

/// Where each of several matrices lies in one piece of memory.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Layout {
    shapes: Vec<[usize; 2]>,
    /// Where each begins, and at the end where the last one ends.
    starts: Vec<usize>,
}

impl Layout {
    fn push(&mut self, shape: [usize; 2]) {
        self.starts.push(self.len());
        self.shapes.push(shape);
    }

    /// How many numbers the matrices are in all.
    pub(crate) fn len(&self) -> usize {
        match (self.starts.last(), self.shapes.last()) {
            (Some(start), Some([rows, columns])) => start + rows * columns,
            _ => 0,
        }
    }

    /// How many matrices there are.
    pub(crate) fn matrices(&self) -> usize {
        self.shapes.len()
    }

    /// Rows and columns of a matrix.
    pub(crate) fn shape(&self, index: usize) -> [usize; 2] {
        self.shapes[index]
    }

    /// The place of a matrix.
    pub(crate) fn range(&self, index: usize) -> Range<usize> {
        let [rows, columns] = self.shapes[index];
        self.starts[index]..self.starts[index] + rows * columns
    }
}

impl Parameters {
    /// No weights yet.
    pub fn new(compute: Compute) -> Self {
        let values = Values::none(compute.precision);
        Parameters { compute, names: Vec::new(), layout: Layout::default(), values }
    }

    /// Adds a `shape` matrix drawn uniformly from `±bound`, by the stream that `seed` has for its name.
    pub fn draw(&mut self, name: String, shape: [usize; 2], bound: f64, seed: &Seed) {
        self.values.push_all(&uniform(shape[0] * shape[1], bound, &mut seed.child(&name).stream()));
        self.names.push(name);
        self.layout.push(shape);
    }

    /// Adds a `shape` matrix with the given values, row-major.
    ///
    /// # Panics
    /// If they are not as many as the matrix has entries.
    pub fn add(&mut self, name: String, shape: [usize; 2], values: &[f64]) {
        assert_eq!(shape[0] * shape[1], values.len(), "the values of matrix {name}");
        self.values.push_all(values);
        self.names.push(name);
        self.layout.push(shape);
    }

    /// What computes with the weights, and in which precision they are kept.
    pub fn compute(&self) -> Compute {
        self.compute
    }

    /// Number of matrices.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there is no matrix.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The name of each matrix.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Rows and columns of matrix `index`.
    ///
    /// # Panics
    /// If there is no such matrix.
    pub fn shape(&self, index: usize) -> [usize; 2] {
        self.layout.shape(index)
    }

    /// Matrix `index` in 64 bits, row-major.
    ///
    /// # Panics
    /// If there is no such matrix.
    pub fn host(&self, index: usize) -> Vec<f64> {
        self.values.host(self.layout.range(index))
    }

    /// Sets matrix `index` from row-major values, rounding them to the precision of the weights.
    ///
    /// # Errors
    /// [`NetworkError::Weights`] if their number is not that of the matrix.
    ///
    /// # Panics
    /// If there is no such matrix.
    pub fn set_host(&mut self, index: usize, values: &[f64]) -> Result<(), NetworkError> {
        let range = self.layout.range(index);
        if values.len() != range.len() {
            return Err(NetworkError::Weights { found: values.len(), expected: range.len() });
        }
        self.values.set(range.start, values);
        Ok(())
    }

    /// Multiplies row `r` of matrix `index` by factor `r mod H`, of `H` factors.
    ///
    /// # Panics
    /// If there is no such matrix.
    pub fn scale_rows(&mut self, index: usize, factors: &[f64]) {
        let [_, columns] = self.layout.shape(index);
        self.values.scale_rows(self.layout.range(index), columns, factors);
    }

    /// All weights, one matrix after another, in their own precision.
    pub fn values(&self) -> &Values {
        &self.values
    }

    /// All weights, one matrix after another, for an optimiser to change.
    pub fn values_mut(&mut self) -> &mut Values {
        &mut self.values
    }

    pub(crate) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The matrices in their own type.
    pub(crate) fn matrices<T: Real>(&self) -> Matrices<'_, T> {
        Matrices { layout: &self.layout, values: T::slice(&self.values) }
    }
}

/// Matrices to be looked up.
#[derive(Clone, Copy)]
pub(crate) struct Matrices<'a, T> {
    layout: &'a Layout,
    values: &'a [T],
}

impl<'a, T> Matrices<'a, T> {
    /// Rows and columns.
    pub(crate) fn shape(&self, index: usize) -> [usize; 2] {
        self.layout.shape(index)
    }

    /// The entries, row-major.
    pub(crate) fn get(&self, index: usize) -> &'a [T] {
        &self.values[self.layout.range(index)]
    }
}
