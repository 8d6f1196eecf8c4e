//! A graph-diffusion system for many particles at once, tile by tile.

use pulp::{Simd, WithSimd};

use super::config::Drift;
use super::system::GraphDiffusion;
use crate::batch::{LANES, Rows, load, store, with_noise, with_scratch};
use crate::{StateSpaceModel, Stream};

/// Draws `φ(A x_{t−1}) + v_t` for each row.
pub(super) fn sample_transitions(
    system: &GraphDiffusion,
    previous: Rows<'_>,
    streams: &mut [Stream],
    states: &mut [f64],
) {
    let n = system.state_dim();
    with_scratch(2 * n * LANES, |scratch| {
        let (from, flow) = scratch.split_at_mut(n * LANES);
        let fill = |stream: &mut Stream, noise: &mut [f64]| system.noise.fill_unit(stream, noise);
        with_noise(streams, n, states.len() / n, fill, |particles, noise| {
            moved(system, previous, particles.start, noise, from, flow);
            store(flow, n, &mut states[particles.start * n..particles.end * n]);
        });
    });
}

/// The tile `flow` becomes `φ(A x_{t−1}) + v_t`, from particle `first` on, with `v_t` made of `noise` of standard deviation 1;
/// `from` is scratch.
fn moved(
    system: &GraphDiffusion,
    previous: Rows<'_>,
    first: usize,
    noise: &[f64],
    from: &mut [f64],
    flow: &mut [f64],
) {
    previous.load(first, from);
    drifted(system, from, flow);
    pulp::Arch::new().dispatch(AddScaled { what: noise, scale: system.state_sigma, to: flow });
}

/// `log p(x_t | x_{t−1})` of each row.
pub(super) fn log_transitions(system: &GraphDiffusion, previous: Rows<'_>, states: &[f64], out: &mut [f64]) {
    let n = system.state_dim();
    with_scratch(2 * n * LANES, |scratch| {
        let (tile, flow) = scratch.split_at_mut(n * LANES);
        for (tile_number, (states, out)) in states.chunks(n * LANES).zip(out.chunks_mut(LANES)).enumerate() {
            previous.load(tile_number * LANES, tile);
            drifted(system, tile, flow);
            load(states, n, tile);
            pulp::Arch::new().dispatch(Subtract { from: tile, what: flow });
            let mut densities = [0.0; LANES];
            system.noise.tile_log_density(system.state_sigma, flow, &mut densities);
            out.copy_from_slice(&densities[..out.len()]);
        }
    });
}

/// `log p(y_t | x_t)` at each row, of a measurement (`M` numbers).
pub(super) fn log_likelihoods<'a>(
    system: &GraphDiffusion,
    states: &[f64],
    measurement: impl Iterator<Item = &'a f64> + Clone,
    out: &mut [f64],
) {
    let (n, m) = (system.state_dim(), system.measurement_dim());
    with_scratch((n + m) * LANES, |scratch| {
        let (tile, residuals) = scratch.split_at_mut(n * LANES);
        for (states, out) in states.chunks(n * LANES).zip(out.chunks_mut(LANES)) {
            load(states, n, tile);
            fill_rows(residuals, measurement.clone());
            tile_log_likelihoods(system, tile, residuals, out);
        }
    });
}

/// Draws `φ(A x_{t−1}) + v_t` for each row, and `log p(y_t | x_t)` at it.
pub(super) fn propagate(
    system: &GraphDiffusion,
    previous: Rows<'_>,
    measurement: &[f64],
    streams: &mut [Stream],
    states: &mut [f64],
    out: &mut [f64],
) {
    let n = system.state_dim();
    with_scratch((2 * n + measurement.len()) * LANES, |scratch| {
        let (from, rest) = scratch.split_at_mut(n * LANES);
        let (flow, residuals) = rest.split_at_mut(n * LANES);
        let fill = |stream: &mut Stream, noise: &mut [f64]| system.noise.fill_unit(stream, noise);
        with_noise(streams, n, out.len(), fill, |particles, noise| {
            moved(system, previous, particles.start, noise, from, flow);
            store(flow, n, &mut states[particles.start * n..particles.end * n]);
            fill_rows(residuals, measurement.iter());
            tile_log_likelihoods(system, flow, residuals, &mut out[particles]);
        });
    });
}

/// Fills each row of a tile with one number.
fn fill_rows<'a>(tile: &mut [f64], numbers: impl Iterator<Item = &'a f64>) {
    for (row, number) in tile.as_chunks_mut::<LANES>().0.iter_mut().zip(numbers) {
        row.fill(*number);
    }
}

/// `log p(y_t | x_t)` of each lane of a tile that there is a place for in `out`; `residuals` (`M × LANES`) holds the measurement in each lane, and is used up.
fn tile_log_likelihoods(system: &GraphDiffusion, tile: &[f64], residuals: &mut [f64], out: &mut [f64]) {
    system.measure.times_subtract(tile, residuals);
    let mut densities = [0.0; LANES];
    system.noise.tile_log_density(system.measurement_sigma, residuals, &mut densities);
    out.copy_from_slice(&densities[..out.len()]);
}

/// `φ(A x_{t−1})` of each row.
pub(super) fn transition_means(system: &GraphDiffusion, previous: &[f64], means: &mut [f64]) {
    let n = system.state_dim();
    with_scratch(2 * n * LANES, |scratch| {
        let (from, flow) = scratch.split_at_mut(n * LANES);
        for (previous, means) in previous.chunks(n * LANES).zip(means.chunks_mut(n * LANES)) {
            load(previous, n, from);
            drifted(system, from, flow);
            store(flow, n, means);
        }
    });
}

/// `φ(A x)` of each lane of a tile, into the tile `flow`.
pub(super) fn drifted(system: &GraphDiffusion, tile: &[f64], flow: &mut [f64]) {
    system.diffuse.times(tile, flow);
    if system.drift != Drift::Identity {
        flow.iter_mut().for_each(|value| *value = system.drift.apply(*value));
    }
}

/// `what = from − what`.
struct Subtract<'a> {
    from: &'a [f64],
    what: &'a mut [f64],
}

impl WithSimd for Subtract<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (what, from) in self.what.iter_mut().zip(self.from) {
            *what = from - *what;
        }
    }
}

/// `to = to + scale · what`.
struct AddScaled<'a> {
    what: &'a [f64],
    scale: f64,
    to: &'a mut [f64],
}

impl WithSimd for AddScaled<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (to, what) in self.to.iter_mut().zip(self.what) {
            *to = self.scale.mul_add(*what, *to);
        }
    }
}
