//! Rows of a batch copied into tiles and back, eight rows and eight coordinates at a time.

use super::transpose::{BLOCK, Block, MoveBlocks, with_transpose};
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
        with_transpose(Load { rows: *self, first, tile });
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
    with_transpose(Store { tile, width, states });
}

struct Load<'a> {
    rows: Rows<'a>,
    first: usize,
    tile: &'a mut [f64],
}

impl MoveBlocks for Load<'_> {
    #[inline(always)]
    fn run(self, transposed: impl Fn(Block) -> Block) {
        let Load { rows, first, tile } = self;
        let particles = rows.len().saturating_sub(first).min(LANES);
        let (tile, _) = tile.as_chunks_mut::<LANES>();
        let blocks = rows.width / BLOCK * BLOCK;
        let mut lane = 0;
        while lane + BLOCK <= particles {
            let mut states = [&[][..]; BLOCK];
            for (k, state) in states.iter_mut().enumerate() {
                *state = rows.row(first + lane + k);
            }
            for (at, tile) in tile[..blocks].as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
                let mut block = [[0.0; BLOCK]; BLOCK];
                for (row, state) in block.iter_mut().zip(states) {
                    row.copy_from_slice(&state[at * BLOCK..][..BLOCK]);
                }
                for (tile, row) in tile.iter_mut().zip(transposed(block)) {
                    tile[lane..lane + BLOCK].copy_from_slice(&row);
                }
            }
            for (i, tile) in tile[..rows.width].iter_mut().enumerate().skip(blocks) {
                for (value, state) in tile[lane..lane + BLOCK].iter_mut().zip(states) {
                    *value = state[i];
                }
            }
            lane += BLOCK;
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

impl MoveBlocks for Store<'_> {
    #[inline(always)]
    fn run(self, transposed: impl Fn(Block) -> Block) {
        let Store { tile, width, states } = self;
        let (tile, _) = tile.as_chunks::<LANES>();
        let blocks = width / BLOCK * BLOCK;
        let states = &mut states[..];
        let mut groups = states.chunks_exact_mut(BLOCK * width);
        let mut lane = 0;
        for states in groups.by_ref().take(LANES / BLOCK) {
            for (at, tile) in tile[..blocks].as_chunks::<BLOCK>().0.iter().enumerate() {
                let mut block = [[0.0; BLOCK]; BLOCK];
                for (row, tile) in block.iter_mut().zip(tile) {
                    row.copy_from_slice(&tile[lane..lane + BLOCK]);
                }
                for (state, row) in states.chunks_exact_mut(width).zip(transposed(block)) {
                    state[at * BLOCK..][..BLOCK].copy_from_slice(&row);
                }
            }
            for (i, tile) in tile[..width].iter().enumerate().skip(blocks) {
                for (state, value) in states.chunks_exact_mut(width).zip(&tile[lane..lane + BLOCK]) {
                    state[i] = *value;
                }
            }
            lane += BLOCK;
        }
        for (lane, state) in (lane..LANES).zip(groups.into_remainder().chunks_exact_mut(width)) {
            for (value, tile) in state.iter_mut().zip(tile) {
                *value = tile[lane];
            }
        }
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
