//! Drawing vectors of many particles from the distributions that a model states.

use super::distribution::Distribution;
use super::draw::{Needs, Source};
use super::lanes::Lanes;
use super::statement::Coordinates;
use super::tiles::{rows_of, rows_of_mut};
use crate::batch::{LANES, Rows, by_widest_vectors, store, with_scratch};
use crate::{Stream, fill_standard_exponential, fill_standard_normal, fill_uniform};

/// Particles of one stream whose noise is drawn together: few enough for it to stay in the nearest cache.
const TOGETHER: usize = 256;

/// Adds up what the draws of a vector take.
pub(super) struct Counter(Needs);

impl Coordinates<f64> for Counter {
    fn push(&mut self, distribution: Distribution<f64>) {
        self.0 = self.0.plus(distribution.needs());
    }
}

/// What a draw of the vector takes that `state` states.
pub(super) fn needs_of(state: impl FnOnce(&mut Counter)) -> Needs {
    let mut counter = Counter(Needs::default());
    state(&mut counter);
    counter.0
}

/// Draws each of up to [`LANES`] particles, coordinate by coordinate, into a tile.
pub(super) struct Drawn<'a, 'n> {
    stream: &'a mut Stream,
    particles: usize,
    normals: &'n [f64],
    exponentials: &'n [f64],
    uniforms: &'n [f64],
    /// The rows that are still to be drawn.
    rows: &'a mut [Lanes],
    /// Whether more was stated than there is.
    is_ragged: bool,
}

/// The next number of each particle; lanes without one hold anything.
#[inline(always)]
fn take(numbers: &mut &[f64], particles: usize) -> Lanes {
    let (now, later) = numbers.split_at(particles.min(numbers.len()));
    *numbers = later;
    let mut lanes = [0.0; LANES];
    match now.as_array::<LANES>() {
        Some(now) => lanes = *now,
        None => lanes[..now.len()].copy_from_slice(now),
    }
    Lanes(lanes)
}

impl Source<Lanes> for Drawn<'_, '_> {
    #[inline(always)]
    fn normal(&mut self) -> Lanes {
        take(&mut self.normals, self.particles)
    }

    #[inline(always)]
    fn exponential(&mut self) -> Lanes {
        take(&mut self.exponentials, self.particles)
    }

    #[inline(always)]
    fn uniform(&mut self) -> Lanes {
        take(&mut self.uniforms, self.particles)
    }

    fn by(&mut self, a: Lanes, b: Lanes, draw: fn(f64, f64, &mut Stream) -> f64) -> Lanes {
        let mut lanes = [0.0; LANES];
        for (lane, drawn) in lanes[..self.particles].iter_mut().enumerate() {
            *drawn = draw(a.0[lane], b.0[lane], self.stream);
        }
        Lanes(lanes)
    }
}

impl Coordinates<Lanes> for Drawn<'_, '_> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<Lanes>) {
        let drawn = distribution.draw(self);
        match std::mem::take(&mut self.rows) {
            [] => self.is_ragged = true,
            [row, rest @ ..] => {
                *row = drawn;
                self.rows = rest;
            }
        }
    }
}

/// Draws `width` coordinates for each of `particles` particles into `out` (`K×width`); the particles are split evenly over `streams`, in order.
///
/// Their distributions are what `state` pushes, given the number of a tile's first particle and what they depend on: rows of `previous_width` numbers, none
/// at `t = 0`.
///
/// # Panics
/// If `particles` is not a multiple of the number of streams.
pub(super) fn draw_rows(
    needs: Needs,
    width: usize,
    previous: Option<Rows<'_>>,
    previous_width: usize,
    streams: &mut [Stream],
    out: &mut [f64],
    state: impl Fn(usize, &[Lanes], &mut Drawn<'_, '_>),
) {
    let particles = out.len() / width.max(1);
    let each = particles / streams.len().max(1);
    assert_eq!(each * streams.len(), particles, "{particles} particles for {} streams", streams.len());
    let together = each.min(TOGETHER);
    with_scratch((previous_width + width) * LANES, |tiles| {
        let (before, drawn) = tiles.split_at_mut(previous_width * LANES);
        // Lanes without a particle are computed, too: with numbers that are no danger.
        before.fill(0.0);
        with_scratch(needs.count() * together, |noise| {
            for (number, stream) in streams.iter_mut().enumerate() {
                let end = (number + 1) * each;
                let mut first = number * each;
                while first < end {
                    let chunk = (end - first).min(TOGETHER);
                    let (normals, rest) = noise.split_at_mut(needs.normals * chunk);
                    let (exponentials, rest) = rest.split_at_mut(needs.exponentials * chunk);
                    let uniforms = &mut rest[..needs.uniforms * chunk];
                    fill(stream, normals, fill_standard_normal);
                    fill(stream, exponentials, fill_standard_exponential);
                    fill(stream, uniforms, fill_uniform);
                    let (mut normals, mut exponentials, mut uniforms) =
                        (&*normals, &*exponentials, &*uniforms);
                    let last = first + chunk;
                    // As for densities: by the widest vectors of the machine, and the same numbers by any.
                    by_widest_vectors(
                        #[inline(always)]
                        || {
                            while first < last {
                                let particles = (last - first).min(LANES);
                                if let Some(previous) = previous {
                                    previous.load(first, before);
                                }
                                let mut sink = Drawn {
                                    stream,
                                    particles,
                                    normals,
                                    exponentials,
                                    uniforms,
                                    rows: rows_of_mut(drawn),
                                    is_ragged: false,
                                };
                                state(first, rows_of(before), &mut sink);
                                let is_whole = sink.rows.is_empty() && !sink.is_ragged;
                                (normals, exponentials, uniforms) =
                                    (sink.normals, sink.exponentials, sink.uniforms);
                                if !is_whole {
                                    drawn.fill(f64::NAN);
                                }
                                store(drawn, width, &mut out[first * width..(first + particles) * width]);
                                first += particles;
                            }
                        },
                    );
                }
            }
        });
    });
}

/// Fills what is there to be filled: asking for no numbers would still take some of the stream.
fn fill(stream: &mut Stream, numbers: &mut [f64], fill: impl Fn(&mut Stream, &mut [f64])) {
    if !numbers.is_empty() {
        fill(stream, numbers);
    }
}
