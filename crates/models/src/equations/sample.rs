//! Drawing states and measurements of many particles from what a model states.

use super::distribution::Distribution;
use super::draw::{Needs, Rejection, Source, Try, draw_all};
use super::lanes::Lanes;
use super::statement::{Coordinates, Draws};
use super::tiles::{rows_of, rows_of_mut};
use super::wrapped::Wrapped;
use crate::batch::{LANES, Rows, by_widest_vectors, store, with_scratch};
use crate::{Stream, fill_standard_exponential, fill_standard_normal, fill_uniform};

/// Most particles of one stream whose noise is drawn together.
const TOGETHER: usize = 256;
/// Numbers that are drawn together at most, where a tile does not take more: they stay in a cache that is near.
const NUMBERS: usize = 64 * TOGETHER;

/// How many particles are drawn together of which each takes so many numbers: whole tiles.
fn together(numbers: usize) -> usize {
    let particles = NUMBERS / numbers.max(1) / LANES * LANES;
    particles.clamp(LANES, TOGETHER)
}

/// Adds up what draws take.
pub(super) struct Counter(Needs);

impl Draws<f64> for Counter {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        self.push(distribution);
        // A value that later draws can depend on: how many there are must not.
        let [mean, _] = distribution.moments();
        mean
    }
}

impl Coordinates<f64> for Counter {
    fn push(&mut self, distribution: Distribution<f64>) {
        self.0 = self.0.plus(distribution.needs());
    }

    /// It is drawn from the stream itself.
    fn push_wrapped(&mut self, _: &Wrapped<'_, f64>) {}
}

/// What the draws of a state (`N`) take.
pub(super) fn needs_of_draws(n: usize, state: impl FnOnce(&mut Counter, &mut [f64])) -> Needs {
    let mut counter = Counter(Needs::default());
    with_scratch(n, |unused| state(&mut counter, unused));
    counter.0
}

/// What a draw of the measurement takes.
pub(super) fn needs_of_measurement(measurement: impl FnOnce(&mut Counter)) -> Needs {
    let mut counter = Counter(Needs::default());
    measurement(&mut counter);
    counter.0
}

/// Noise of up to [`LANES`] particles, drawn before and from their stream.
pub(super) struct TileNoise<'a, 'n> {
    stream: &'a mut Stream,
    particles: usize,
    normals: &'n [f64],
    exponentials: &'n [f64],
    uniforms: &'n [f64],
}

/// The next number of each particle, where they lie or else in `room`; lanes without one hold anything.
#[inline(always)]
fn next<'r, 'n: 'r>(
    numbers: &mut &'n [f64],
    particles: usize,
    room: &'r mut [f64; LANES],
) -> &'r [f64; LANES] {
    let (now, later) = numbers.split_at(particles.min(numbers.len()));
    *numbers = later;
    match now.as_array::<LANES>() {
        Some(now) => now,
        None => {
            room[..now.len()].copy_from_slice(now);
            room
        }
    }
}

/// The same, taken from there.
#[inline(always)]
fn take(numbers: &mut &[f64], particles: usize) -> Lanes {
    Lanes(*next(numbers, particles, &mut [0.0; LANES]))
}

impl TileNoise<'_, '_> {
    /// How many numbers that were drawn before are left.
    #[inline(always)]
    fn left(&self) -> usize {
        self.normals.len() + self.exponentials.len() + self.uniforms.len()
    }
}

impl Source<Lanes> for TileNoise<'_, '_> {
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

    #[inline(never)]
    fn by<M: Rejection>(&mut self, a: Lanes, b: Lanes) -> Lanes {
        let mut room = [[0.0; LANES]; 3];
        let [of_normal, of_first, of_second] = &mut room;
        let particles = self.particles;
        let normal: &[f64; LANES] = match M::NEEDS.normals {
            0 => of_normal,
            _ => next(&mut self.normals, particles, of_normal),
        };
        let first: &[f64; LANES] = match M::NEEDS.uniforms {
            0 => of_first,
            _ => next(&mut self.uniforms, particles, of_first),
        };
        let second: &[f64; LANES] = match M::NEEDS.uniforms {
            0 | 1 => of_second,
            _ => next(&mut self.uniforms, particles, of_second),
        };
        let random = Try { normal, uniforms: [first, second] };
        let mut drawn = Lanes([0.0; LANES]);
        draw_all::<M, LANES>(&a.0, &b.0, &random, particles, self.stream, &mut drawn.0);
        drawn
    }
}

impl Draws<Lanes> for TileNoise<'_, '_> {
    #[inline(always)]
    fn draw(&mut self, distribution: Distribution<Lanes>) -> Lanes {
        distribution.draw(self)
    }
}

/// Draws the entries of a measurement one after another into the rows of a tile.
pub(super) struct Entries<'e, 'a, 'n> {
    noise: &'e mut TileNoise<'a, 'n>,
    rows: &'e mut [Lanes],
    /// Whether more was stated than there is.
    is_ragged: bool,
}

