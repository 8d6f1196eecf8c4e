//! Tiles of rows whose sums of products stay in registers, and panels of sums.

use faer::{Accum, MatMut};
use pulp::Simd;

use super::matrix::{Columns, Factor, row};
use super::vectors::{load_two, store_two};

/// The widest panel: two of the longest vectors.
pub(super) const WIDEST: usize = 32;

/// The rows of the tallest tile: as many as have two sums each in the registers that a processor has at most.
pub(super) const TALLEST: usize = 14;

/// The rows of a tile: as even as can be, and so few that their sums fit into registers.
#[derive(Clone, Copy)]
pub(super) struct Tiles {
    rows: usize,
    count: usize,
}

impl Tiles {
    #[inline(always)]
    pub(super) fn of<S: Simd>(rows: usize) -> Self {
        // Two vectors of sums a row; two of weights and one of the other factor beside them.
        Tiles { rows, count: rows.div_ceil((S::REGISTER_COUNT - 4) / 2) }
    }

    #[inline(always)]
    pub(super) fn rows(self) -> usize {
        self.rows
    }

    #[inline(always)]
    pub(super) fn count(self) -> usize {
        self.count
    }

    /// Where each tile begins, and how many rows it has.
    #[inline(always)]
    pub(super) fn each(self) -> impl Iterator<Item = (usize, usize)> {
        let Tiles { rows, count } = self;
        (0..count).map(move |tile| {
            let start = |tile: usize| tile * rows / count;
            (start(tile), start(tile + 1) - start(tile))
        })
    }

    /// Brings rows of `inner` numbers into tiles, each with its columns one after another.
    #[inline(always)]
    pub(super) fn fill(self, a: Factor<'_>, inner: usize, in_tiles: &mut [f32]) {
        let Factor { lies: Columns { values, stride }, transposed } = a;
        for (start, rows) in self.each() {
            let tile = &mut in_tiles[start * inner..(start + rows) * inner];
            if transposed {
                for (column, from) in tile.chunks_exact_mut(rows).zip(values.chunks(stride)) {
                    column.copy_from_slice(&from[start..start + rows]);
                }
                continue;
            }
            for row in 0..rows {
                let from = &values[(start + row) * stride..][..inner];
                for (column, value) in tile.chunks_exact_mut(rows).zip(from) {
                    column[row] = *value;
                }
            }
        }
    }
}

/// Writes or adds sums in panels, each with its rows one after another.
#[inline(always)]
pub(super) fn write<S: Simd>(simd: S, mut out: MatMut<'_, f32>, accum: Accum, sums: &[f32]) {
    let (width, rows) = (2 * S::F32_LANES, out.nrows());
    for at in 0..rows {
        for (number, into) in row(&mut out, at).chunks_mut(width).enumerate() {
            let mut found = load_two::<S>(simd, &sums[(number * rows + at) * width..][..width]);
            if accum == Accum::Add {
                let before = load_two::<S>(simd, into);
                found = [simd.add_f32s(found[0], before[0]), simd.add_f32s(found[1], before[1])];
            }
            store_two::<S>(simd, into, found);
        }
    }
}

/// `sums (+)= a b` for a tile of `rows` rows: `a` column by column, `b` in a panel, in registers all along.
#[inline(always)]
pub(super) fn tile<S: Simd>(simd: S, rows: usize, add: bool, sums: &mut [f32], a: &[f32], b: &[f32]) {
    macro_rules! of_rows {
        ($($rows:literal)*) => {
            match rows {
                $($rows => sized::<S, $rows>(simd, add, sums, a, b),)*
                _ => unreachable!("a tile has as many rows as fit into registers"),
            }
        };
    }
    of_rows!(1 2 3 4 5 6 7 8 9 10 11 12 13 14)
}

#[inline(always)]
fn sized<S: Simd, const R: usize>(simd: S, add: bool, out: &mut [f32], a: &[f32], b: &[f32]) {
    let (out, _) = S::as_mut_simd_f32s(out);
    let (out, _) = out.as_chunks_mut::<2>();
    // An array, because a loop over a slice, whose length the compiler does not know, would keep the sums in memory.
    let Some(out) = out.first_chunk_mut::<R>() else { return };
    let mut sums = if add { *out } else { [[simd.splat_f32s(0.0); 2]; R] };
    let (a, _) = a.as_chunks::<R>();
    let (b, _) = S::as_simd_f32s(b);
    let (b, _) = b.as_chunks::<2>();
    add_products::<S, R>(simd, &mut sums, a, b);
    *out = sums;
}

/// `sums += a b`: rows of the one in columns, two vectors of columns of the other in rows.
#[inline(always)]
pub(super) fn add_products<S: Simd, const R: usize>(
    simd: S,
    sums: &mut [[S::f32s; 2]; R],
    a: &[[f32; R]],
    b: &[[S::f32s; 2]],
) {
    for (a, b) in a.iter().zip(b) {
        for (a, sums) in a.iter().zip(&mut *sums) {
            let a = simd.splat_f32s(*a);
            sums[0] = simd.mul_add_e_f32s(a, b[0], sums[0]);
            sums[1] = simd.mul_add_e_f32s(a, b[1], sums[1]);
        }
    }
}
