//! Affine maps with their activations, forward and backward.

use faer::Accum;
use motes_models::batch::by_widest_vectors;

use super::derivatives::Derivatives;
use super::gradient_accumulator::GradientAccumulator;
use super::products::{Multiply, column_sums, times, times_transposed};
use super::step::{At, Kind, Native, Node};
use crate::arithmetic::Activation;
use crate::gradients::Gradients;
use crate::parameters::Matrices;

pub(super) fn forward<T: Multiply>(
    native: &mut Native<'_, T>,
    inputs: [Option<(At, usize)>; 2],
    bias: Option<usize>,
    activation: Activation,
) -> At {
    let Some((first, weight)) = inputs[0] else { panic!("an affine map has an input") };
    let (rows, _) = native.step.size(first);
    let columns = native.weights.shape(weight)[1];
    let mut out = native.buffers.take(rows * columns);
    let mut accum = Accum::Replace;
    for (input, weight) in inputs.into_iter().flatten() {
        let shape = [rows, native.step.size(input).1, columns];
        let (values, weight) = (native.step.values(input), native.weights.get(weight));
        times(&mut out, accum, values, weight, shape, native.buffers);
        accum = Accum::Add;
    }
    activate(&mut out, bias.map(|bias| native.weights.get(bias)), activation);
    native.step.push(Kind::Affine { inputs, bias, activation }, rows, columns, out)
}

/// `ρ(rows + bias)` in place.
pub(super) fn activate<T: Multiply>(rows: &mut [T], bias: Option<&[T]>, activation: Activation) {
    by_widest_vectors(
        #[inline(always)]
        || {
            if let Some(bias) = bias {
                for row in rows.chunks_exact_mut(bias.len()) {
                    row.iter_mut().zip(bias).for_each(|(value, bias)| *value += *bias);
                }
            }
            if activation == Activation::Tanh {
                rows.iter_mut().for_each(|value| *value = value.tanh());
            }
        },
    );
}

/// Turns the derivative with respect to `ρ(a)` into that with respect to `a`, given `ρ(a)`.
pub(super) fn deactivate<T: Multiply>(d: &mut [T], outputs: &[T], activation: Activation) {
    if activation == Activation::Tanh {
        by_widest_vectors(
            #[inline(always)]
            || d.iter_mut().zip(outputs).for_each(|(d, y)| *d *= T::ONE - *y * *y),
        );
    }
}

/// Pulls `d`, the derivative with respect to the output, back to the inputs and the weights.
pub(super) fn backward<T: Multiply>(
    weights: Matrices<'_, T>,
    (below, node): (&[Node<T>], &Node<T>),
    mut d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
    accumulator: &mut GradientAccumulator<T>,
    gradients: &mut Gradients,
) {
    let Kind::Affine { inputs, bias, activation } = &node.kind else { return };
    deactivate(&mut d, &node.values, *activation);
    if let Some(bias) = bias {
        let (place, accum) = gradients.place(*bias);
        column_sums(place, accum, &d);
    }
    for (At(input), weight) in inputs.iter().flatten() {
        let source = &below[*input];
        let (widths, rows) = ([source.width, node.width], (source.values.as_slice(), d.as_slice()));
        accumulator.push(*weight, widths, rows, derivatives.buffers, gradients);
        if derivatives.wanted(At(*input)) {
            let shape = [node.rows, node.width, source.width];
            let (mut place, accum) = derivatives.take(At(*input), source.values.len());
            times_transposed(&mut place, accum, &d, weights.get(*weight), shape, derivatives.buffers);
            derivatives.put(At(*input), place);
        }
    }
    derivatives.buffers.put(d);
}
