//! What training uses again from step to step: gradients, and the memory that computing them takes.

use crate::native::{Buffers, Step, Waiting};
use crate::values::Real;
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

    /// The gradients of the last computation.
    pub fn gradients(&self) -> &Gradients {
        &self.gradients
    }

    /// The gradients of the last computation, to be scaled.
    pub fn gradients_mut(&mut self) -> &mut Gradients {
        &mut self.gradients
    }

    /// The gradients alone.
    pub fn into_gradients(self) -> Gradients {
        self.gradients
    }

    /// Gradients to be gathered anew, and memory.
    pub(crate) fn open<T: Scratched>(mut self, parameters: &Parameters) -> (Gradients, ForNative<T>) {
        self.gradients.clear();
        let scratch = T::unwrap(self.scratch).unwrap_or_else(|| ForNative {
            buffers: Buffers::default(),
            waiting: Waiting::none(parameters.len()),
            steps: Vec::new(),
            d_nodes: Vec::new(),
        });
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
