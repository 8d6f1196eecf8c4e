//! The transform in training.

use motes_models::Stream;
use motes_smc::{Past, ProposalError};

use super::map::{Inverses, Map};
use super::propose::fill_uniform;
use super::{FIRST, Psi};
use crate::lanes::{LANES, Lane, Square, add_times_transposed, vectorised};
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
    /// If a log density was asked for.
    inverses: Option<Inverses>,
    previous: Option<Vec<f64>>,
    measurement: Vec<f64>,
    noise: Vec<f64>,
    /// Of each block of particles, what [`Map::forward`] returned.
    activations: Vec<Lane>,
}

impl Tape for PsiTape<'_> {
    fn draw(
        &mut self,
        past: Past<'_>,
        noise: &[f64],
        states: &mut [f64],
        log_density: Option<&mut [f64]>,
    ) -> Result<(), ProposalError> {
        let (map, shifts) = self.proposal.conditioned(&past)?;
        let inverses = log_density.is_some().then(|| self.proposal.inverses(&map, past.time)).transpose()?;
        let log_density = inverses.as_ref().map(|inverses| inverses.log_abs_det).zip(log_density);
        let activations = map.forward(&shifts, noise, states, log_density);
        self.draws.push(Draw {
            time: past.time,
            map,
            inverses,
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
        d_log_density: Option<&[f64]>,
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError> {
        let Some(draw) = self.draws.pop() else { panic!("there is no draw left to pull back") };
        let of_density = d_log_density.map(|d_log_density| {
            let Some(inverses) = &draw.inverses else { panic!("log q was not asked for") };
            (inverses, d_log_density.iter().sum::<f64>())
        });
        let n = self.proposal.state_dim;
        let (rows, layers) = (LANES * n, draw.map.layers.len());
        let mut sums = Sums::zeros(n, layers);
        d_previous.fill(0.0);
        for (block, d_states) in d_states.chunks(rows).enumerate() {
            let at = block * rows..block * rows + d_states.len();
            let particles = block * LANES..block * LANES + d_states.len() / n;
            let d_log = d_log_density.map_or(Lane::default(), |d| Lane::gather_or_zero(&d[particles], 1, 0));
            let block = Block {
                noise: &draw.noise[at.clone()],
                previous: draw.previous.as_ref().map(|previous| &previous[at.clone()]),
                activations: &draw.activations[block * layers * n..(block + 1) * layers * n],
            };
            vectorised(
                #[inline(always)]
                || block.pull_back(&draw.map, d_states, &d_log, &mut d_previous[at], &mut sums),
            );
        }
        let first = self.proposal.first(draw.time);
        for (layer, sum) in sums.layers.iter().enumerate() {
            let at = first + FIRST + 2 * layer;
            let of_density = of_density.map(|(inverses, total)| (inverses.layers[layer].as_slice(), total));
            self.add_square(at, sum, of_density);
            let bias: Vec<f64> = sums.biases[layer].iter().map(Lane::sum).collect();
            self.gradients.add_wide(at + 1, &bias);
        }
        let of_density = of_density.map(|(inverses, total)| (inverses.noise.as_slice(), total));
        self.add_square(first, &sums.noise, of_density);
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
    /// Adds the gradient of an invertible matrix: through its product with inputs, and through its determinant if there is a derivative
    /// with respect to `log q`, by its inverse and the sum of that derivative over the particles.
    fn add_square(&mut self, index: usize, through_product: &Square, of_density: Option<(&[f64], f64)>) {
        let n = self.proposal.state_dim;
        let mut gradient = through_product.sums();
        if let Some((inverse, total)) = of_density {
            for (at, gradient) in gradient.iter_mut().enumerate() {
                *gradient -= total * inverse[at % n * n + at / n];
            }
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
    fn pull_back(&self, map: &Map, d_states: &[f64], d_log: &Lane, d_previous: &mut [f64], sums: &mut Sums) {
        let n = map.width;
        // In lanes without a particle nothing changes anything.
        let mut d: Vec<Lane> = (0..n).map(|j| Lane::gather_or_zero(d_states, n, j)).collect();
        let mut below = vec![Lane::default(); n];
        for (layer, (matrix, _)) in map.layers.iter().enumerate().rev() {
            let inputs = &self.activations[layer * n..(layer + 1) * n];
            for (sum, d) in sums.biases[layer].iter_mut().zip(&d) {
                sum.add(d);
            }
            sums.layers[layer].add_outer(inputs, &d);
            below.fill(Lane::default());
            add_times_transposed(&mut below, &d, matrix);
            for (z, below) in inputs.iter().zip(&mut below) {
                below.0 = std::array::from_fn(|lane| {
                    let z = z.0[lane];
                    below.0[lane] * (1.0 - z * z) + 2.0 * d_log.0[lane] * z
                });
            }
            std::mem::swap(&mut d, &mut below);
        }
        for (sum, d) in sums.shifts.iter_mut().zip(&d) {
            sum.add(d);
        }
        for (i, u) in below.iter_mut().enumerate() {
            *u = Lane::gather(self.noise, n, i);
        }
        sums.noise.add_outer(&below, &d);
        let Some(previous) = self.previous else { return };
        for (i, x) in below.iter_mut().enumerate() {
            *x = Lane::gather(previous, n, i);
        }
        sums.previous.add_outer(&below, &d);
        below.fill(Lane::default());
        add_times_transposed(&mut below, &d, &map.previous);
        for (i, sum) in below.iter().enumerate() {
            sum.scatter(d_previous, n, i);
        }
    }
}
