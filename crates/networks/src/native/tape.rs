//! Networks computed forward along a sequence, and derivatives taken backward.

use faer::Accum;

use super::deduplicate::{distinct, repeat_first};
use super::derivatives::Derivatives;
use super::gradient_accumulator::GradientAccumulator;
use super::memory::Scratch;
use super::products::{Multiply, column_sums};
use super::step::{At, Kind, Native, Node, Step};
use super::{affine, cells, graph};
use crate::error::NetworkError;
use crate::fit::{D_OUTPUTS, HIDDEN, OUTPUTS, check_inputs, unless_alike, unless_same};
use crate::gradients::Gradients;
use crate::networks::{Few, Inputs, Known, Networks, Outputs};
use crate::parameters::{Matrices, Parameters};
use crate::values::{narrow, widen};

/// The steps of a batch of particles, from `t = 0` on.
pub(crate) struct NativeTape<'p, F, T> {
    networks: &'p F,
    weights: Matrices<'p, T>,
    scratch: Scratch<T>,
    gradients: Gradients,
    steps: Vec<Recorded<T>>,
    particles: usize,
    /// The widths of what the particles carry.
    widths: Vec<usize>,
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
    hidden_out: Few<At>,
    outputs: Few<At>,
}

impl<'p, F: Networks, T: Multiply> NativeTape<'p, F, T> {
    pub(crate) fn new(
        networks: &'p F,
        parameters: &'p Parameters,
        particles: usize,
        (gradients, scratch): (Gradients, Scratch<T>),
    ) -> Self {
        let widths = networks.hidden_widths();
        NativeTape {
            networks,
            weights: parameters.matrices(),
            scratch,
            gradients,
            steps: Vec::new(),
            particles,
            hidden: widths.iter().map(|&width| vec![T::ZERO; width]).collect(),
            widths,
            d_hidden: Vec::new(),
        }
    }

    /// # Errors
    /// [`NetworkError`] for what does not fit; the recording is then what it was before.
    pub(crate) fn forward(
        &mut self,
        inputs: &Inputs<'_>,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), NetworkError> {
        check_inputs(self.networks, inputs)?;
        unless_same("the number of particles", inputs.particles, self.particles)?;
        let (rows, width) = (distinct(inputs), inputs.width);
        // One row before the first state, and one for each particle after it.
        let carried = self.widths.iter().map(|width| rows * width);
        unless_alike(HIDDEN, self.hidden.iter().map(Vec::len), carried)?;
        let buffers = &mut self.scratch.buffers;
        let mut step = self.scratch.steps.pop().unwrap_or_default();
        let mut previous = buffers.take(rows * width);
        match inputs.previous {
            Some(values) => narrow(values, &mut previous),
            None => previous.fill(T::ZERO),
        }
        let mut measurement = buffers.take(inputs.measurement.len());
        narrow(inputs.measurement, &mut measurement);
        let previous = step.give(rows, width, previous);
        let measurement = step.give(1, inputs.measurement.len(), measurement);
        let carried = self.hidden.drain(..);
        let hidden_in: Vec<At> = carried.map(|values| step.give(rows, values.len() / rows, values)).collect();
        let mut native = Native { weights: self.weights, step: &mut step, buffers };
        let known = Known { previous, measurement, hidden: &hidden_in };
        let found = self.networks.forward(&mut native, inputs.time, known);
        if let Err(error) = has_places(&step, &found, [rows, self.particles], &self.widths, outputs) {
            self.hidden.extend(hidden_in.iter().map(|&at| step.values(at).to_vec()));
            step.release(&mut self.scratch.buffers);
            self.scratch.steps.push(step);
            return Err(error);
        }
        for (&at, output) in found.values.iter().zip(&mut *outputs) {
            widen(step.values(at), output);
        }
        for &at in &found.hidden {
            let values = step.values(at);
            let mut copy = buffers.take(values.len() / rows * self.particles);
            copy[..values.len()].copy_from_slice(values);
            self.hidden.push(copy);
        }
        if rows < self.particles {
            for output in outputs {
                let width = output.len() / self.particles;
                repeat_first(output, width);
            }
            self.hidden.iter_mut().for_each(|hidden| {
                let width = hidden.len() / self.particles;
                repeat_first(hidden, width);
            });
        }
        self.steps.push(Recorded {
            step,
            first: inputs.previous.is_none(),
            previous,
            hidden_in,
            hidden_out: found.hidden,
            outputs: found.values,
        });
        Ok(())
    }

