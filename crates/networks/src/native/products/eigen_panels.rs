//! Products of some rows with a matrix for each eigenvalue, which is never written to memory.
//!
//! A block of the taps at a time is brought into a panel, which stays in the nearest cache while all eigenvalues take their turn at it:
//! of each term of the sums two vectors of columns of every tap. For a few rows, each entry of `W(λ)` is formed in registers and used at
//! once; for more rows, the block of `W(λ)` is formed first and used by one tile after another.

use pulp::{Arch, Simd, WithSimd};

use super::eigen_products::EigenProducts;
use super::matrix::{Columns, Factor};
use super::tap_blocks::{Ahead, Block, Taps};
use super::tiles::{Tiles, WIDEST, add_products, tile};
use super::vectors::{load_two, store_two};
use crate::native::buffers::Buffers;

/// Terms of the sums at a time: four taps of them are 16 KB with the longest vectors.
const TERMS: usize = 32;

/// As many taps as filters mostly have: shifts up to the third power.
const USUAL: usize = 4;

/// `a_i W(λ_i)`, or `a_i W(λ_i)ᵀ`, for each eigenvalue.
pub(super) fn times(products: EigenProducts<'_, f32>, buffers: &mut Buffers<f32>) {
    times_by(products, buffers, |work| Arch::new().dispatch(work));
}

#[cfg(test)]
pub(super) fn times_without_vectors(products: EigenProducts<'_, f32>, buffers: &mut Buffers<f32>) {
    times_by(products, buffers, |work| pulp::Scalar::new().vectorize(work));
}

fn times_by(
    products: EigenProducts<'_, f32>,
    buffers: &mut Buffers<f32>,
    dispatch: impl FnOnce(InPanels<'_>),
) {
    let [rows, _, columns] = products.sizes();
    let mut panel = buffers.take(products.shape.taps * TERMS * WIDEST);
    let mut formed = buffers.take(TERMS * WIDEST);
    let mut in_tiles = buffers.take(products.a.len());
    let mut sums = buffers.take(rows * products.eigenvalues.len() * columns.next_multiple_of(WIDEST));
    dispatch(InPanels {
        products,
        panel: &mut panel,
        formed: &mut formed,
        in_tiles: &mut in_tiles,
        sums: &mut sums,
    });
    for buffer in [panel, formed, in_tiles, sums] {
        buffers.put(buffer);
    }
}

struct InPanels<'a> {
    products: EigenProducts<'a, f32>,
    /// A block of all taps.
    panel: &'a mut [f32],
    /// The same block of one `W(λ_i)`.
    formed: &'a mut [f32],
    /// Each `a_i` in tiles of rows, each with its columns one after another.
    in_tiles: &'a mut [f32],
    /// All sums: for two vectors of columns at a time, the rows of one eigenvalue after those of another.
    sums: &'a mut [f32],
}

impl WithSimd for InPanels<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let InPanels { products, panel, formed, in_tiles, sums } = self;
        let [rows, inner, columns] = products.sizes();
        let EigenProducts { taps, shape, transposed, eigenvalues, a, out } = products;
        let (width, tiles) = (2 * S::F32_LANES, Tiles::of::<S>(rows));
        for (a, in_tiles) in a.chunks_exact(rows * inner).zip(in_tiles.chunks_exact_mut(rows * inner)) {
            let lies = Columns { values: a, stride: inner };
            tiles.fill(Factor { lies, transposed: false }, inner, in_tiles);
        }
        let taps = Taps { values: taps, shape };
        let of_columns = rows * eigenvalues.len() * width;
        let mut factor = ByEigenvalue { eigenvalues, taps: shape.taps, inner, tiles, in_tiles, formed };
        // As the taps lie in memory: their rows are terms of the sums, or columns of the transpose.
        let [tall, wide] = if transposed { [width, TERMS] } else { [TERMS, width] };
        let mut blocks = Block::all(shape, [tall, wide]).peekable();
        while let Some(block) = blocks.next() {
            let Block { row, column, .. } = block;
            let ([first, column], terms) =
                if transposed { ([column, row], block.columns) } else { ([row, column], block.rows) };
            let panel = &mut panel[..terms * shape.taps * width];
            if transposed {
                taps.turned(block, width, panel);
            } else {
                taps.copied::<S>(simd, block, panel);
            }
            let sums = &mut sums[column / width * of_columns..][..of_columns];
            let next = (taps, blocks.peek().copied().unwrap_or(block));
            factor.add::<S>(simd, first, panel, sums, next);
        }
        for (number, sums) in sums.chunks_exact(of_columns).take(columns.div_ceil(width)).enumerate() {
            let some = number * width..columns.min((number + 1) * width);
            for (row, sums) in out.chunks_exact_mut(columns).zip(sums.chunks_exact(width)) {
                store_two::<S>(simd, &mut row[some.clone()], load_two::<S>(simd, sums));
            }
        }
    }
}

/// What all panels are multiplied by.
struct ByEigenvalue<'a> {
    eigenvalues: &'a [f32],
    taps: usize,
    inner: usize,
    tiles: Tiles,
    in_tiles: &'a [f32],
    formed: &'a mut [f32],
}

