//! Noise for a batch of particles, in tiles.

use std::ops::Range;

use super::{LANES, load, particles_by_stream, with_scratch};
use crate::Stream;

/// Particles whose noise is drawn together: few enough for it to stay in the nearest cache.
const TOGETHER: usize = 256;

/// Draws noise of `width` coordinates for each of `particles` particles, which are split evenly over `streams` in order.
///
/// `work` gets it tile by tile: the numbers of up to [`LANES`] particles, and a tile (`width × LANES`) of their noise.
///
/// A stream of 256 particles or more fills whole tiles, with lanes that have no particle. A stream of fewer fills rows, since several
/// streams share a tile. Either way the noise of one stream's particles does not depend on the other streams.
///
/// # Panics
/// If `particles` is not a multiple of the number of streams.
pub fn with_noise(
    streams: &mut [Stream],
    width: usize,
    particles: usize,
    fill: impl Fn(&mut Stream, &mut [f64]),
    mut work: impl FnMut(Range<usize>, &mut [f64]),
) {
    assert!(particles.is_multiple_of(streams.len()), "{particles} particles for {} streams", streams.len());
    let each = particles / streams.len().max(1);
    if each == 0 {
        return;
    }
    let tile = width * LANES;
    if each >= TOGETHER {
        with_scratch(TOGETHER / LANES * tile, |noise| {
            for (number, stream) in streams.iter_mut().enumerate() {
                let end = (number + 1) * each;
                let mut first = number * each;
                while first < end {
                    let tiles = (end - first).min(TOGETHER).div_ceil(LANES);
                    let noise = &mut noise[..tiles * tile];
                    fill(stream, noise);
                    for noise in noise.chunks_exact_mut(tile) {
                        let next = (first + LANES).min(end);
                        work(first..next, noise);
                        first = next;
                    }
                }
            }
        });
        return;
    }
    let together = TOGETHER / each;
    with_scratch(together * each * width + tile, |scratch| {
        let (noise, rows) = scratch.split_at_mut(tile);
        let mut first = 0;
        for streams in streams.chunks_mut(together) {
            let particles = streams.len() * each;
            let rows = &mut rows[..particles * width];
            for (stream, rows) in particles_by_stream(streams, rows, width, particles) {
                fill(stream, rows);
            }
            for rows in rows.chunks(tile) {
                load(rows, width, noise);
                let next = first + rows.len() / width;
                work(first..next, noise);
                first = next;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Seed, fill_standard_normal};

    #[test]
    fn every_particle_gets_noise_that_the_others_do_not_change() {
        for (each, count) in [(1, 700), (10, 60), (50, 7), (255, 3), (256, 2), (300, 3), (1000, 1)] {
            let drawn = |streams: &mut [Stream]| {
                let mut rows = vec![f64::NAN; streams.len() * each * 3];
                let mut expected = 0;
                with_noise(streams, 3, streams.len() * each, fill_standard_normal, |particles, noise| {
                    assert_eq!(particles.start, expected);
                    expected = particles.end;
                    super::super::store(noise, 3, &mut rows[particles.start * 3..particles.end * 3]);
                });
                assert_eq!(expected, streams.len() * each);
                rows
            };
            let all = drawn(&mut Seed::from_u64(31).streams(count));
            let mut sorted = all.clone();
            sorted.sort_by(f64::total_cmp);
            assert!(sorted.windows(2).all(|pair| pair[0] < pair[1]));
            let last = drawn(&mut Seed::from_u64(31).streams(count)[count - 1..]);
            assert_eq!(all[(count - 1) * each * 3..], last);
        }
    }
}
