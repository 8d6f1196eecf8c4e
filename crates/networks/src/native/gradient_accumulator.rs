//! Gradients of matrices that many times share: rows wait until one product is worth its while.

use faer::Accum;

use super::buffers::Buffers;
use super::products::{Multiply, OuterProducts, Take, Terms, add_whole};
use crate::gradients::Gradients;
use crate::graph::Shape;

/// Inputs and derivatives of outputs of the maps with each matrix, accumulator to be multiplied.
///
/// `W̄ = Σ_t inputs_tᵀ d_outputs_t` is then one product of many rows instead of a sum of as many matrices, and is formed when somebody
/// wants it, who may have it piece by piece.
pub(crate) struct GradientAccumulator<T> {
    /// By the index of the matrix.
    matrices: Vec<PendingRows<T>>,
}

/// What waits for one matrix.
struct PendingRows<T> {
    shape: Shape,
    /// A term for each eigenvalue; a single one for an affine map.
    terms: Vec<Terms<T>>,
}

/// From this many rows on a product is worth its while, and memory stays bounded however long the sequence.
const ENOUGH: usize = 2048;

impl<T: Multiply> GradientAccumulator<T> {
    pub(crate) fn none(matrices: usize) -> Self {
        let nothing = || PendingRows { shape: Shape { inputs: 0, outputs: 0, taps: 0 }, terms: Vec::new() };
        GradientAccumulator { matrices: (0..matrices).map(|_| nothing()).collect() }
    }

    /// Adds the rows of one affine map.
    pub(super) fn push(
        &mut self,
        index: usize,
        [inputs, outputs]: [usize; 2],
        (of_inputs, d_outputs): (&[T], &[T]),
        buffers: &mut Buffers<T>,
        gradients: &mut Gradients,
    ) {
        let shape = Shape { inputs, outputs, taps: 1 };
        self.push_all(index, shape, std::iter::once((T::ONE, of_inputs, d_outputs)), buffers, gradients);
    }

    /// Adds the rows of maps that differ by their eigenvalues: each of these with what comes in and the derivative of what goes out.
    pub(super) fn push_all<'a>(
        &mut self,
        index: usize,
        shape: Shape,
        new: impl Iterator<Item = (T, &'a [T], &'a [T])>,
        buffers: &mut Buffers<T>,
        gradients: &mut Gradients,
    ) {
        let pending = &mut self.matrices[index];
        // The way in which a filter is computed may change with the number of rows.
        if pending.shape != shape {
            pending.multiply_if(1, index, buffers, gradients);
            *pending = PendingRows { shape, terms: Vec::new() };
        }
        for (number, (eigenvalue, inputs, d_outputs)) in new.enumerate() {
            if number == pending.terms.len() {
                pending.terms.push(Terms::default());
            }
            let term = &mut pending.terms[number];
            term.eigenvalue = eigenvalue;
            term.inputs.extend_from_slice(inputs);
            term.d_outputs.extend_from_slice(d_outputs);
        }
        pending.multiply_if(ENOUGH, index, buffers, gradients);
    }

    /// Multiplies all that waits.
    pub(crate) fn multiply(&mut self, buffers: &mut Buffers<T>, gradients: &mut Gradients) {
        for index in 0..self.matrices.len() {
            self.multiply_one(index, buffers, gradients);
        }
    }

    /// Multiplies what waits for a matrix.
    pub(crate) fn multiply_one(&mut self, index: usize, buffers: &mut Buffers<T>, gradients: &mut Gradients) {
        self.matrices[index].multiply_if(1, index, buffers, gradients);
    }

    /// Multiplies what waits for a matrix and hands the product over in parts.
    pub(crate) fn hand_over(&mut self, index: usize, buffers: &mut Buffers<T>, take: Take<'_, T>) {
        let pending = &mut self.matrices[index];
        if pending.rows() > 0 {
            T::outer(&OuterProducts { shape: pending.shape, terms: &pending.terms }, buffers, take);
            pending.clear();
        }
    }

    /// Forgets all that waits.
    pub(crate) fn clear(&mut self) {
        self.matrices.iter_mut().for_each(PendingRows::clear);
    }
}

impl<T: Multiply> PendingRows<T> {
    /// Of each term.
    fn rows(&self) -> usize {
        self.terms.first().map_or(0, |term| term.inputs.len() / self.shape.inputs)
    }

    /// The memory is kept for rows of the same shape.
    fn clear(&mut self) {
        for term in &mut self.terms {
            term.inputs.clear();
            term.d_outputs.clear();
        }
    }

