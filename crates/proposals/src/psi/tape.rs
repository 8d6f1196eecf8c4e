//! The transform in training.

use motes_models::Stream;
use motes_models::batch::by_widest_vectors;
use motes_networks::{Gradients, Inputs, Parameters, Workspace};
use motes_smc::ProposalError;
use pulp::{Simd, WithSimd};

use super::map::{Inverses, Map};
use super::propose::fill_uniform;
use super::transform::{FIRST, Psi};
use crate::family::Parametric;
use crate::lanes::{Blocks, LANES, Lane, set_times_transposed};
use crate::learnable::{Learnable, Tape};

impl Parametric for Psi {
    fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    fn horizon(&self) -> Option<usize> {
        self.horizon
    }

    fn state_dim(&self) -> usize {
        self.state_dim
    }

    fn measurement_dim(&self) -> usize {
        self.measurement_dim
    }
}

impl Learnable for Psi {
    fn fill_noise(&self, stream: &mut Stream, noise: &mut [f64]) {
        fill_uniform(stream, noise);
    }

    fn tape(&self, particles: usize, workspace: Workspace) -> Result<Box<dyn Tape + '_>, ProposalError> {
        let (n, layers, blocks) = (self.state_dim, self.config.layers, particles.div_ceil(LANES));
        Ok(Box::new(PsiTape {
            proposal: self,
            draws: Vec::new(),
            gradients: workspace.into_cleared_gradients(),
            given: vec![Lane::default(); blocks * 2 * n],
            derivatives: vec![Lane::default(); blocks * (layers + 1) * n],
        }))
    }
}

/// Everything that the way back needs.
struct PsiTape<'p> {
    proposal: &'p Psi,
    draws: Vec<Draw>,
    gradients: Gradients,
    // On the way back, each block of particles after the other:
    /// `u` and `x_{t−1}`.
    given: Vec<Lane>,
    /// With respect to the values before the first tanh, then to the output of each layer.
    derivatives: Vec<Lane>,
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
        inputs: &Inputs<'_>,
        noise: &[f64],
        states: &mut [f64],
        log_density: Option<&mut [f64]>,
    ) -> Result<(), ProposalError> {
        let (map, shifts) = self.proposal.conditioned(inputs)?;
        let inverses =
            log_density.is_some().then(|| self.proposal.inverses(&map, inputs.time)).transpose()?;
        let log_density = inverses.as_ref().map(|inverses| inverses.log_abs_det).zip(log_density);
        let activations = map.forward(&shifts, noise, states, log_density);
        self.draws.push(Draw {
            time: inputs.time,
            map,
            inverses,
            previous: inputs.previous.map(<[f64]>::to_vec),
            measurement: inputs.measurement.to_vec(),
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
        d_previous.fill(0.0);
        let work = self.given.chunks_mut(2 * n).zip(self.derivatives.chunks_mut((layers + 1) * n));
        for ((block, d_states), (given, derivatives)) in d_states.chunks(rows).enumerate().zip(work) {
            let at = block * rows..block * rows + d_states.len();
            let particles = block * LANES..block * LANES + d_states.len() / n;
            let d_log = d_log_density.map_or(Lane::default(), |d| Lane::gather_or_zero(&d[particles], 1, 0));
            let block = Block {
                noise: &draw.noise[at.clone()],
                previous: draw.previous.as_ref().map(|previous| &previous[at.clone()]),
                activations: &draw.activations[block * layers * n..(block + 1) * layers * n],
            };
            by_widest_vectors(
                #[inline(always)]
                || {
                    block.pull_back(
                        &draw.map,
                        d_states,
                        &d_log,
                        &mut d_previous[at.clone()],
                        given,
                        derivatives,
                    )
                },
            );
        }
        let [noise, previous] =
            [0, n].map(|start| Blocks { lanes: &self.given[start..], width: n, stride: 2 * n });
        let derivative = |number: usize| Blocks {
            lanes: &self.derivatives[number * n..],
            width: n,
            stride: (layers + 1) * n,
        };
        let first = self.proposal.first(draw.time);
        for layer in 0..layers {
            let at = first + FIRST + 2 * layer;
            let inputs = Blocks { lanes: &draw.activations[layer * n..], width: n, stride: layers * n };
            let d_outputs = derivative(layer + 1);
            let of_density = of_density.map(|(inverses, total)| (inverses.layers[layer].as_slice(), total));
            self.gradients.add_wide(at, &of_square(inputs.outer(d_outputs), of_density, n));
            self.gradients.add_wide(at + 1, &d_outputs.sums());
        }
        let of_density = of_density.map(|(inverses, total)| (inverses.noise.as_slice(), total));
        self.gradients.add_wide(first, &of_square(noise.outer(derivative(0)), of_density, n));
        if draw.previous.is_some() {
            self.gradients.add_wide(first + 1, &previous.outer(derivative(0)));
        }
        let common = derivative(0).sums();
        let outer = draw.measurement.iter().flat_map(|y| common.iter().map(move |s| y * s));
        self.gradients.add_wide(first + 2, &outer.collect::<Vec<f64>>());
        Ok(())
    }

    /// The particles carry nothing.
    fn detach(&mut self) {}

    fn finish(self: Box<Self>) -> Workspace {
        self.gradients.into()
    }
}

/// The gradient of an invertible matrix: through its product with inputs, and through its determinant if there is a derivative with respect
/// to `log q`, by its inverse and the sum of that derivative over the particles.
fn of_square(mut through_product: Vec<f64>, of_density: Option<(&[f64], f64)>, n: usize) -> Vec<f64> {
    if let Some((inverse, total)) = of_density {
        for (at, gradient) in through_product.iter_mut().enumerate() {
            *gradient -= total * inverse[at % n * n + at / n];
        }
    }
    through_product
}

/// A few particles of one draw.
struct Block<'a> {
    noise: &'a [f64],
    previous: Option<&'a [f64]>,
    activations: &'a [Lane],
}