impl ByEigenvalue<'_> {
    /// Adds the terms of a panel, from the `first` on, to sums of its columns; the first terms of all replace them.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        simd: S,
        first: usize,
        panel: &[f32],
        sums: &mut [f32],
        (all_taps, next): (Taps<'_>, Block),
    ) {
        let ByEigenvalue { eigenvalues, taps, inner, tiles, in_tiles, formed } = self;
        let (taps, inner, width) = (*taps, *inner, 2 * S::F32_LANES);
        let (rows, terms) = (tiles.rows(), panel.len() / (taps * width));
        let of_eigenvalues = in_tiles.chunks_exact(rows * inner).zip(sums.chunks_exact_mut(rows * width));
        for (i, (&eigenvalue, (in_tiles, sums))) in eigenvalues.iter().zip(of_eigenvalues).enumerate() {
            let ahead = all_taps.ahead(next, i, eigenvalues.len());
            let weights = Weights { panel, taps, eigenvalue };
            if tiles.count() == 1 && fused_fits::<S>(rows, taps) {
                let a = &in_tiles[first * rows..][..terms * rows];
                fused::<S>(simd, rows, first > 0, sums, a, weights, ahead);
                continue;
            }
            let formed = &mut formed[..terms * width];
            weights.form::<S>(simd, formed);
            for (start, tall) in tiles.each() {
                (start * terms / rows..(start + tall) * terms / rows).for_each(|row| ahead.fetch(row));
                let a = &in_tiles[start * inner + first * tall..][..terms * tall];
                tile::<S>(simd, tall, first > 0, &mut sums[start * width..][..tall * width], a, formed);
            }
        }
    }
}

/// The block of `W(λ)` that a panel stands for.
#[derive(Clone, Copy)]
struct Weights<'a> {
    panel: &'a [f32],
    taps: usize,
    eigenvalue: f32,
}

impl Weights<'_> {
    /// Writes all of them.
    #[inline(always)]
    fn form<S: Simd>(self, simd: S, block: &mut [f32]) {
        let eigenvalue = simd.splat_f32s(self.eigenvalue);
        let (block, _) = S::as_mut_simd_f32s(block);
        let (block, _) = block.as_chunks_mut::<2>();
        let values = self.pairs::<S>();
        if self.taps == USUAL {
            let (terms, _) = values.as_chunks::<USUAL>();
            for (place, taps) in block.iter_mut().zip(terms) {
                *place = combined::<S>(simd, eigenvalue, taps);
            }
        } else {
            for (place, taps) in block.iter_mut().zip(values.chunks_exact(self.taps)) {
                *place = combined::<S>(simd, eigenvalue, taps);
            }
        }
    }

    /// Two vectors of columns of each tap of one term after another.
    #[inline(always)]
    fn pairs<S: Simd>(&self) -> &[[S::f32s; 2]] {
        S::as_simd_f32s(self.panel).0.as_chunks::<2>().0
    }
}

/// Two vectors of `W(λ)`, from the last tap inwards, so that no power is formed.
#[inline(always)]
fn combined<S: Simd>(simd: S, eigenvalue: S::f32s, taps: &[[S::f32s; 2]]) -> [S::f32s; 2] {
    let Some((last, others)) = taps.split_last() else { return [simd.splat_f32s(0.0); 2] };
    others.iter().rev().fold(*last, |inner, tap| {
        [simd.mul_add_e_f32s(inner[0], eigenvalue, tap[0]), simd.mul_add_e_f32s(inner[1], eigenvalue, tap[1])]
    })
}

/// Whether the sums of so many rows leave registers for an eigenvalue and what is formed of it.
#[inline(always)]
fn fused_fits<S: Simd>(rows: usize, taps: usize) -> bool {
    taps == USUAL && 2 * rows + 5 <= S::REGISTER_COUNT
}

/// `sums (+)= a W(λ)` for a tile of `rows` rows: `a` column by column, in registers all along.
#[inline(always)]
fn fused<S: Simd>(
    simd: S,
    rows: usize,
    add: bool,
    sums: &mut [f32],
    a: &[f32],
    weights: Weights<'_>,
    ahead: Ahead<'_>,
) {
    macro_rules! of_rows {
        ($($rows:literal)*) => {
            match rows {
                $($rows => sized::<S, $rows>(simd, add, sums, a, weights, ahead),)*
                _ => unreachable!("sums and what they are made of fit into registers"),
            }
        };
    }
    of_rows!(1 2 3 4 5 6 7 8 9 10 11 12 13)
}

#[inline(always)]
fn sized<S: Simd, const R: usize>(
    simd: S,
    add: bool,
    out: &mut [f32],
    a: &[f32],
    weights: Weights<'_>,
    ahead: Ahead<'_>,
) {
    let (out, _) = S::as_mut_simd_f32s(out);
    let (out, _) = out.as_chunks_mut::<2>();
    // An array, because a loop over a slice, whose length the compiler does not know, would keep the sums in memory.
    let Some(out) = out.first_chunk_mut::<R>() else { return };
    let mut sums = if add { *out } else { [[simd.splat_f32s(0.0); 2]; R] };
    let (a, _) = a.as_chunks::<R>();
    let eigenvalue = simd.splat_f32s(weights.eigenvalue);
    let (terms, _) = weights.pairs::<S>().as_chunks::<USUAL>();
    for (term, (a, taps)) in a.iter().zip(terms).enumerate() {
        ahead.fetch(term);
        let weights = combined::<S>(simd, eigenvalue, taps);
        add_products::<S, R>(simd, &mut sums, std::slice::from_ref(a), std::slice::from_ref(&weights));
    }
    *out = sums;
}
