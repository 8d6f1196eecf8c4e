//! States that are drawn by their noise, which is kept beside them.

use crate::batch::{LANES, Rows, load, store, with_scratch};
use crate::equations::NoiseSpace;
use crate::{Step, Stream, fill_standard_normal};

/// Draws `v_t` for each of `K` particles into `noise` (`K×Q`), and the states that it makes into `states` (`K×N`).
pub(crate) fn sample_with_noise(
    model: &dyn NoiseSpace,
    n: usize,
    step: &Step<'_>,
    previous: Option<Rows<'_>>,
    stream: &mut Stream,
    noise: &mut [f64],
    states: &mut [f64],
) {
    let particles = states.len() / n;
    let q = noise.len() / particles.max(1);
    fill_standard_normal(stream, noise);
    with_scratch((q + 2 * n) * LANES, |tiles| {
        // Lanes without a particle are computed, too: with numbers that are no danger.
        tiles.fill(0.0);
        let (v, rest) = tiles.split_at_mut(q * LANES);
        let (before, now) = rest.split_at_mut(n * LANES);
        for first in (0..particles).step_by(LANES) {
            let last = (first + LANES).min(particles);
            if q > 0 {
                load(&noise[first * q..last * q], q, v);
            }
            let before = previous.map(|rows| {
                rows.load(first, before);
                &*before
            });
            model.tile_states(step, before, v, now);
            store(now, n, &mut states[first * n..last * n]);
        }
    });
}