    /// Adds to the gradient if there are at least this many rows.
    fn multiply_if(
        &mut self,
        enough: usize,
        index: usize,
        buffers: &mut Buffers<T>,
        gradients: &mut Gradients,
    ) {
        if self.rows() < enough {
            return;
        }
        let (place, accum) = gradients.place::<T>(index);
        let sums = OuterProducts { shape: self.shape, terms: &self.terms };
        if sums.affine().is_some() {
            add_whole(&sums, place, accum, buffers);
        } else {
            T::outer(&sums, buffers, &mut |at, values| {
                let place = &mut place[at..at + values.len()];
                match accum {
                    Accum::Replace => place.copy_from_slice(values),
                    Accum::Add => place.iter_mut().zip(values).for_each(|(sum, term)| *sum += *term),
                }
            });
        }
        self.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Backend, Compute, Parameters, Precision};
    use motes_models::Seed;

    const SHAPES: [[usize; 2]; 2] = [[6, 40], [8, 3]];

    fn parameters(precision: Precision) -> Parameters {
        let mut parameters = Parameters::new(Compute { backend: Backend::Native, precision });
        let seed = Seed::from_u64(1);
        for (name, shape) in ["first", "second"].into_iter().zip(SHAPES) {
            parameters.draw(name.into(), shape, 1.0, &seed);
        }
        parameters
    }

    fn numbers<T: Multiply>(count: usize, rate: f64) -> Vec<T> {
        (0..count).map(|k| T::of((rate * k as f64 + 0.3).sin())).collect()
    }

    /// Pushes so many rows for the first matrix, 500 at a time, and for the second rows of two kinds; returns what the gradients should be.
    fn push<T: Multiply>(
        rows: usize,
        accumulator: &mut GradientAccumulator<T>,
        buffers: &mut Buffers<T>,
        gradients: &mut Gradients,
    ) -> [Vec<f64>; 2] {
        let mut expected = SHAPES.map(|[inputs, outputs]| vec![0.0; inputs * outputs]);
        let mut add =
            |matrix: usize, first: usize, [inputs, outputs]: [usize; 2], power: f64, x: &[T], d: &[T]| {
                for (x, d) in x.chunks_exact(inputs).zip(d.chunks_exact(outputs)) {
                    for (i, x) in x.iter().enumerate() {
                        for (j, d) in d.iter().enumerate() {
                            expected[matrix][(first + i) * outputs + j] += power * x.wide() * d.wide();
                        }
                    }
                }
            };
        let [[inputs, outputs], second] = SHAPES;
        for start in (0..rows).step_by(500) {
            let some = 500.min(rows - start);
            let (x, d) = (numbers(some * inputs, 0.7 + start as f64), numbers(some * outputs, 0.9));
            accumulator.push(0, [inputs, outputs], (&x, &d), buffers, gradients);
            add(0, 0, [inputs, outputs], 1.0, &x, &d);
        }
        // As a graph filter of two taps in the basis of two eigenvectors, and then as one map of their stacked inputs.
        let shape = Shape { inputs: second[0] / 2, outputs: second[1], taps: 2 };
        let of_both: Vec<(f64, Vec<T>, Vec<T>)> = [0.5, -0.25]
            .into_iter()
            .map(|value| {
                (value, numbers(9 * shape.inputs, 1.1 + value), numbers(9 * shape.outputs, 1.3 - value))
            })
            .collect();
        let terms = of_both.iter().map(|(value, x, d)| (T::of(*value), x.as_slice(), d.as_slice()));
        accumulator.push_all(1, shape, terms, buffers, gradients);
        for (value, x, d) in &of_both {
            add(1, 0, [shape.inputs, shape.outputs], 1.0, x, d);
            add(1, shape.inputs, [shape.inputs, shape.outputs], *value, x, d);
        }
        let (x, d) = (numbers(2 * second[0], 1.7), numbers(2 * second[1], 0.2));
        accumulator.push(1, second, (&x, &d), buffers, gradients);
        add(1, 0, second, 1.0, &x, &d);
        expected
    }

    fn check<T: Multiply>(precision: Precision, tolerance: f64) {
        let parameters = parameters(precision);
        // Few rows, many, and so many that some are multiplied before the others come.
        for rows in [7, 900, 5300] {
            let (mut accumulator, mut buffers) = (GradientAccumulator::<T>::none(2), Buffers::default());
            let mut gradients = Gradients::none(&parameters);
            // What an abandoned computation leaves behind is forgotten.
            push(3, &mut accumulator, &mut buffers, &mut gradients);
            accumulator.clear();
            gradients.clear();
            let expected = push(rows, &mut accumulator, &mut buffers, &mut gradients);
            accumulator.multiply(&mut buffers, &mut gradients);
            for (index, expected) in expected.iter().enumerate() {
                let found = gradients.host(index).unwrap();
                let size = expected.iter().fold(1.0_f64, |size, value| size.max(value.abs()));
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < tolerance * size), "{rows}");
            }
            accumulator.multiply(&mut buffers, &mut gradients);
            assert_eq!(accumulator.matrices[0].rows(), 0, "nothing is multiplied twice");
        }
    }

    #[test]
    fn gradients_are_those_of_the_definition_however_many_rows_wait() {
        check::<f32>(Precision::F32, 1e-5);
        check::<f64>(Precision::F64, 1e-12);
    }
}
