//! The linearised proposal in the space of the noise: for models whose states have no density.

use motes_models::batch::{LANES, by_widest_vectors, load, particles_by_stream, store, with_scratch};
use motes_models::equations::triangle::{at, factor_from_last, solve_lower, solve_upper};
use motes_models::equations::{Guide, Lanes, NoiseSpace};
use motes_models::{Stream, fill_standard_normal, fill_uniform};

use super::scoring::add_measurement;
use super::scratch::{LinearisedScratch, lanes};
use crate::proposal::Context;
use crate::proposals::noise_share::weigh_with_share;

/// The distributions of a block of particles: of each particle's noise `v`, `(1 − α) N(m, Λ⁻¹) + α N(0, I)`.
pub(super) struct NoiseBatch<'a> {
    pub(super) model: &'a dyn NoiseSpace,
    pub(super) context: Context<'a>,
    /// `N` and `Q`.
    pub(super) states: usize,
    pub(super) draws: usize,
    pub(super) scratch: &'a mut LinearisedScratch,
}

impl NoiseBatch<'_> {
    /// Finds `m` and `L`, `Λ = Lᵀ L`, from what the measurement says of the noise near 0.
    pub(super) fn condition(&mut self, measurement: &[Option<Lanes>]) {
        let NoiseBatch { model, context, states: n, draws, scratch } = self;
        let (n, m, draws) = (*n, measurement.len(), *draws);
        let (tiles, triangle) = (context.particles.div_ceil(LANES), draws * (draws + 1) / 2);
        let LinearisedScratch { means, factors, tile, .. } = &mut **scratch;
        means.resize(tiles * draws * LANES, 0.0);
        factors.resize(tiles * triangle * LANES, 0.0);
        // Lanes without a particle are computed, too: with numbers that are no danger.
        tile.clear();
        tile.resize((n + (2 + draws) * m) * LANES, 0.0);
        let (previous, rest) = tile.split_at_mut(n * LANES);
        let (slopes, rest) = rest.split_at_mut(m * LANES);
        let (information, jacobian) = rest.split_at_mut(m * LANES);
        let gaussians = means.chunks_exact_mut(draws * LANES).zip(factors.chunks_exact_mut(triangle * LANES));
        for (number, (mean, lower)) in gaussians.enumerate() {
            let before = context.previous.map(|rows| {
                rows.load(number * LANES, previous);
                &*previous
            });
            model.tile_noise_scores(&context.step, before, measurement, slopes, information, jacobian);
            by_widest_vectors(
                #[inline(always)]
                || score(lanes(slopes), lanes(information), lanes(jacobian), lanes(mean), lanes(lower)),
            );
        }
    }

    /// Draws the noise of each particle, writes the states that it leads to into `states` (`R×N`), and `log p(v) − log q(v)` into `log_ratios` (`R`); `α` is the `share`.
    /// The particles are split evenly over `streams`, in order.
    pub(super) fn sample(
        &mut self,
        share: f64,
        streams: &mut [Stream],
        states: &mut [f64],
        log_ratios: &mut [f64],
    ) {
        let NoiseBatch { model, context, states: n, draws, scratch } = self;
        let (n, q, particles) = (*n, *draws, log_ratios.len());
        let LinearisedScratch { means, factors, noise, uniforms, .. } = &mut **scratch;
        noise.resize(particles * q, 0.0);
        for (stream, noise) in particles_by_stream(streams, noise, q, particles) {
            fill_standard_normal(stream, noise);
        }
        uniforms.clear();
        uniforms.resize(particles, 1.0);
        if share > 0.0 {
            for (stream, uniforms) in particles_by_stream(streams, uniforms, 1, particles) {
                fill_uniform(stream, uniforms);
            }
        }
        let gaussians =
            means.chunks_exact_mut(q * LANES).zip(factors.chunks_exact_mut(q * (q + 1) / 2 * LANES));
        with_scratch((q + 2 * n) * LANES, |scratch| {
            scratch.fill(0.0);
            let (z, rest) = scratch.split_at_mut(q * LANES);
            let (previous, now) = rest.split_at_mut(n * LANES);
            for (number, (mean, lower)) in gaussians.enumerate() {
                let (first, last) = (number * LANES, ((number + 1) * LANES).min(particles));
                load(&noise[first * q..last * q], q, z);
                let mut is_from_prior = [false; LANES];
                for (is_from_prior, uniform) in is_from_prior.iter_mut().zip(&uniforms[first..last]) {
                    *is_from_prior = *uniform < share;
                }
                let before = context.previous.map(|rows| {
                    rows.load(first, previous);
                    &*previous
                });
                let guide = Guide { means: lanes(mean), lower: lanes(lower), is_from_prior: &is_from_prior };
                let log_ratio = model.tile_guided_states(&context.step, before, guide, z, now);
                log_ratios[first..last].copy_from_slice(&log_ratio.0[..last - first]);
                store(now, n, &mut states[first * n..last * n]);
            }
        });
        weigh_with_share(log_ratios, share);
    }
}

/// `Λ = I + Σ_j I_j J_j J_jᵀ` as its factor, and the mean `Λ⁻¹ Σ_j s_j J_j`.
#[inline(always)]
fn score(
    slopes: &mut [Lanes],
    information: &mut [Lanes],
    jacobian: &mut [Lanes],
    mean: &mut [Lanes],
    lower: &mut [Lanes],
) {
    let q = mean.len();
    mean.fill(Lanes::from(0.0));
    lower.fill(Lanes::from(0.0));
    for i in 0..q {
        lower[at(i, i)] = Lanes::from(1.0);
    }
    add_measurement(slopes, information, jacobian, mean, lower);
    factor_from_last(q, lower);
    solve_upper(q, lower, mean);
    solve_lower(q, lower, mean);
}
