//! The transform in training.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Accum, Mat, MatRef, Par};
use motes_models::Stream;
use motes_smc::{Past, ProposalError};

use super::map::{Activations, Map, Square, times};
use super::propose::fill_uniform;
use super::{FIRST, Psi};
use crate::{Gradients, Learnable, Parameters, Tape, Workspace};

impl Learnable for Psi {
    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    fn horizon(&self) -> Option<usize> {
        Some(self.horizon)
    }

    fn state_dim(&self) -> usize {
        self.state_dim
    }

    fn measurement_dim(&self) -> usize {
        self.measurement_dim
    }

    fn fill_noise(&self, stream: &mut Stream, noise: &mut [f64]) {
        fill_uniform(stream, noise);
    }

    fn tape(&self, _particles: usize, workspace: Workspace) -> Box<dyn Tape + '_> {
        Box::new(PsiTape { proposal: self, draws: Vec::new(), gradients: workspace.open_gradients() })
    }
}

/// Everything that the way back needs.
struct PsiTape<'p> {
    proposal: &'p Psi,
    draws: Vec<Draw>,
    gradients: Gradients,
}

struct Draw {
    time: usize,
    map: Map,
    previous: Option<Vec<f64>>,
    measurement: Vec<f64>,
    noise: Vec<f64>,
    activations: Activations,
}

impl Tape for PsiTape<'_> {
    fn draw(
        &mut self,
        past: Past<'_>,
        noise: &[f64],
        states: &mut [f64],
        log_density: &mut [f64],
    ) -> Result<(), ProposalError> {
        let (map, shifts) = self.proposal.conditioned(&past)?;
        let activations = map.forward(&shifts, noise, states, log_density);
        self.draws.push(Draw {
            time: past.time,
            map,
            previous: past.previous.map(<[f64]>::to_vec),
            measurement: past.measurement.to_vec(),
            noise: noise.to_vec(),
            activations,
        });
        Ok(())
    }

    /// With `ā` the derivative with respect to a layer's output before tanh and `q̄` that with respect to `log q`:
    /// `W̄ = zᵀ ā − (Σ_k q̄_k) W⁻ᵀ`, `b̄ = Σ_k ā_k`, and below tanh `ā = (ā W ᵀ) ∘ (1 − z²) + 2 q̄ z`.
    fn pull_back(
        &mut self,
        d_states: &[f64],
        d_log_density: &[f64],
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError> {
        let Some(draw) = self.draws.pop() else { panic!("there is no draw left to pull back") };
        let n = self.proposal.state_dim;
        let first = self.proposal.first(draw.time);
        let total: f64 = d_log_density.iter().sum();
        let mut d = d_states.to_vec();
        let mut below = vec![0.0; d.len()];
        for (layer, ((square, _), inputs)) in draw.map.layers.iter().zip(&draw.activations).enumerate().rev()
        {
            let at = first + FIRST + 2 * layer;
            self.add_square(at, square, inputs, &d, total);
            self.gradients.add_wide(at + 1, &column_sums(&d, n));
            times(&d, square.matrix.transpose(), &mut below);
            let rows = below.chunks_exact_mut(n).zip(inputs.chunks_exact(n)).zip(d_log_density);
            for ((below, inputs), d_log_density) in rows {
                for (below, z) in below.iter_mut().zip(inputs) {
                    *below = *below * (1.0 - z * z) + 2.0 * d_log_density * z;
                }
            }
            std::mem::swap(&mut d, &mut below);
        }
        self.add_square(first, &draw.map.noise, &draw.noise, &d, total);
        d_previous.fill(0.0);
        if let Some(previous) = &draw.previous {
            self.gradients.add_wide(first + 1, &outer(previous, &d, n, n));
            times(&d, draw.map.previous.transpose(), d_previous);
        }
        let sums = column_sums(&d, n);
        let outer: Vec<f64> = draw.measurement.iter().flat_map(|y| sums.iter().map(move |s| y * s)).collect();
        self.gradients.add_wide(first + 2, &outer);
        Ok(())
    }

    /// The particles carry nothing.
    fn cut(&mut self) {}

    fn finish(self: Box<Self>) -> Workspace {
        Workspace::closed_gradients(self.gradients)
    }
}

impl PsiTape<'_> {
    /// Adds the gradient of an invertible matrix: through its product with `inputs`, and through its determinant.
    fn add_square(&mut self, index: usize, square: &Square, inputs: &[f64], d: &[f64], total: f64) {
        let n = self.proposal.state_dim;
        let mut gradient = outer(inputs, d, n, n);
        if total != 0.0 {
            let inverse = square.factors.inverse();
            for (at, gradient) in gradient.iter_mut().enumerate() {
                *gradient -= total * inverse[(at % n, at / n)];
            }
        }
        self.gradients.add_wide(index, &gradient);
    }
}

/// `Σ_k left_kᵀ right_k` of row-major rows, row-major.
fn outer(left: &[f64], right: &[f64], left_width: usize, right_width: usize) -> Vec<f64> {
    let count = left.len() / left_width;
    let left = MatRef::from_column_major_slice(left, left_width, count);
    let right = MatRef::from_column_major_slice(right, right_width, count);
    let mut product = Mat::zeros(left_width, right_width);
    matmul(&mut product, Accum::Replace, left, right.transpose(), 1.0, Par::Seq);
    (0..left_width * right_width).map(|at| product[(at / right_width, at % right_width)]).collect()
}

fn column_sums(rows: &[f64], width: usize) -> Vec<f64> {
    let mut sums = vec![0.0; width];
    for row in rows.chunks_exact(width) {
        sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
    }
    sums
}
