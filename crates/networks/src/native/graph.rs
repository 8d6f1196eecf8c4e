//! Graph filters, forward and backward, by whichever of three ways is the cheapest.
//!
//! With few features coming in, `[X, S X, S² X, …]` is multiplied by all taps at once; with few going out, `X` is, and the products are
//! shifted. With many of both and a symmetric `S = U Λ Uᵀ`, all is done in the basis of `U`, where a filter is one product
//! for each eigenvalue, with `Σ_d λ^d W_d`: a part in `D + 1` of the arithmetic.

mod spectral;

use faer::Accum;

use super::affine::{activate, deactivate};
use super::buffers::Buffers;
use super::derivatives::Derivatives;
use super::gradient_accumulator::GradientAccumulator;
use super::products::{Multiply, column_sums, times, times_transposed, transpose, transposed_times};
use super::step::{At, BackwardCache, GraphFilterOutput, Kind, Native, Node};
use crate::arithmetic::Activation;
use crate::gradients::Gradients;
use crate::graph::{Graph, GraphOf, Shape};
use crate::parameters::Matrices;

use spectral::Eigen;

/// Whether the basis of the eigenvectors is the cheaper one, by its multiplications for `rows` rows of each node.
fn spectral_pays<T>(graph: GraphOf<'_, T>, shape: Shape, rows: usize) -> bool {
    let Shape { inputs, outputs, taps } = shape;
    let (nodes, product) = (graph.nodes, inputs * outputs);
    let direct = rows * (taps * product + (taps - 1) * nodes * inputs.min(outputs));
    // Forming a matrix for each eigenvalue is memory traffic: it counts twice.
    let spectral = rows * (product + nodes * (inputs + outputs)) + 2 * taps * product;
    graph.spectrum.is_some() && spectral < direct
}

pub(super) fn filter<T: Multiply>(
    native: &mut Native<'_, T>,
    graph: &Graph,
    input: At,
    shape: Shape,
    taps: usize,
    activation: Activation,
) -> At {
    let of = graph.of::<T>();
    let (rows, _) = native.step.size(input);
    let Shape { inputs, outputs, taps: count } = shape;
    let mut out = native.buffers.take(rows * outputs);
    let (values, matrix) = (native.step.values(input), native.weights.get(taps));
    let buffers = &mut *native.buffers;
    let kept = if spectral_pays(of, shape, rows / of.nodes) {
        BackwardCache::Spectral(spectral::forward(of, values, matrix, shape, &mut out, buffers))
    } else if inputs <= outputs {
        let stacked = stack(of, values, shape, buffers);
        times(&mut out, Accum::Replace, &stacked, matrix, [rows, count * inputs, outputs], buffers);
        BackwardCache::Stacked(stacked)
    } else {
        let across = across(matrix, shape, buffers);
        let mut products = buffers.take(rows * count * outputs);
        times_transposed(
            &mut products,
            Accum::Replace,
            values,
            &across,
            [rows, inputs, count * outputs],
            buffers,
        );
        sum_shifted(of.shift, of.nodes, &products, shape, &mut out, buffers);
        buffers.put(across);
        buffers.put(products);
        BackwardCache::Products
    };
    activate(&mut out, Some(native.weights.get(taps + 1)), activation);
    let filtered = GraphFilterOutput { graph: graph.clone(), input, shape, taps, activation, kept };
    native.step.push(Kind::Filter(filtered), rows, outputs, out)
}

