//! Gaussians of a block of particles, each with its own mean and precision: draws and densities.

use motes_models::batch::{LANES, by_widest_vectors, load, particles_by_stream, store, with_scratch};
use motes_models::equations::triangle::{at, solve_upper, times_upper};
use motes_models::equations::{Lanes, Scalar};
use motes_models::{LN_2PI, Stream, fill_standard_normal};

use super::scratch::{LinearisedScratch, lanes};
use crate::proposal::Conditional;

/// `N(m, Λ⁻¹)` of each particle of a block, `Λ = L Lᵀ`.
pub(super) struct PrecisionBatch<'a> {
    /// `N`.
    pub(crate) width: usize,
    /// `m` and `L` of each particle.
    pub(crate) gaussians: &'a mut LinearisedScratch,
}

/// `Σ_i log L_ii − ½ |z|² − (N/2) log 2π`.
#[inline(always)]
fn log_density(n: usize, lower: &[Lanes], z: &[Lanes]) -> Lanes {
    let mut sum = Lanes::from(-0.5 * LN_2PI * n as f64);
    for (i, z) in z.iter().enumerate() {
        sum = sum + lower[at(i, i)].ln() - *z * *z * 0.5;
    }
    sum
}

impl Conditional for PrecisionBatch<'_> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_densities: &mut [f64]) {
        let n = self.width;
        let LinearisedScratch { means, factors, tile, noise, .. } = &mut *self.gaussians;
        noise.resize(states.len(), 0.0);
        for (stream, noise) in particles_by_stream(streams, noise, n, log_densities.len()) {
            fill_standard_normal(stream, noise);
        }
        let tile = &mut tile[..n * LANES];
        let gaussians =
            means.chunks_exact_mut(n * LANES).zip(factors.chunks_exact_mut(n * (n + 1) / 2 * LANES));
        let rows =
            noise.chunks(n * LANES).zip(states.chunks_mut(n * LANES)).zip(log_densities.chunks_mut(LANES));
        for ((mean, lower), ((noise, states), out)) in gaussians.zip(rows) {
            load(noise, n, tile);
            let (mean, lower, z) = (lanes(mean), lanes(lower), lanes(tile));
            let density = by_widest_vectors(
                #[inline(always)]
                || {
                    let density = log_density(n, lower, z);
                    solve_upper(n, lower, z);
                    for (z, mean) in z.iter_mut().zip(&*mean) {
                        *z = *z + *mean;
                    }
                    density
                },
            );
            out.copy_from_slice(&density.0[..out.len()]);
            store(tile, n, states);
        }
    }

    fn log_density(&mut self, states: &[f64], log_densities: &mut [f64]) {
        let n = self.width;
        let LinearisedScratch { means, factors, .. } = &mut *self.gaussians;
        let gaussians =
            means.chunks_exact_mut(n * LANES).zip(factors.chunks_exact_mut(n * (n + 1) / 2 * LANES));
        let rows = states.chunks(n * LANES).zip(log_densities.chunks_mut(LANES));
        with_scratch(n * LANES, |tile| {
            tile.fill(0.0);
            for ((mean, lower), (states, out)) in gaussians.zip(rows) {
                load(states, n, tile);
                let (mean, lower, z) = (lanes(mean), lanes(lower), lanes(tile));
                let density = by_widest_vectors(
                    #[inline(always)]
                    || {
                        for (z, mean) in z.iter_mut().zip(&*mean) {
                            *z = *z - *mean;
                        }
                        times_upper(n, lower, z);
                        log_density(n, lower, z)
                    },
                );
                out.copy_from_slice(&density.0[..out.len()]);
            }
        });
    }
}
