//! The mean gradient of several sequences.

use std::ops::Range;

use motes_proposals::{GradientPart, Slice, Workspace};

/// Gradients of sequences one after another, added up in 64 bits.
pub(crate) struct GradientSum {
    /// One for each weight.
    sum: Vec<f64>,
    /// Of each matrix that has a gradient, where it lies among all weights.
    present: Vec<Option<Range<usize>>>,
}

impl GradientSum {
    /// Nothing yet, for `matrices` matrices of `weights` weights together.
    pub(crate) fn none(matrices: usize, weights: usize) -> Self {
        GradientSum { sum: vec![0.0; weights], present: vec![None; matrices] }
    }

    /// Adds the gradients that are in `workspace`, and takes them out of it.
    pub(crate) fn take(&mut self, workspace: &mut Workspace) {
        workspace.hand_over(|GradientPart { matrix, range, values }| {
            let sums = &mut self.sum[range.clone()];
            match values {
                Slice::F32(values) => {
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(*value));
                }
                Slice::F64(values) => sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value),
            }
            let whole = self.present[matrix].get_or_insert_with(|| range.clone());
            *whole = whole.start.min(range.start)..whole.end.max(range.end);
        });
    }

    /// Makes the gradients in `workspace`, those of the last of `count` sequences, the mean of all of them. The sum is then nothing again.
    pub(crate) fn mean_into(&mut self, workspace: &mut Workspace, count: usize) {
        let gradients = workspace.gradients();
        for (matrix, whole) in self.present.iter_mut().enumerate() {
            if let Some(whole) = whole.take() {
                gradients.add_wide(matrix, &self.sum[whole.clone()]);
                self.sum[whole].fill(0.0);
            }
        }
        gradients.scale(1.0 / count as f64);
    }
}
