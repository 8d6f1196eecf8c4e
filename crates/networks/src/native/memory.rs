//! Memory that the native backend uses again from training step to training step.

use std::ops::Range;

use super::buffers::Buffers;
use super::gradient_accumulator::GradientAccumulator;
use super::products::Multiply;
use super::step::Step;
use crate::gradients::Gradients;

/// What one computation of gradients leaves to the next.
pub(crate) struct Scratch<T> {
    pub(super) buffers: Buffers<T>,
    pub(super) accumulator: GradientAccumulator<T>,
    pub(super) steps: Vec<Step<T>>,
    pub(super) d_nodes: Vec<Option<Vec<T>>>,
}

impl<T: Multiply> Scratch<T> {
    /// Memory for gradients of so many matrices, none of it allocated.
    pub(crate) fn new(matrices: usize) -> Self {
        Scratch {
            buffers: Buffers::default(),
            accumulator: GradientAccumulator::none(matrices),
            steps: Vec::new(),
            d_nodes: Vec::new(),
        }
    }

    /// Forgets what an abandoned computation left.
    pub(crate) fn clear(&mut self) {
        self.accumulator.clear();
    }

    /// Adds all rows that wait to the gradients.
    pub(crate) fn multiply(&mut self, gradients: &mut Gradients) {
        self.accumulator.multiply(&mut self.buffers, gradients);
    }

    /// Hands over what waits for a matrix, unless there already is a gradient that it is to be added to.
    pub(crate) fn hand_over(
        &mut self,
        matrix: usize,
        gradients: &mut Gradients,
        take: &mut impl FnMut(Range<usize>, &[T]),
    ) {
        if gradients.has(matrix) {
            return self.accumulator.multiply_one(matrix, &mut self.buffers, gradients);
        }
        let start = gradients.range(matrix).start;
        self.accumulator.hand_over(matrix, &mut self.buffers, &mut |at, values| {
            take(start + at..start + at + values.len(), values);
        });
    }
}
