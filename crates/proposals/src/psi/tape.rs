//! The transform in training.

use motes_models::Stream;
use motes_smc::{Past, ProposalError};

use super::map::{Invertible, Map};
use super::propose::fill_uniform;
use super::{FIRST, Psi};
use crate::lanes::{LANES, Lane, Square, vectorised};
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
    /// Of each block of particles, the outputs of all layers before their products: what [`Map::forward`] returned.
    activations: Vec<Lane>,
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
        let (rows, layers) = (LANES * n, draw.map.layers.len());
        let mut sums = Sums::zeros(n, layers);
        d_previous.fill(0.0);
        for (block, d_log) in d_log_density.chunks(LANES).enumerate() {
            let at = block * rows..(block * rows + d_log.len() * n);
            let block = Block {
                noise: &draw.noise[at.clone()],
                previous: draw.previous.as_ref().map(|previous| &previous[at.clone()]),
                activations: &draw.activations[block * layers * n..(block + 1) * layers * n],
            };
            vectorised(
                #[inline(always)]
                || block.pull_back(&draw.map, &d_states[at.clone()], d_log, &mut d_previous[at], &mut sums),
            );
        }
        let (first, total): (usize, f64) = (self.proposal.first(draw.time), d_log_density.iter().sum());
        for (layer, (invertible, _)) in draw.map.layers.iter().enumerate() {
            let at = first + FIRST + 2 * layer;
            self.add_square(at, invertible, &sums.layers[layer], total);
            let bias: Vec<f64> = sums.biases[layer].iter().map(Lane::sum).collect();
            self.gradients.add_wide(at + 1, &bias);
        }
        self.add_square(first, &draw.map.noise, &sums.noise, total);
        if draw.previous.is_some() {
            self.gradients.add_wide(first + 1, &sums.previous.sums());
        }
        let common: Vec<f64> = sums.shifts.iter().map(Lane::sum).collect();
        let outer = draw.measurement.iter().flat_map(|y| common.iter().map(move |s| y * s));
        self.gradients.add_wide(first + 2, &outer.collect::<Vec<f64>>());
        Ok(())
    }

    /// The particles carry nothing.
    fn cut(&mut self) {}

    fn finish(self: Box<Self>) -> Workspace {
        Workspace::closed_gradients(self.gradients)
    }
}

impl PsiTape<'_> {
    /// Adds the gradient of an invertible matrix: through its product with inputs, and through its determinant.
    fn add_square(&mut self, index: usize, invertible: &Invertible, through_product: &Square, total: f64) {
        let n = self.proposal.state_dim;
        let mut gradient = through_product.sums();
        for (at, gradient) in gradient.iter_mut().enumerate() {
            *gradient -= total * invertible.inverse[at % n * n + at / n];
        }
        self.gradients.add_wide(index, &gradient);
    }
}

/// What is added up over the blocks of particles.
struct Sums {
    noise: Square,
    previous: Square,
    /// Of the values before the first tanh.
    shifts: Vec<Lane>,
    layers: Vec<Square>,
    biases: Vec<Vec<Lane>>,
}

impl Sums {
    fn zeros(width: usize, layers: usize) -> Self {
        Sums {
            noise: Square::zeros(width),
            previous: Square::zeros(width),
            shifts: vec![Lane::default(); width],
            layers: (0..layers).map(|_| Square::zeros(width)).collect(),
            biases: vec![vec![Lane::default(); width]; layers],
        }
    }
}

/// A few particles of one draw.
struct Block<'a> {
    noise: &'a [f64],
    previous: Option<&'a [f64]>,
    activations: &'a [Lane],
}

impl Block<'_> {
    #[inline(always)]
    fn pull_back(
        &self,
        map: &Map,
        d_states: &[f64],
        d_log_density: &[f64],
        d_previous: &mut [f64],
        sums: &mut Sums,
    ) {
        let n = map.width;
        // In lanes without a particle nothing changes anything.
        let d_log = Lane::gather_or_zero(d_log_density, 1, 0);
        let mut d: Vec<Lane> = (0..n).map(|j| Lane::gather_or_zero(d_states, n, j)).collect();
        let mut below = vec![Lane::default(); n];
        for (layer, (invertible, _)) in map.layers.iter().enumerate().rev() {
            let inputs = &self.activations[layer * n..(layer + 1) * n];
            sums.biases[layer].iter_mut().zip(&d).for_each(|(sum, d)| sum.add(d));
            for (i, (z, row)) in inputs.iter().zip(invertible.matrix.chunks_exact(n)).enumerate() {
                let mut sum = Lane::default();
                for (j, (d, entry)) in d.iter().zip(row).enumerate() {
                    sums.layers[layer].at_mut(i, j).add_product(z, d);
                    sum.add_scaled(*entry, d);
                }
                for lane in 0..LANES {
                    let z = z.0[lane];
                    sum.0[lane] = sum.0[lane] * (1.0 - z * z) + 2.0 * d_log.0[lane] * z;
                }
                below[i] = sum;
            }
            std::mem::swap(&mut d, &mut below);
        }
        sums.shifts.iter_mut().zip(&d).for_each(|(sum, d)| sum.add(d));
        for i in 0..n {
            let u = Lane::gather(self.noise, n, i);
            d.iter().enumerate().for_each(|(j, d)| sums.noise.at_mut(i, j).add_product(&u, d));
        }
        let Some(previous) = self.previous else { return };
        for (i, row) in map.previous.chunks_exact(n).enumerate() {
            let x = Lane::gather(previous, n, i);
            let mut sum = Lane::default();
            for (j, (d, entry)) in d.iter().zip(row).enumerate() {
                sums.previous.at_mut(i, j).add_product(&x, d);
                sum.add_scaled(*entry, d);
            }
            sum.scatter(d_previous, n, i);
        }
    }
}
