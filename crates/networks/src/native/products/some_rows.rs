//! Products of some dozens of rows with a large matrix, which is read along its rows, a few rows at a time.
//!
//! A batch of particles is too large to be held in registers and too small to pay for a copy of the whole matrix of weights. Here a panel of
//! that matrix, narrow and short, is copied into the nearest cache and multiplied by all rows. Sums are kept panel by panel: the
//! rows of a wide result lie so far apart that they would push each other out of that cache.

use prefetch_index::prefetch_index;
use pulp::{Arch, Simd, WithSimd};

use super::matrix::{Columns, Factor, Task};
use super::tiles::{Tiles, WIDEST, tile, write};
use super::vectors::{load_two, store_two};
use crate::native::buffers::Buffers;

/// Terms of the sums at a time: as many rows of weights as a processor reads ahead in.
const TERMS: usize = 64;

/// `a b`, of factors as they lie.
pub(super) fn times(task: Task<'_>, buffers: &mut Buffers<f32>) {
    debug_assert!(!task.a.transposed && !task.b.transposed);
    let [rows, inner, columns] = task.sizes();
    let mut panel = buffers.take(TERMS * WIDEST);
    let mut in_tiles = buffers.take(rows * inner);
    let mut sums = buffers.take(rows * columns.next_multiple_of(WIDEST));
    Arch::new().dispatch(Times { task, panel: &mut panel, in_tiles: &mut in_tiles, sums: &mut sums });
    for buffer in [panel, in_tiles, sums] {
        buffers.put(buffer);
    }
}

struct Times<'a> {
    task: Task<'a>,
    /// Some rows and two vectors of columns of `b`.
    panel: &'a mut [f32],
    /// `a` in tiles of rows, each with its columns one after another.
    in_tiles: &'a mut [f32],
    /// `a b` in panels of two vectors of columns, each with its rows one after another.
    sums: &'a mut [f32],
}

impl WithSimd for Times<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Times { task, panel, in_tiles, sums } = self;
        let [rows, inner, columns] = task.sizes();
        let Task { out, accum, a, b: Factor { lies: b, .. }, .. } = task;
        let width = 2 * S::F32_LANES;
        let tiles = Tiles::of::<S>(rows);
        tiles.fill(a, inner, in_tiles);
        if inner == 0 {
            // A sum of no terms is still a result.
            sums.fill(0.0);
        }
        let mut first = 0;
        while first < inner {
            let terms = TERMS.min(inner - first);
            for (part, sums) in sums.chunks_exact_mut(rows * width).take(columns.div_ceil(width)).enumerate()
            {
                let column = part * width;
                let some = width.min(columns - column);
                for (k, into) in panel.chunks_exact_mut(width).take(terms).enumerate() {
                    let at = (first + k) * b.stride + column;
                    store_two::<S>(simd, into, load_two::<S>(simd, &b.values[at..at + some]));
                }
                let next =
                    if column + width < columns { [first, column + width] } else { [first + terms, 0] };
                for (number, (start, count)) in tiles.each().enumerate() {
                    ask_for(b, next, [inner, width], [number, tiles.count()]);
                    let from = start * inner;
                    let a = &in_tiles[from + first * count..from + (first + terms) * count];
                    let sums = &mut sums[start * width..(start + count) * width];
                    tile::<S>(simd, count, first > 0, sums, a, &panel[..terms * width]);
                }
            }
            first += terms;
        }
        write::<S>(simd, out, accum, sums);
    }
}

/// Asks memory for a part of the panel that begins at a row and a column: its rows lie so far apart that no processor reads ahead in them.
#[inline(always)]
fn ask_for(
    Columns { values, stride }: Columns<'_, f32>,
    [first, column]: [usize; 2],
    [inner, width]: [usize; 2],
    [part, parts]: [usize; 2],
) {
    let terms = TERMS.min(inner.saturating_sub(first));
    for term in part * terms / parts..(part + 1) * terms / parts {
        let at = (first + term) * stride + column;
        // It may begin anywhere in a line of cache.
        [0, width / 2, width - 1].into_iter().for_each(|number| prefetch_index(values, at + number));
    }
}