impl Coordinates<Lanes> for Entries<'_, '_, '_> {
    #[inline(always)]
    fn push(&mut self, distribution: Distribution<Lanes>) {
        let drawn = distribution.draw(self.noise);
        self.put(drawn);
    }

    #[inline(never)]
    fn push_wrapped(&mut self, wrapped: &Wrapped<'_, Lanes>) {
        let mut lanes = [0.0; LANES];
        for (lane, drawn) in lanes[..self.noise.particles].iter_mut().enumerate() {
            *drawn = wrapped.sample(&|parameter: &Lanes| parameter.0[lane], self.noise.stream);
        }
        self.put(Lanes(lanes));
    }
}

impl Entries<'_, '_, '_> {
    #[inline(always)]
    fn put(&mut self, drawn: Lanes) {
        match std::mem::take(&mut self.rows) {
            [] => self.is_ragged = true,
            [row, rest @ ..] => {
                *row = drawn;
                self.rows = rest;
            }
        }
    }
}

/// Draws measurements into `out` (`K×M`), one for each row of `states` (`K×N`, with `N`) if there are any; all is NaN where another number of entries is stated than there is.
pub(super) fn draw_measurements(
    needs: Needs,
    m: usize,
    states: Option<(usize, Rows<'_>)>,
    streams: &mut [Stream],
    out: &mut [f64],
    measurement: impl Fn(usize, &[Lanes], &mut Entries<'_, '_, '_>),
) {
    let (n, states) = states.map_or((0, None), |(n, states)| (n, Some(states)));
    draw_tiles(
        needs,
        (m, n),
        states,
        streams,
        out,
        #[inline(always)]
        |first, state, noise, rows| {
            let mut entries = Entries { noise, rows, is_ragged: false };
            measurement(first, state, &mut entries);
            entries.rows.is_empty() && !entries.is_ragged
        },
    );
}

/// Draws states of `n` coordinates into `out` (`K×N`), one for each row of `previous` if there are any.
pub(super) fn draw_states(
    needs: Needs,
    (n, previous): (usize, Option<Rows<'_>>),
    streams: &mut [Stream],
    out: &mut [f64],
    state: impl Fn(usize, &[Lanes], &mut TileNoise<'_, '_>, &mut [Lanes]),
) {
    let before = if previous.is_some() { n } else { 0 };
    draw_tiles(
        needs,
        (n, before),
        previous,
        streams,
        out,
        #[inline(always)]
        |first, previous, noise, rows| {
            state(first, previous, noise, rows);
            true
        },
    );
}

/// Draws `width` numbers for each of `K` particles into `out`; the particles are split evenly over `streams`, in order.
///
/// `draw` is given the number of a tile's first particle, the tile of what it depends on (rows of `previous_width` numbers), the noise, and the tile to be written.
/// What it draws is NaN where it says that it is not whole, or where it took other numbers than `needs` says.
///
/// # Panics
/// If `particles` is not a multiple of the number of streams.
fn draw_tiles(
    needs: Needs,
    (width, previous_width): (usize, usize),
    previous: Option<Rows<'_>>,
    streams: &mut [Stream],
    out: &mut [f64],
    draw: impl Fn(usize, &[Lanes], &mut TileNoise<'_, '_>, &mut [Lanes]) -> bool,
) {
    let particles = out.len() / width.max(1);
    let each = particles / streams.len().max(1);
    assert_eq!(each * streams.len(), particles, "{particles} particles for {} streams", streams.len());
    let together = together(needs.count());
    with_scratch((previous_width + width) * LANES, |tiles| {
        let (before, drawn) = tiles.split_at_mut(previous_width * LANES);
        // Lanes without a particle are computed, too: with numbers that are no danger.
        before.fill(0.0);
        with_scratch(needs.count() * together.min(each), |numbers| {
            for (number, stream) in streams.iter_mut().enumerate() {
                let end = (number + 1) * each;
                let mut first = number * each;
                while first < end {
                    let chunk = (end - first).min(together);
                    let (normals, rest) = numbers.split_at_mut(needs.normals * chunk);
                    let (exponentials, rest) = rest.split_at_mut(needs.exponentials * chunk);
                    let uniforms = &mut rest[..needs.uniforms * chunk];
                    fill(stream, normals, fill_standard_normal);
                    fill(stream, exponentials, fill_standard_exponential);
                    fill(stream, uniforms, fill_uniform);
                    let (normals, exponentials, uniforms) = (&*normals, &*exponentials, &*uniforms);
                    let mut noise = TileNoise { stream, particles: 0, normals, exponentials, uniforms };
                    let last = first + chunk;
                    // As for densities: by the widest vectors of the machine, and the same numbers by any.
                    by_widest_vectors(
                        #[inline(always)]
                        || {
                            while first < last {
                                noise.particles = (last - first).min(LANES);
                                if let Some(previous) = previous {
                                    previous.load(first, before);
                                }
                                let is_whole = draw(first, rows_of(before), &mut noise, rows_of_mut(drawn));
                                let next = first + noise.particles;
                                if !is_whole || noise.left() != needs.count() * (last - next) {
                                    drawn.fill(f64::NAN);
                                }
                                store(drawn, width, &mut out[first * width..next * width]);
                                first = next;
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
