//! Derivatives of a scalar with respect to the matrices of one step, while they are pulled back.

use faer::Accum;

use super::buffers::Buffers;
use super::step::{At, Kind, Node};
use crate::values::Real;

/// The derivatives of the scalar with respect to each matrix of a step, as far as they are known.
pub(super) struct Derivatives<'a, T> {
    pub(super) at: &'a mut [Option<Vec<T>>],
    unwanted: Vec<At>,
    pub(super) buffers: &'a mut Buffers<T>,
}

impl<'a, T: Real> Derivatives<'a, T> {
    /// Nothing known yet of the matrices of a step. Nothing is asked of measurements, nor of `past` before the first state, which is zeros.
    pub(super) fn none(
        at: &'a mut [Option<Vec<T>>],
        nodes: &[Node<T>],
        past: &[At],
        first: bool,
        buffers: &'a mut Buffers<T>,
    ) -> Self {
        let unwanted = |(at, node): (usize, &Node<T>)| {
            let is_unwanted = match &node.kind {
                Kind::Given => first || past.iter().all(|past| past.0 != at),
                Kind::Stacked(_) | Kind::AtNodes { adapter: None, .. } => first,
                _ => false,
            };
            is_unwanted.then_some(At(at))
        };
        Derivatives { at, unwanted: nodes.iter().enumerate().filter_map(unwanted).collect(), buffers }
    }

    /// Whether the derivative with respect to this matrix is of any use.
    pub(super) fn wanted(&self, At(at): At) -> bool {
        self.unwanted.iter().all(|unwanted| unwanted.0 != at)
    }

    /// Where a derivative of `len` numbers is to be written or added to, taken out until it is put back.
    pub(super) fn take(&mut self, At(at): At, len: usize) -> (Vec<T>, Accum) {
        match self.at[at].take() {
            Some(values) => (values, Accum::Add),
            None => (self.buffers.take(len), Accum::Replace),
        }
    }

    pub(super) fn put(&mut self, At(at): At, values: Vec<T>) {
        self.at[at] = Some(values);
    }

    /// Adds to a derivative.
    pub(super) fn add(&mut self, At(at): At, d: Vec<T>) {
        match &mut self.at[at] {
            None => self.at[at] = Some(d),
            Some(sum) => {
                sum.iter_mut().zip(&d).for_each(|(sum, term)| *sum += *term);
                self.buffers.put(d);
            }
        }
    }
}
