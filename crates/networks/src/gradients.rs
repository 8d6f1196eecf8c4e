//! The derivative of a scalar with respect to a proposal's weights.

use std::mem::discriminant;
use std::ops::Range;

use faer::Accum;

use crate::parameters::{Layout, Parameters};
use crate::values::{Real, Slice, Values, narrow};

/// The derivative of a scalar with respect to each matrix of some [`Parameters`], laid out as these are.
#[derive(Debug, Clone)]
pub struct Gradients {
    layout: Layout,
    values: Values,
    /// Which matrices the scalar depends on; the places of the others hold nothing of meaning.
    present: Vec<bool>,
}

impl Gradients {
    /// None of `parameters` yet.
    pub fn none(parameters: &Parameters) -> Self {
        let layout = parameters.layout().clone();
        Gradients {
            values: parameters.values().zeros_like(layout.len()),
            present: vec![false; layout.matrices()],
            layout,
        }
    }

    /// Whether they are laid out as these parameters, and in their precision.
    pub(crate) fn fit(&self, parameters: &Parameters) -> bool {
        self.layout == *parameters.layout() && discriminant(&self.values) == discriminant(parameters.values())
    }

    /// Forgets all of them, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.present.fill(false);
    }

    /// The place of a matrix's gradient, and whether what is there is to be added to or to be replaced.
    pub(crate) fn place<T: Real>(&mut self, index: usize) -> (&mut [T], Accum) {
        let accum = if self.present[index] { Accum::Add } else { Accum::Replace };
        self.present[index] = true;
        (&mut T::slice_mut(&mut self.values)[self.layout.range(index)], accum)
    }

    /// Adds to the gradient of a matrix what was computed in 64 bits.
    ///
    /// # Panics
    /// If there is no such matrix, or it is of another size.
    pub fn add_wide(&mut self, index: usize, gradient: &[f64]) {
        fn add<T: Real>(gradients: &mut Gradients, index: usize, gradient: &[f64]) {
            match gradients.place::<T>(index) {
                (place, Accum::Replace) => narrow(gradient, place),
                (place, Accum::Add) => {
                    place.iter_mut().zip(gradient).for_each(|(sum, &term)| *sum += T::of(term));
                }
            }
        }
        match self.values {
            Values::F32(_) => add::<f32>(self, index, gradient),
            Values::F64(_) => add::<f64>(self, index, gradient),
        }
    }

    /// The gradient of matrix `index`, row-major; `None` where the scalar does not depend on it.
    ///
    /// # Panics
    /// If there is no such matrix.
    pub fn host(&self, index: usize) -> Option<Vec<f64>> {
        self.present[index].then(|| self.values.host(self.layout.range(index)))
    }

    /// How many matrices there are.
    pub(crate) fn matrices(&self) -> usize {
        self.present.len()
    }

    /// Whether the scalar depends on a matrix.
    ///
    /// # Panics
    /// If there is no such matrix.
    pub fn has(&self, index: usize) -> bool {
        self.present[index]
    }

    /// The place of a matrix among all.
    pub(crate) fn range(&self, index: usize) -> Range<usize> {
        self.layout.range(index)
    }

    /// The gradient of a matrix and its place among all, if there is one.
    pub(crate) fn stretch(&self, index: usize) -> Option<(Range<usize>, Slice<'_>)> {
        let range = self.range(index);
        self.present[index].then(|| {
            let values = match &self.values {
                Values::F32(values) => Slice::F32(&values[range.clone()]),
                Values::F64(values) => Slice::F64(&values[range.clone()]),
            };
            (range, values)
        })
    }

    /// Multiplies row `r` of the gradient of a matrix by factor `r mod H`, of `H` factors; nothing where the scalar does not depend on the matrix.
    ///
    /// # Panics
    /// If there is no such matrix.
    pub fn scale_rows(&mut self, index: usize, factors: &[f64]) {
        if self.present[index] {
            let [_, columns] = self.layout.shape(index);
            self.values.scale_rows(self.layout.range(index), columns, factors);
        }
    }

    /// Multiplies all of them by `factor`.
    pub fn scale(&mut self, factor: f64) {
        match &mut self.values {
            Values::F32(values) => values.iter_mut().for_each(|value| *value *= factor as f32),
            Values::F64(values) => values.iter_mut().for_each(|value| *value *= factor),
        }
    }

    /// The Euclidean norm of all gradients taken together.
    pub fn norm(&self) -> f64 {
        fn squares<T: Real>(values: &[T]) -> f64 {
            values.iter().map(|value| value.wide() * value.wide()).sum()
        }
        let stretches = (0..self.matrices()).filter_map(|index| self.stretch(index));
        let sum: f64 = stretches
            .map(|(_, values)| match values {
                Slice::F32(values) => squares(values),
                Slice::F64(values) => squares(values),
            })
            .sum();
        sum.sqrt()
    }
}