impl Block<'_> {
    /// Fills `given` and `derivatives` of the block.
    #[inline(always)]
    fn pull_back(
        &self,
        map: &Map,
        d_states: &[f64],
        d_log: &Lane,
        d_previous: &mut [f64],
        given: &mut [Lane],
        derivatives: &mut [Lane],
    ) {
        let n = map.width;
        // In lanes without a particle nothing changes anything.
        let (rest, last) = derivatives.split_at_mut(map.layers.len() * n);
        last.iter_mut().enumerate().for_each(|(j, d)| *d = Lane::gather_or_zero(d_states, n, j));
        let mut above: &[Lane] = last;
        let each = rest.chunks_exact_mut(n).zip(self.activations.chunks_exact(n)).zip(&map.layers);
        for ((below, inputs), (matrix, _)) in each.rev() {
            set_times_transposed(below, above, matrix);
            pulp::Arch::new().dispatch(BelowTanh { d: below, d_log, z: inputs });
            above = below;
        }
        let (noise, states) = given.split_at_mut(n);
        noise.iter_mut().enumerate().for_each(|(i, u)| *u = Lane::gather(self.noise, n, i));
        let Some(previous) = self.previous else { return };
        states.iter_mut().enumerate().for_each(|(i, x)| *x = Lane::gather(previous, n, i));
        let mut d = vec![Lane::default(); n];
        set_times_transposed(&mut d, above, &map.previous);
        d.iter().enumerate().for_each(|(i, d)| d.scatter(d_previous, n, i));
    }
}

/// `d = d (1 − z²) + 2 q̄ z`, from outputs of tanh to what it was taken of.
struct BelowTanh<'a> {
    d: &'a mut [Lane],
    d_log: &'a Lane,
    z: &'a [Lane],
}

impl WithSimd for BelowTanh<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (one, two) = (simd.splat_f64s(1.0), simd.splat_f64s(2.0));
        let (d_log, _) = S::as_simd_f64s(&self.d_log.0);
        for (d, z) in self.d.iter_mut().zip(self.z) {
            let ((d, _), (z, _)) = (S::as_mut_simd_f64s(&mut d.0), S::as_simd_f64s(&z.0));
            for ((d, z), d_log) in d.iter_mut().zip(z).zip(d_log) {
                let slope = simd.sub_f64s(one, simd.mul_f64s(*z, *z));
                let of_density = simd.mul_f64s(simd.mul_f64s(two, *d_log), *z);
                *d = simd.add_f64s(simd.mul_f64s(*d, slope), of_density);
            }
        }
    }
}