pub(super) fn filter_backward<T: Multiply>(
    weights: Matrices<'_, T>,
    (below, node, filtered): (&[Node<T>], &Node<T>, &GraphFilterOutput<T>),
    mut d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
    accumulator: &mut GradientAccumulator<T>,
    gradients: &mut Gradients,
) {
    let GraphFilterOutput { graph, input, shape, taps, activation, kept } = filtered;
    let (of, taps, shape) = (graph.of::<T>(), *taps, *shape);
    let Shape { inputs, outputs, taps: count } = shape;
    deactivate(&mut d, &node.values, *activation);
    let (place, accum) = gradients.place(taps + 1);
    column_sums(place, accum, &d);
    let (rows, wanted) = (node.rows, derivatives.wanted(*input));
    match kept {
        BackwardCache::Spectral(in_basis) => {
            let way = Eigen { of, shape, taps, rows };
            let sums = (accumulator, gradients);
            let d_input = spectral::backward(&way, weights, in_basis, &d, sums, derivatives.buffers);
            derivatives.add(*input, d_input);
        }
        BackwardCache::Stacked(stacked) => {
            let widths = [count * inputs, outputs];
            accumulator.push(taps, widths, (stacked, &d), derivatives.buffers, gradients);
            if wanted {
                let mut d_stacked = derivatives.buffers.take(stacked.len());
                let sizes = [rows, outputs, count * inputs];
                let weights = weights.get(taps);
                times_transposed(&mut d_stacked, Accum::Replace, &d, weights, sizes, derivatives.buffers);
                let mut d_input = derivatives.buffers.take(rows * inputs);
                // What `S^d X` has at the place of a product here: the sum is taken with the transpose.
                let as_products = Shape { inputs: outputs, outputs: inputs, taps: count };
                let shift = of.shift_transposed;
                sum_shifted(shift, of.nodes, &d_stacked, as_products, &mut d_input, derivatives.buffers);
                derivatives.buffers.put(d_stacked);
                derivatives.add(*input, d_input);
            }
        }
        BackwardCache::Products => {
            // The derivative of the products is the output's, shifted 0 to D times against the edges.
            let transposed = GraphSides { shift: of.shift_transposed, nodes: of.nodes };
            let d_products =
                stack_by(transposed, &d, Shape { inputs: outputs, ..shape }, derivatives.buffers);
            let values = &below[input.0].values;
            let mut d_across = derivatives.buffers.take(count * outputs * inputs);
            let sizes = [count * outputs, rows, inputs];
            let buffers = &mut *derivatives.buffers;
            transposed_times(&mut d_across, Accum::Replace, &d_products, values, sizes, buffers);
            let (place, accum) = gradients.place::<T>(taps);
            let of_taps =
                place.chunks_exact_mut(inputs * outputs).zip(d_across.chunks_exact(inputs * outputs));
            for (place, d_across) in of_taps {
                for (i, row) in place.chunks_exact_mut(outputs).enumerate() {
                    for (o, place) in row.iter_mut().enumerate() {
                        let term = d_across[o * inputs + i];
                        *place = if accum == Accum::Add { *place + term } else { term };
                    }
                }
            }
            derivatives.buffers.put(d_across);
            if wanted {
                let across = across(weights.get(taps), shape, derivatives.buffers);
                let sizes = [rows, count * outputs, inputs];
                let (mut place, accum) = derivatives.take(*input, rows * inputs);
                times(&mut place, accum, &d_products, &across, sizes, derivatives.buffers);
                derivatives.put(*input, place);
                derivatives.buffers.put(across);
            }
            derivatives.buffers.put(d_products);
        }
    }
    derivatives.buffers.put(d);
}

/// A shift in one direction.
#[derive(Clone, Copy)]
struct GraphSides<'a, T> {
    shift: &'a [T],
    nodes: usize,
}

/// `[X, S X, …, S^D X]` side by side.
fn stack<T: Multiply>(of: GraphOf<'_, T>, values: &[T], shape: Shape, buffers: &mut Buffers<T>) -> Vec<T> {
    stack_by(GraphSides { shift: of.shift, nodes: of.nodes }, values, shape, buffers)
}

