//! A block of particles that look ahead: draws and weights.

use motes_models::batch::{LANES, by_widest_vectors, load, particles_by_stream, store};
use motes_models::equations::triangle::at;
use motes_models::equations::{Guide, Lanes, Linearise, NoiseSpace, Scalar};
use motes_models::{Stream, fill_standard_normal, fill_uniform};

use super::ahead::StepAhead;
use super::scratch::{LookAheadScratch, TileGuide};
use crate::proposal::{Conditional, Context};
use crate::proposals::{Transition, lanes, weigh_with_share};

/// The distributions of a block of particles: of each particle's noise `v`, `(1 − α) N(v; 0, I) ψ̃(v) / Z̃ + α N(v; 0, I)`.
pub struct LookAheadBatch<'a, M: ?Sized> {
    pub(super) model: &'a M,
    pub(super) noise_space: &'a dyn NoiseSpace,
    pub(super) context: Context<'a>,
    pub(super) now: &'a StepAhead,
    /// The step after this one, if there is one.
    pub(super) next: Option<&'a StepAhead>,
    /// Whether weights have `Z̃_t(x_{t−1})`, which is so where no potential before this one stood for it.
    pub(super) is_alone: bool,
    pub(super) scratch: &'a mut LookAheadScratch,
}

/// What particles of a tile are drawn with.
struct Numbers<'a> {
    /// Standard normal, `Q × LANES`.
    normals: &'a mut [f64],
    is_from_prior: &'a [bool; LANES],
    /// Of each particle, to choose one of several quadratics by.
    uniforms: &'a [f64; LANES],
}

impl<M: Linearise + ?Sized> LookAheadBatch<'_, M> {
    /// Draws the states of a tile by its guide; `log q − log p` of their noise.
    fn draw_tile(
        &self,
        guide: &mut TileGuide,
        previous: Option<&[f64]>,
        numbers: Numbers<'_>,
        expected: Lanes,
        states: &mut [f64],
    ) -> Lanes {
        let Numbers { normals, is_from_prior, uniforms } = numbers;
        if self.now.components.len() > 1 {
            let StepAhead { components, variances, .. } = self.now;
            let log = by_widest_vectors(
                #[inline(always)]
                || {
                    guide.choose(uniforms);
                    guide.draw_chosen(is_from_prior, normals);
                    guide.log_mixture(components, variances.is_some(), normals)
                },
            );
            match variances {
                // Normal draws lie on their line.
                Some(_) => states.copy_from_slice(&guide.centres),
                None => self.noise_space.tile_states(&self.context.step, previous, normals, states),
            }
            return log - expected;
        }
        let TileGuide { centres, jacobian, mean, lower, .. } = guide;
        if self.now.variances.is_some() {
            let guide = Guide { means: lanes(mean), lower: lanes(lower), is_from_prior };
            return draw_coordinates(guide, lanes(centres), lanes(jacobian), lanes(normals), lanes(states));
        }
        let guide = Guide { means: lanes(mean), lower: lanes(lower), is_from_prior };
        self.noise_space.tile_guided_states(&self.context.step, previous, guide, normals, states)
    }
}

/// `x_i = c_i + S_i v_i` of guided noise; `log q − log p` of it. The `normals` are used up.
fn draw_coordinates(
    guide: Guide<'_>,
    centres: &[Lanes],
    sds: &[Lanes],
    normals: &mut [Lanes],
    states: &mut [Lanes],
) -> Lanes {
    let mut log_ratio = Lanes::from(0.0);
    for i in 0..states.len() {
        let row = &guide.lower[at(i, 0)..=at(i, i)];
        let (mean, scale) = (guide.means[i], row[i]);
        let mut sum = Lanes::from(0.0);
        for (entry, deviation) in row.iter().zip(&normals[..i]) {
            sum = sum + *entry * *deviation;
        }
        let centre = mean - sum / scale;
        let mut z = normals[i];
        let mut v = centre + z / scale;
        for (lane, _) in guide.is_from_prior.iter().enumerate().filter(|(_, is_from_prior)| **is_from_prior) {
            v.0[lane] = z.0[lane];
            z.0[lane] = (v.0[lane] - centre.0[lane]) * scale.0[lane];
        }
        log_ratio = log_ratio + scale.ln() + (v * v - z * z) * 0.5;
        normals[i] = v - mean;
        states[i] = centres[i] + sds[i] * v;
    }
    log_ratio
}

impl<M: Linearise + ?Sized> Conditional for LookAheadBatch<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_densities: &mut [f64]) {
        Transition::new(self.model, self.context).sample(streams, states, log_densities);
    }

    fn log_density(&mut self, states: &[f64], log_densities: &mut [f64]) {
        Transition::new(self.model, self.context).log_density(states, log_densities);
    }

    /// Beside the ratio of densities the weights of a look-ahead filter have `Z̃_{t+1}(x_t) / Z̃_t(x_{t−1})`, and at the start `Z̃_1(x_0)` alone.
    fn sample_by_noise(
        &mut self,
        share: Option<f64>,
        streams: &mut [Stream],
        states: &mut [f64],
        log_ratios: &mut [f64],
    ) -> bool {
        let (n, q, particles) = (self.model.state_dim(), self.now.draws(), log_ratios.len());
        let share = share.unwrap_or(self.now.share);
        let mut scratch = std::mem::take(self.scratch);
        scratch.fit(n, q);
        let LookAheadScratch { noise, uniforms, states: [before, now], normals, guide } = &mut scratch;
        noise.resize(particles * q, 0.0);
        for (stream, noise) in particles_by_stream(streams, noise, q, particles) {
            fill_standard_normal(stream, noise);
        }
        uniforms.clear();
        uniforms.resize(particles, 1.0);
        let is_mixed = self.now.components.len() > 1;
        if share > 0.0 || is_mixed {
            for (stream, uniforms) in particles_by_stream(streams, uniforms, 1, particles) {
                fill_uniform(stream, uniforms);
            }
        }
        let step = self.context.step;
        for first in (0..particles).step_by(LANES) {
            let last = (first + LANES).min(particles);
            load(&noise[first * q..last * q], q, normals);
            let (mut is_from_prior, mut rest) = ([false; LANES], [0.0; LANES]);
            for (lane, uniform) in uniforms[first..last].iter().enumerate() {
                is_from_prior[lane] = *uniform < share;
                rest[lane] = (uniform - share) / (1.0 - share);
            }
            let previous = self.context.previous.map(|rows| {
                rows.load(first, before);
                before.as_slice()
            });
            let expected = guide.find(self.model, self.noise_space, self.now, &step, previous);
            let numbers = Numbers { normals, is_from_prior: &is_from_prior, uniforms: &rest };
            let mut weight = self.draw_tile(guide, previous, numbers, expected, now);
            weigh_with_share(&mut weight.0, share);
            if previous.is_some() && !self.is_alone {
                weight = weight - expected;
            }
            if let Some(next) = self.next {
                let step = next.step.step();
                weight = weight + guide.find(self.model, self.noise_space, next, &step, Some(now));
            }
            log_ratios[first..last].copy_from_slice(&weight.0[..last - first]);
            store(now, n, &mut states[first * n..last * n]);
        }
        *self.scratch = scratch;
        true
    }
}
