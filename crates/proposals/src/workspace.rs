//! What training uses again from step to step: gradients, and the memory that computing them takes.

use std::ops::Range;

use crate::native::{Buffers, Step, Waiting};
use crate::values::{Real, Slice};
use crate::{Gradients, Parameters};

/// The gradients of a proposal's weights, with the memory that they were computed in; the next computation takes it over.
pub struct Workspace {
    gradients: Gradients,
    scratch: Scratch,
}

/// Memory of the native backend.
pub(crate) enum Scratch {
    /// None yet, or another backend's, which keeps it to itself.
    Nothing,
    Narrow(ForNative<f32>),
    Wide(ForNative<f64>),
}

/// What the native backend uses again.
pub(crate) struct ForNative<T> {
    pub(crate) buffers: Buffers<T>,
    pub(crate) waiting: Waiting<T>,
    pub(crate) steps: Vec<Step<T>>,
    pub(crate) d_nodes: Vec<Option<Vec<T>>>,
}

impl<T: Scratched> ForNative<T> {
    fn multiply(&mut self, gradients: &mut Gradients) {
        self.waiting.multiply(&mut self.buffers, gradients);
    }

    /// Hands over what waits for a matrix, unless there already is a gradient that it is to be added to.
    fn hand_over(
        &mut self,
        matrix: usize,
        gradients: &mut Gradients,
        take: &mut impl FnMut(GradientPart<'_>),
    ) {
        if gradients.has(matrix) {
            return self.waiting.multiply_one(matrix, &mut self.buffers, gradients);
        }
        let start = gradients.range(matrix).start;
        self.waiting.hand_over(matrix, &mut self.buffers, &mut |at, values| {
            let range = start + at..start + at + values.len();
            take(GradientPart { matrix, range, values: T::wrap_slice(values) });
        });
    }
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

/// A precision whose scratch memory can be told from that of others.
pub(crate) trait Scratched: Real {
    fn unwrap(scratch: Scratch) -> Option<ForNative<Self>>;
    fn wrap(scratch: ForNative<Self>) -> Scratch;
}

impl Scratched for f32 {
    fn unwrap(scratch: Scratch) -> Option<ForNative<f32>> {
        if let Scratch::Narrow(scratch) = scratch { Some(scratch) } else { None }
    }

    fn wrap(scratch: ForNative<f32>) -> Scratch {
        Scratch::Narrow(scratch)
    }
}

impl Scratched for f64 {
    fn unwrap(scratch: Scratch) -> Option<ForNative<f64>> {
        if let Scratch::Wide(scratch) = scratch { Some(scratch) } else { None }
    }

    fn wrap(scratch: ForNative<f64>) -> Scratch {
        Scratch::Wide(scratch)
    }
}

impl Workspace {
    /// An empty one for a proposal with these parameters.
    pub fn new(parameters: &Parameters) -> Self {
        Workspace { gradients: Gradients::none(parameters), scratch: Scratch::Nothing }
    }

    /// Whether its gradients are laid out as these parameters, and in their precision.
    pub fn fits(&self, parameters: &Parameters) -> bool {
        self.gradients.fit(parameters)
    }

    /// The gradients of the last computation.
    pub fn gradients(&mut self) -> &mut Gradients {
        match &mut self.scratch {
            Scratch::Nothing => {}
            Scratch::Narrow(scratch) => scratch.multiply(&mut self.gradients),
            Scratch::Wide(scratch) => scratch.multiply(&mut self.gradients),
        }
        &mut self.gradients
    }

    /// The gradients alone.
    pub fn into_gradients(mut self) -> Gradients {
        self.gradients();
        self.gradients
    }

    /// Hands over the gradients of the last computation, matrix by matrix in their order and each in as many parts as it is formed in;
    /// a part is gone when `take` returns. Where nothing asked for [`Workspace::gradients`] before, most of them are never
    /// written to memory.
    pub fn hand_over(&mut self, mut take: impl FnMut(GradientPart<'_>)) {
        for matrix in 0..self.gradients.matrices() {
            match &mut self.scratch {
                Scratch::Nothing => {}
                Scratch::Narrow(scratch) => scratch.hand_over(matrix, &mut self.gradients, &mut take),
                Scratch::Wide(scratch) => scratch.hand_over(matrix, &mut self.gradients, &mut take),
            }
            if let Some((range, values)) = self.gradients.stretch(matrix) {
                take(GradientPart { matrix, range, values });
            }
        }
        self.gradients.clear();
    }

    /// Gradients to be gathered anew, and memory.
    pub(crate) fn open<T: Scratched>(mut self, parameters: &Parameters) -> (Gradients, ForNative<T>) {
        self.gradients.clear();
        let mut scratch = T::unwrap(self.scratch).unwrap_or_else(|| ForNative {
            buffers: Buffers::default(),
            waiting: Waiting::none(parameters.len()),
            steps: Vec::new(),
            d_nodes: Vec::new(),
        });
        scratch.waiting.clear();
        (self.gradients, scratch)
    }

    /// Gradients to be gathered anew, for a backend that needs no memory of ours.
    pub(crate) fn open_gradients(mut self) -> Gradients {
        self.gradients.clear();
        self.gradients
    }

    pub(crate) fn closed<T: Scratched>(gradients: Gradients, scratch: ForNative<T>) -> Self {
        Workspace { gradients, scratch: T::wrap(scratch) }
    }

    pub(crate) fn closed_gradients(gradients: Gradients) -> Self {
        Workspace { gradients, scratch: Scratch::Nothing }
    }
}