fn stack_by<T: Multiply>(
    GraphSides { shift, nodes }: GraphSides<'_, T>,
    values: &[T],
    Shape { inputs, taps, .. }: Shape,
    buffers: &mut Buffers<T>,
) -> Vec<T> {
    let mut stacked = buffers.take(values.len() * taps);
    let (mut current, mut next) = (buffers.take(values.len()), buffers.take(values.len()));
    current.copy_from_slice(values);
    for tap in 0..taps {
        if tap > 0 {
            let sizes = [nodes, nodes, values.len() / nodes];
            times(&mut next, Accum::Replace, shift, &current, sizes, buffers);
            std::mem::swap(&mut current, &mut next);
        }
        for (row, from) in stacked.chunks_exact_mut(taps * inputs).zip(current.chunks_exact(inputs)) {
            row[tap * inputs..(tap + 1) * inputs].copy_from_slice(from);
        }
    }
    buffers.put(current);
    buffers.put(next);
    stacked
}

/// `P_0 + S (P_1 + S (P_2 + …))` of products side by side, from the inside.
fn sum_shifted<T: Multiply>(
    shift: &[T],
    nodes: usize,
    products: &[T],
    Shape { outputs, taps, .. }: Shape,
    sum: &mut [T],
    buffers: &mut Buffers<T>,
) {
    let mut inner = buffers.take(sum.len());
    for tap in (0..taps).rev() {
        if tap + 1 < taps {
            inner.copy_from_slice(sum);
            times(sum, Accum::Replace, shift, &inner, [nodes, nodes, inner.len() / nodes], buffers);
        }
        let rows = sum.chunks_exact_mut(outputs).zip(products.chunks_exact(taps * outputs));
        for (sum, products) in rows {
            let product = &products[tap * outputs..(tap + 1) * outputs];
            if tap + 1 == taps {
                sum.copy_from_slice(product);
            } else {
                sum.iter_mut().zip(product).for_each(|(sum, term)| *sum += *term);
            }
        }
    }
    buffers.put(inner);
}

/// The transposes of the taps on top of each other: `((D+1)·F_out)×F_in`. With one feature going out they are the taps as they lie.
fn across<T: Multiply>(
    matrix: &[T],
    Shape { inputs, outputs, .. }: Shape,
    buffers: &mut Buffers<T>,
) -> Vec<T> {
    let mut across = buffers.take(matrix.len());
    let of_taps = matrix.chunks_exact(inputs * outputs).zip(across.chunks_exact_mut(inputs * outputs));
    of_taps.for_each(|(tap, across)| transpose(tap, inputs, outputs, across));
    across
}

/// Row `i·R + k` is `[x_{k,i}, (A_y y)_i]`.
pub(super) fn at_nodes<T: Multiply>(
    native: &mut Native<'_, T>,
    previous: At,
    measurement: At,
    graph: &Graph,
    adapter: Option<usize>,
) -> At {
    let (particles, nodes) = native.step.size(previous);
    let matrix = match adapter {
        Some(index) => native.weights.get(index),
        None => graph.of::<T>().adapter,
    };
    let mut values = native.buffers.take(particles * nodes * 2);
    let (states, y) = (native.step.values(previous), native.step.values(measurement));
    for (i, (rows, weights)) in
        values.chunks_exact_mut(particles * 2).zip(matrix.chunks_exact(y.len())).enumerate()
    {
        let heard = weights.iter().zip(y).fold(T::ZERO, |sum, (weight, y)| sum + *weight * *y);
        for (row, state) in rows.chunks_exact_mut(2).zip(states.chunks_exact(nodes)) {
            (row[0], row[1]) = (state[i], heard);
        }
    }
    native.step.push(Kind::AtNodes { previous, measurement, adapter }, particles * nodes, 2, values)
}

pub(super) fn at_nodes_backward<T: Multiply>(
    below: &[Node<T>],
    (previous, measurement, adapter): (At, At, Option<usize>),
    d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
    gradients: &mut Gradients,
) {
    let (particles, nodes) = (below[previous.0].rows, below[previous.0].width);
    if let Some(adapter) = adapter {
        let y = &below[measurement.0].values;
        let (place, accum) = gradients.place::<T>(adapter);
        for (row, d) in place.chunks_exact_mut(y.len()).zip(d.chunks_exact(particles * 2)) {
            let sum = d.chunks_exact(2).fold(T::ZERO, |sum, pair| sum + pair[1]);
            for (place, y) in row.iter_mut().zip(y) {
                *place = if accum == Accum::Add { *place + sum * *y } else { sum * *y };
            }
        }
    }
    if derivatives.wanted(previous) {
        let mut d_previous = derivatives.buffers.take(particles * nodes);
        for (i, d) in d.chunks_exact(particles * 2).enumerate() {
            for (row, d) in d_previous.chunks_exact_mut(nodes).zip(d.chunks_exact(2)) {
                row[i] = d[0];
            }
        }
        derivatives.add(previous, d_previous);
    }
    derivatives.buffers.put(d);
}

