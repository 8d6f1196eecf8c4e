//! Networks computed forward along a sequence, and derivatives taken backward.

use faer::Accum;
use motes_smc::{Past, ProposalError};

use super::alike::{distinct, repeat_first};
use super::products::column_sums;
use super::{At, Buffers, Kind, Native, Node, Step, Waiting, affine, cells, graph};
use crate::gaussian::{Known, NetworkTape, Networks};
use crate::parameters::Matrices;
use crate::values::{Real, narrow, widen};
use crate::workspace::{ForNative, Scratched, Workspace};
use crate::{Gradients, Parameters};

/// The steps of a batch of particles, from `t = 0` on.
pub(crate) struct NativeTape<'p, F, T> {
    networks: &'p F,
    weights: Matrices<'p, T>,
    scratch: ForNative<T>,
    gradients: Gradients,
    steps: Vec<Recorded<T>>,
    particles: usize,
    /// What the particles carry into the next step, `R×width` each; one row as long as all carry the same.
    hidden: Vec<Vec<T>>,
    /// The derivative with respect to what they carried out of the last step not yet undone; empty if it is zero.
    d_hidden: Vec<Vec<T>>,
}

struct Recorded<T> {
    step: Step<T>,
    first: bool,
    previous: At,
    hidden_in: Vec<At>,
    hidden_out: Vec<At>,
    means: At,
    representations: At,
}

impl<'p, F: Networks, T: Scratched> NativeTape<'p, F, T> {
    pub(crate) fn new(
        networks: &'p F,
        parameters: &'p Parameters,
        particles: usize,
        workspace: Workspace,
    ) -> Self {
        let (gradients, scratch) = workspace.open::<T>(parameters);
        let widths = networks.hidden_widths();
        NativeTape {
            networks,
            weights: parameters.matrices(),
            scratch,
            gradients,
            steps: Vec::new(),
            particles,
            hidden: widths.iter().map(|&width| vec![T::ZERO; width]).collect(),
            d_hidden: Vec::new(),
        }
    }
}

impl<F: Networks, T: Scratched> NetworkTape for NativeTape<'_, F, T> {
    fn forward(
        &mut self,
        past: &Past<'_>,
        width: usize,
        means: &mut [f64],
        representations: &mut [f64],
    ) -> Result<(), ProposalError> {
        let rows = distinct(past);
        let buffers = &mut self.scratch.buffers;
        let mut step = self.scratch.steps.pop().unwrap_or_default();
        let mut previous = buffers.take(rows * width);
        match past.previous {
            Some(values) => narrow(values, &mut previous),
            None => previous.fill(T::ZERO),
        }
        let mut measurement = buffers.take(past.measurement.len());
        narrow(past.measurement, &mut measurement);
        let previous = step.give(rows, width, previous);
        let measurement = step.give(1, past.measurement.len(), measurement);
        let carried = self.hidden.drain(..);
        let hidden_in: Vec<At> = carried.map(|values| step.give(rows, values.len() / rows, values)).collect();
        let mut native = Native { weights: self.weights, step: &mut step, buffers };
        let known = Known { previous, measurement, hidden: &hidden_in };
        let emission = self.networks.forward(&mut native, past.time, known);
        widen(step.values(emission.means), means);
        widen(step.values(emission.representations), representations);
        for &at in &emission.hidden {
            let values = step.values(at);
            let mut copy = buffers.take(values.len() / rows * self.particles);
            copy[..values.len()].copy_from_slice(values);
            self.hidden.push(copy);
        }
        if rows < self.particles {
            repeat_first(means, width);
            repeat_first(representations, width);
            self.hidden.iter_mut().for_each(|hidden| {
                let width = hidden.len() / self.particles;
                repeat_first(hidden, width);
            });
        }
        self.steps.push(Recorded {
            step,
            first: past.previous.is_none(),
            previous,
            hidden_in,
            hidden_out: emission.hidden,
            means: emission.means,
            representations: emission.representations,
        });
        Ok(())
    }

    fn backward(
        &mut self,
        d_means: &[f64],
        d_representations: &[f64],
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError> {
        let Some(mut recorded) = self.steps.pop() else { panic!("there is no step left to pull back") };
        let ForNative { buffers, waiting, steps, d_nodes } = &mut self.scratch;
        let nodes = &recorded.step.nodes;
        d_nodes.clear();
        d_nodes.resize_with(nodes.len(), || None);
        let mut derivatives = Derivatives { at: d_nodes, unwanted: Vec::new(), buffers };
        derivatives.mark_unwanted(nodes, &recorded);
        for (at, values) in [(recorded.means, d_means), (recorded.representations, d_representations)] {
            let mut d = derivatives.buffers.take(nodes[at.0].values.len());
            if d.len() < values.len() {
                let mut sum = vec![0.0; d.len()];
                column_sums(&mut sum, Accum::Replace, values);
                narrow(&sum, &mut d);
            } else {
                narrow(values, &mut d);
            }
            derivatives.add(at, d);
        }
        for (at, d) in recorded.hidden_out.iter().zip(self.d_hidden.drain(..)) {
            let len = nodes[at.0].values.len();
            if len < d.len() {
                let mut sum = derivatives.buffers.take(len);
                column_sums(&mut sum, Accum::Replace, &d);
                derivatives.add(*at, sum);
                derivatives.buffers.put(d);
            } else {
                derivatives.add(*at, d);
            }
        }
        for at in (0..nodes.len()).rev() {
            if matches!(nodes[at].kind, Kind::Given) {
                continue;
            }
            let Some(d) = derivatives.at[at].take() else { continue };
            let (below, rest) = nodes.split_at(at);
            pull_back(self.weights, (below, &rest[0]), d, &mut derivatives, waiting, &mut self.gradients);
        }
        d_previous.fill(0.0);
        if let Some(d) = derivatives.at[recorded.previous.0].take() {
            widen(&d, d_previous);
            derivatives.buffers.put(d);
        }
        if !recorded.first {
            for at in &recorded.hidden_in {
                let len = nodes[at.0].values.len();
                let d = derivatives.at[at.0].take();
                self.d_hidden.push(d.unwrap_or_else(|| {
                    let mut zeros = derivatives.buffers.take(len);
                    zeros.fill(T::ZERO);
                    zeros
                }));
            }
        }
        recorded.step.release(buffers);
        steps.push(recorded.step);
        Ok(())
    }

    fn cut(&mut self) {
        self.d_hidden.drain(..).for_each(|d| self.scratch.buffers.put(d));
    }

    fn gradients(&mut self) -> &mut Gradients {
        &mut self.gradients
    }

    fn finish(self: Box<Self>) -> Workspace {
        Workspace::closed(self.gradients, self.scratch)
    }
}

