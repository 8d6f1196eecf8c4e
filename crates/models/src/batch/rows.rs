//! Rows of a batch turned into tiles and back, eight rows and eight coordinates at a time.

use super::{LANES, with_scratch};

/// The states of a batch of particles: rows one after another, or rows of another batch that were picked by number, as resampling does.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    states: &'a [f64],
    width: usize,
    picked: Option<&'a [usize]>,
}

impl<'a> Rows<'a> {
    /// All rows of `states`, which has `width` coordinates in each.
    pub fn all(states: &'a [f64], width: usize) -> Self {
        Rows { states, width, picked: None }
    }

    /// Row `picked[k]` of `states` for each particle `k`.
    pub fn picked(states: &'a [f64], width: usize, picked: &'a [usize]) -> Self {
        Rows { states, width, picked: Some(picked) }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.picked.map_or(self.states.len() / self.width.max(1), <[usize]>::len)
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The state of particle `k`.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    pub fn row(&self, k: usize) -> &'a [f64] {
        let row = self.picked.map_or(k, |picked| picked[k]);
        &self.states[row * self.width..][..self.width]
    }

    /// Copies up to [`LANES`] states, from particle `first` on, into a tile (`width × LANES`); lanes without a state are left as they were.
    pub fn load(&self, first: usize, tile: &mut [f64]) {
        turn(Load { rows: *self, first, tile });
    }

    /// Lends all states one after another, in scratch if they are picked.
    pub fn with_contiguous<R>(&self, work: impl FnOnce(&[f64]) -> R) -> R {
        match self.picked {
            None => work(self.states),
            Some(picked) => with_scratch(picked.len() * self.width, |rows| {
                self.copy_to(rows);
                work(rows)
            }),
        }
    }

    /// Copies the first states into `states`, as many as there is room for.
    ///
    /// # Panics
    /// If there is room for more than there are.
    pub fn copy_to(&self, states: &mut [f64]) {
        for (k, state) in states.chunks_exact_mut(self.width).enumerate() {
            state.copy_from_slice(self.row(k));
        }
    }
}

/// Copies up to [`LANES`] states of `width` coordinates (row-major `states`) into a tile (`width × LANES`); lanes without a
/// state are left as they were.
#[inline]
pub fn load(states: &[f64], width: usize, tile: &mut [f64]) {
    Rows::all(states, width).load(0, tile);
}

/// Copies a tile (`width × LANES`) into up to [`LANES`] states.
#[inline]
pub fn store(tile: &[f64], width: usize, states: &mut [f64]) {
    turn(Store { tile, width, states });
}

/// Rows and coordinates that are turned over together.
const SIDE: usize = 8;

/// A square of a batch, turned over or to be.
type Square = [[f64; SIDE]; SIDE];

/// A movement between rows and a tile, by squares and what is left beside them.
trait Turn {
    fn by(self, transposed: impl Fn(Square) -> Square);
}

/// Moves, with vector instructions if the machine has those of AVX-512.
fn turn(work: impl Turn) {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V4::try_new() {
        return pulp::Simd::vectorize(simd, wide::Wide { simd, work });
    }
    work.by(
        #[inline(always)]
        |square| transposed(&square),
    );
}

#[inline(always)]
fn transposed(square: &Square) -> Square {
    let mut turned = [[0.0; SIDE]; SIDE];
    for (i, row) in square.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            turned[j][i] = *value;
        }
    }
    turned
}

struct Load<'a> {
    rows: Rows<'a>,
    first: usize,
    tile: &'a mut [f64],
}

impl Turn for Load<'_> {
    #[inline(always)]
    fn by(self, transposed: impl Fn(Square) -> Square) {
        let Load { rows, first, tile } = self;
        let particles = rows.len().saturating_sub(first).min(LANES);
        let (tile, _) = tile.as_chunks_mut::<LANES>();
        let squares = rows.width / SIDE * SIDE;
        let mut lane = 0;
        while lane + SIDE <= particles {
            let mut states = [&[][..]; SIDE];
            for (k, state) in states.iter_mut().enumerate() {
                *state = rows.row(first + lane + k);
            }
            for (at, tile) in tile[..squares].as_chunks_mut::<SIDE>().0.iter_mut().enumerate() {
                let mut square = [[0.0; SIDE]; SIDE];
                for (row, state) in square.iter_mut().zip(states) {
                    row.copy_from_slice(&state[at * SIDE..][..SIDE]);
                }
                for (tile, row) in tile.iter_mut().zip(transposed(square)) {
                    tile[lane..lane + SIDE].copy_from_slice(&row);
                }
            }
            for (i, tile) in tile[..rows.width].iter_mut().enumerate().skip(squares) {
                for (value, state) in tile[lane..lane + SIDE].iter_mut().zip(states) {
                    *value = state[i];
                }
            }
            lane += SIDE;
        }
        for lane in lane..particles {
            for (tile, value) in tile.iter_mut().zip(rows.row(first + lane)) {
                tile[lane] = *value;
            }
        }
    }
}

struct Store<'a> {
    tile: &'a [f64],
    width: usize,
    states: &'a mut [f64],
}