    /// # Errors
    /// [`NetworkError::Shape`] for derivatives that are not those of the last step; the recording is then what it was before.
    pub(crate) fn backward(
        &mut self,
        d_outputs: &[&[f64]],
        d_previous: Option<&mut [f64]>,
    ) -> Result<(), NetworkError> {
        let Some(last) = self.steps.last() else { panic!("there is no step left to pull back") };
        let of_all = |at: &At| last.step.size(*at).1 * self.particles;
        unless_alike(D_OUTPUTS, d_outputs.iter().map(|d| d.len()), last.outputs.iter().map(of_all))?;
        if let Some(d_previous) = &d_previous {
            let expected = of_all(&last.previous);
            unless_same("the length of the derivative of x_{t−1}", d_previous.len(), expected)?;
        }
        let Some(mut recorded) = self.steps.pop() else { return Ok(()) };
        let Scratch { buffers, accumulator, steps, d_nodes } = &mut self.scratch;
        let nodes = &recorded.step.nodes;
        d_nodes.clear();
        d_nodes.resize_with(nodes.len(), || None);
        let past: Vec<At> = recorded
            .hidden_in
            .iter()
            .copied()
            .chain(d_previous.is_some().then_some(recorded.previous))
            .collect();
        let mut derivatives = Derivatives::none(d_nodes, nodes, &past, recorded.first, buffers);
        for (&at, &values) in recorded.outputs.iter().zip(d_outputs) {
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
            pull_back(self.weights, (below, &rest[0]), d, &mut derivatives, accumulator, &mut self.gradients);
        }
        let found = derivatives.at[recorded.previous.0].take();
        if let Some(d_previous) = d_previous {
            d_previous.fill(0.0);
            if let Some(d) = &found {
                widen(d, d_previous);
            }
        }
        if let Some(d) = found {
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

    pub(crate) fn detach(&mut self) {
        self.d_hidden.drain(..).for_each(|d| self.scratch.buffers.put(d));
    }

    pub(crate) fn gradients(&mut self) -> &mut Gradients {
        &mut self.gradients
    }

    pub(crate) fn finish(self) -> (Gradients, Scratch<T>) {
        (self.gradients, self.scratch)
    }
}

/// Refuses places that are not those of what was found of some rows, and hidden values of other widths than were said.
fn has_places<T: Multiply>(
    step: &Step<T>,
    found: &Outputs<At>,
    [rows, particles]: [usize; 2],
    widths: &[usize],
    outputs: &[&mut [f64]],
) -> Result<(), NetworkError> {
    let width = |at: &At| step.values(*at).len() / rows;
    let emitted = found.values.iter().map(|at| width(at) * particles);
    unless_alike(OUTPUTS, outputs.iter().map(|output| output.len()), emitted)?;
    unless_alike(HIDDEN, found.hidden.iter().map(width), widths.iter().copied())
}

fn pull_back<T: Multiply>(
    weights: Matrices<'_, T>,
    (below, node): (&[Node<T>], &Node<T>),
    d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
    accumulator: &mut GradientAccumulator<T>,
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
        Kind::Affine { .. } => {
            affine::backward(weights, (below, node), d, derivatives, accumulator, gradients)
        }
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
        Kind::BlocksAtNodes { inputs, graph, blocks } => {
            graph::blocks_at_nodes_backward(below, (*inputs, graph, *blocks), d, derivatives);
        }
        Kind::Filter(filtered) => {
            graph::filter_backward(weights, (below, node, filtered), d, derivatives, accumulator, gradients);
        }
        Kind::ByParticle(values) => {
            let (features, mut d_values) = (below[values.0].width, derivatives.buffers.take(d.len()));
            graph::regroup(&d, [node.rows, node.width / features, features], &mut d_values);
            derivatives.add(*values, d_values);
            derivatives.buffers.put(d);
        }
    }
}