fn pull_back<T: Real>(
    weights: Matrices<'_, T>,
    (below, node): (&[Node<T>], &Node<T>),
    d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
    waiting: &mut Waiting<T>,
    gradients: &mut Gradients,
) {
    match &node.kind {
        Kind::Given => {}
        Kind::Stacked(previous) => {
            let n = below[previous.0].width;
            if derivatives.wanted(*previous) {
                let mut d_previous = derivatives.buffers.take(node.rows * n);
                for (into, d) in d_previous.chunks_exact_mut(n).zip(d.chunks_exact(node.width)) {
                    into.copy_from_slice(&d[..n]);
                }
                derivatives.add(*previous, d_previous);
            }
            derivatives.buffers.put(d);
        }
        Kind::Affine { .. } => affine::backward(weights, (below, node), d, derivatives, waiting, gradients),
        Kind::LstmHidden { gates, cells, bounded } => {
            cells::lstm_hidden_backward(below, (*gates, *cells, bounded), d, derivatives);
        }
        Kind::LstmCells { gates, cells } => {
            cells::lstm_cells_backward(below, (*gates, *cells), d, derivatives);
        }
        Kind::Gru { from_input, from_hidden, offset, hidden, parts } => {
            let parts = (*from_input, *from_hidden, *offset, *hidden, parts.as_slice());
            cells::gru_backward(below, parts, d, derivatives, gradients);
        }
        Kind::AtNodes { previous, measurement, adapter } => {
            graph::at_nodes_backward(below, (*previous, *measurement, *adapter), d, derivatives, gradients);
        }
        Kind::Filter(filtered) => {
            graph::filter_backward(weights, (below, node, filtered), d, derivatives, waiting, gradients);
        }
        Kind::ByParticle(values) => {
            let mut d_values = derivatives.buffers.take(d.len());
            super::products::transpose(&d, node.rows, node.width, &mut d_values);
            derivatives.add(*values, d_values);
            derivatives.buffers.put(d);
        }
    }
}

/// The derivatives of the scalar with respect to each matrix of a step, as far as they are known.
pub(super) struct Derivatives<'a, T> {
    at: &'a mut Vec<Option<Vec<T>>>,
    unwanted: Vec<At>,
    pub(super) buffers: &'a mut Buffers<T>,
}

impl<T: Real> Derivatives<'_, T> {
    /// What nothing is asked of: measurements, and at `t = 0` the zeros that stand for a past.
    fn mark_unwanted(&mut self, nodes: &[Node<T>], recorded: &Recorded<T>) {
        for (at, node) in nodes.iter().enumerate() {
            let of_the_past =
                at == recorded.previous.0 || recorded.hidden_in.iter().any(|hidden| hidden.0 == at);
            let unwanted = match &node.kind {
                Kind::Given => recorded.first || !of_the_past,
                Kind::Stacked(_) | Kind::AtNodes { adapter: None, .. } => recorded.first,
                _ => false,
            };
            if unwanted {
                self.unwanted.push(At(at));
            }
        }
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