impl Turn for Store<'_> {
    #[inline(always)]
    fn by(self, transposed: impl Fn(Square) -> Square) {
        let Store { tile, width, states } = self;
        let (tile, _) = tile.as_chunks::<LANES>();
        let squares = width / SIDE * SIDE;
        let states = &mut states[..];
        let mut groups = states.chunks_exact_mut(SIDE * width);
        let mut lane = 0;
        for states in groups.by_ref().take(LANES / SIDE) {
            for (at, tile) in tile[..squares].as_chunks::<SIDE>().0.iter().enumerate() {
                let mut square = [[0.0; SIDE]; SIDE];
                for (row, tile) in square.iter_mut().zip(tile) {
                    row.copy_from_slice(&tile[lane..lane + SIDE]);
                }
                for (state, row) in states.chunks_exact_mut(width).zip(transposed(square)) {
                    state[at * SIDE..][..SIDE].copy_from_slice(&row);
                }
            }
            for (i, tile) in tile[..width].iter().enumerate().skip(squares) {
                for (state, value) in states.chunks_exact_mut(width).zip(&tile[lane..lane + SIDE]) {
                    state[i] = *value;
                }
            }
            lane += SIDE;
        }
        for (lane, state) in (lane..LANES).zip(groups.into_remainder().chunks_exact_mut(width)) {
            for (value, tile) in state.iter_mut().zip(tile) {
                *value = tile[lane];
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod wide {
    use std::arch::x86_64::__m512d;

    use pulp::x86::V4;
    use pulp::{Simd, WithSimd, cast};

    use super::{Square, Turn};

    pub(super) struct Wide<T> {
        pub(super) simd: V4,
        pub(super) work: T,
    }

    impl<T: Turn> WithSimd for Wide<T> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, _simd: S) {
            let Wide { simd, work } = self;
            work.by(
                #[inline(always)]
                |square| transposed(simd, square),
            );
        }
    }

    /// Turns pairs of rows over within pairs of coordinates, then pairs of pairs, then halves.
    #[inline(always)]
    fn transposed(simd: V4, square: Square) -> Square {
        let avx = simd.avx512f;
        let [a, b, c, d, e, f, g, h]: [__m512d; 8] = cast(square);
        let even = [(a, b), (c, d), (e, f), (g, h)].map(
            #[inline(always)]
            |(a, b)| avx._mm512_unpacklo_pd(a, b),
        );
        let odd = [(a, b), (c, d), (e, f), (g, h)].map(
            #[inline(always)]
            |(a, b)| avx._mm512_unpackhi_pd(a, b),
        );
        let ([a, c, e, g], [b, d, f, h]) = (quarters(simd, even), quarters(simd, odd));
        cast([a, b, c, d, e, f, g, h])
    }

    /// Quarter `j` of each of four registers side by side, for each `j`.
    #[inline(always)]
    fn quarters(simd: V4, [a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
        const EVEN: i32 = 0b10_00_10_00;
        const ODD: i32 = 0b11_01_11_01;
        let avx = simd.avx512f;
        let even = (avx._mm512_shuffle_f64x2::<EVEN>(a, b), avx._mm512_shuffle_f64x2::<EVEN>(c, d));
        let odd = (avx._mm512_shuffle_f64x2::<ODD>(a, b), avx._mm512_shuffle_f64x2::<ODD>(c, d));
        [
            avx._mm512_shuffle_f64x2::<EVEN>(even.0, even.1),
            avx._mm512_shuffle_f64x2::<EVEN>(odd.0, odd.1),
            avx._mm512_shuffle_f64x2::<ODD>(even.0, even.1),
            avx._mm512_shuffle_f64x2::<ODD>(odd.0, odd.1),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_loaded_are_the_picked_rows_and_storing_brings_them_back() {
        for width in [1, 2, 7, 8, 10, 16, 19] {
            let states: Vec<f64> = (0..100 * width).map(|i| i as f64).collect();
            let picked: Vec<usize> = (0..70).map(|k| (37 * k) % 100).collect();
            for rows in [Rows::all(&states, width), Rows::picked(&states, width, &picked)] {
                for first in [0, 3, 32, rows.len() - 32, rows.len() - 31, rows.len() - 8, rows.len() - 1] {
                    let mut tile = vec![f64::NAN; width * LANES];
                    rows.load(first, &mut tile);
                    let particles = (rows.len() - first).min(LANES);
                    for (lane, i) in (0..LANES).flat_map(|lane| (0..width).map(move |i| (lane, i))) {
                        let found = tile[i * LANES + lane];
                        if lane < particles {
                            assert_eq!(found, rows.row(first + lane)[i]);
                        } else {
                            assert!(found.is_nan());
                        }
                    }
                    let mut stored = vec![f64::NAN; particles * width];
                    store(&tile, width, &mut stored);
                    for (k, row) in stored.chunks_exact(width).enumerate() {
                        assert_eq!(row, rows.row(first + k));
                    }
                }
            }
            Rows::picked(&states, width, &picked).with_contiguous(|rows| {
                let same = rows.chunks_exact(width).zip(&picked);
                same.for_each(|(row, &k)| assert_eq!(row, &states[k * width..][..width]));
            });
        }
    }
}
