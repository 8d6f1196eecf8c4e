//! What training uses again from step to step: gradients, and the memory that computing them takes.

use std::ops::Range;

use crate::gradients::Gradients;
use crate::native::{Multiply, Scratch};
use crate::parameters::Parameters;
use crate::values::{Real, Slice};

/// The gradients of some weights, with the memory that they were computed in; the next computation takes it over.
pub struct Workspace {
    gradients: Gradients,
    scratch: AnyScratch,
}

/// Memory of the native backend in either precision.
pub(crate) enum AnyScratch {
    /// None yet, or another backend's, which keeps it to itself.
    Nothing,
    Narrow(Scratch<f32>),
    Wide(Scratch<f64>),
}

/// Some of the gradients, in one piece.
#[derive(Debug, Clone)]
pub struct GradientPart<'a> {
    /// The index of the matrix that they belong to.
    pub matrix: usize,
    /// Where they belong among all weights, one matrix after another.
    pub range: Range<usize>,
    /// As many numbers.
    pub values: Slice<'a>,
}

/// A precision whose scratch memory can be told from that of the other.
pub(crate) trait ScratchPart: Multiply {
    fn unwrap(scratch: AnyScratch) -> Option<Scratch<Self>>;
    fn wrap(scratch: Scratch<Self>) -> AnyScratch;
}

impl ScratchPart for f32 {
    fn unwrap(scratch: AnyScratch) -> Option<Scratch<f32>> {
        if let AnyScratch::Narrow(scratch) = scratch { Some(scratch) } else { None }
    }

    fn wrap(scratch: Scratch<f32>) -> AnyScratch {
        AnyScratch::Narrow(scratch)
    }
}

impl ScratchPart for f64 {
    fn unwrap(scratch: AnyScratch) -> Option<Scratch<f64>> {
        if let AnyScratch::Wide(scratch) = scratch { Some(scratch) } else { None }
    }

    fn wrap(scratch: Scratch<f64>) -> AnyScratch {
        AnyScratch::Wide(scratch)
    }
}

impl From<Gradients> for Workspace {
    /// Gradients that were gathered elsewhere, with no memory beside them.
    fn from(gradients: Gradients) -> Self {
        Workspace { gradients, scratch: AnyScratch::Nothing }
    }
}

impl Workspace {
    /// An empty one for these weights.
    pub fn new(parameters: &Parameters) -> Self {
        Gradients::none(parameters).into()
    }

    /// Whether its gradients are laid out as these parameters, and in their precision.
    pub fn fits(&self, parameters: &Parameters) -> bool {
        self.gradients.fit(parameters)
    }

    /// The gradients of the last computation.
    pub fn gradients(&mut self) -> &mut Gradients {
        match &mut self.scratch {
            AnyScratch::Nothing => {}
            AnyScratch::Narrow(scratch) => scratch.multiply(&mut self.gradients),
            AnyScratch::Wide(scratch) => scratch.multiply(&mut self.gradients),
        }
        &mut self.gradients
    }

    /// The gradients alone.
    pub fn into_gradients(mut self) -> Gradients {
        self.gradients();
        self.gradients
    }

    /// The memory of the gradients, without any gradient in it yet: for who gathers them without a tape of networks.
    pub fn into_cleared_gradients(mut self) -> Gradients {
        self.gradients.clear();
        self.gradients
    }

    /// Hands over the gradients of the last computation, matrix by matrix in their order and each in as many parts as it is formed in;
    /// a part is gone when `take` returns. Where nothing asked for [`Workspace::gradients`] before, most of them are never
    /// written to memory.
    pub fn hand_over(&mut self, mut take: impl FnMut(GradientPart<'_>)) {
        for matrix in 0..self.gradients.matrices() {
            match &mut self.scratch {
                AnyScratch::Nothing => {}
                AnyScratch::Narrow(scratch) => {
                    scratch.hand_over(matrix, &mut self.gradients, &mut |range, values| {
                        take(GradientPart { matrix, range, values: f32::wrap_slice(values) });
                    });
                }
                AnyScratch::Wide(scratch) => {
                    scratch.hand_over(matrix, &mut self.gradients, &mut |range, values| {
                        take(GradientPart { matrix, range, values: f64::wrap_slice(values) });
                    });
                }
            }
            if let Some((range, values)) = self.gradients.stretch(matrix) {
                take(GradientPart { matrix, range, values });
            }
        }
        self.gradients.clear();
    }

    /// Gradients to be gathered anew, and memory.
    pub(crate) fn open<T: ScratchPart>(mut self, parameters: &Parameters) -> (Gradients, Scratch<T>) {
        self.gradients.clear();
        let mut scratch = T::unwrap(self.scratch).unwrap_or_else(|| Scratch::new(parameters.len()));
        scratch.clear();
        (self.gradients, scratch)
    }

    pub(crate) fn closed<T: ScratchPart>((gradients, scratch): (Gradients, Scratch<T>)) -> Self {
        Workspace { gradients, scratch: T::wrap(scratch) }
    }
}