/// Row `i·R + k` is the entries of node `i` in the blocks of states, then what it hears of each block of measurements.
pub(super) fn blocks_at_nodes<T: Multiply>(
    native: &mut Native<'_, T>,
    inputs: At,
    graph: &Graph,
    blocks: [usize; 2],
) -> At {
    let GraphOf { nodes, adapter, .. } = graph.of::<T>();
    let (particles, width) = native.step.size(inputs);
    let [states, measurements] = blocks;
    let (features, m) = (states + measurements, adapter.len() / nodes);
    let mut values = native.buffers.take(particles * nodes * features);
    let of_particles = native.step.values(inputs);
    for (i, rows) in values.chunks_exact_mut(particles * features).enumerate() {
        let weights = &adapter[i * m..(i + 1) * m];
        for (row, inputs) in rows.chunks_exact_mut(features).zip(of_particles.chunks_exact(width)) {
            let (of_states, of_measurements) = inputs.split_at(states * nodes);
            let (own, heard) = row.split_at_mut(states);
            for (value, block) in own.iter_mut().zip(of_states.chunks_exact(nodes)) {
                *value = block[i];
            }
            for (value, block) in heard.iter_mut().zip(of_measurements.chunks_exact(m)) {
                *value = weights.iter().zip(block).fold(T::ZERO, |sum, (weight, y)| sum + *weight * *y);
            }
        }
    }
    let kind = Kind::BlocksAtNodes { inputs, graph: graph.clone(), blocks };
    native.step.push(kind, particles * nodes, features, values)
}

pub(super) fn blocks_at_nodes_backward<T: Multiply>(
    below: &[Node<T>],
    (inputs, graph, [states, measurements]): (At, &Graph, [usize; 2]),
    d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
) {
    if derivatives.wanted(inputs) {
        let GraphOf { nodes, adapter, .. } = graph.of::<T>();
        let (particles, width) = (below[inputs.0].rows, below[inputs.0].width);
        let (features, m) = (states + measurements, adapter.len() / nodes);
        let mut d_inputs = derivatives.buffers.take(particles * width);
        d_inputs.fill(T::ZERO);
        for (i, rows) in d.chunks_exact(particles * features).enumerate() {
            let weights = &adapter[i * m..(i + 1) * m];
            for (d_row, d_particle) in rows.chunks_exact(features).zip(d_inputs.chunks_exact_mut(width)) {
                let (of_states, of_measurements) = d_particle.split_at_mut(states * nodes);
                let (own, heard) = d_row.split_at(states);
                for (d, block) in own.iter().zip(of_states.chunks_exact_mut(nodes)) {
                    block[i] = *d;
                }
                for (d, block) in heard.iter().zip(of_measurements.chunks_exact_mut(m)) {
                    for (place, weight) in block.iter_mut().zip(weights) {
                        *place += *d * *weight;
                    }
                }
            }
        }
        derivatives.add(inputs, d_inputs);
    }
    derivatives.buffers.put(d);
}

/// Rows of `features` numbers, group after group, as the members of all groups: row `g·members + k` becomes row `k·groups + g`.
pub(super) fn regroup<T: Multiply>(values: &[T], [groups, members, features]: [usize; 3], into: &mut [T]) {
    if features == 1 {
        return transpose(values, groups, members, into);
    }
    for (g, group) in values.chunks_exact(members * features).enumerate() {
        for (k, row) in group.chunks_exact(features).enumerate() {
            into[(k * groups + g) * features..][..features].copy_from_slice(row);
        }
    }
}
