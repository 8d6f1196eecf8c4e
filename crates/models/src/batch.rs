//! Many particles at once: tiles in which coordinates stand in rows and particles in lanes, and matrices that map them.
//!
//! A batch of states is row-major, particle after particle, which is no order for vector instructions. A tile holds
//! [`LANES`] particles the other way round: coordinate `i` of all of them side by side. Every lane is computed by itself and
//! with fused multiplications, so a particle's numbers depend neither on its neighbours nor on the machine's vector width.

mod noise;
mod rows;
mod transpose;
mod widest;

use std::cell::RefCell;
use std::hint::black_box;

use faer::MatRef;
use pulp::{Simd, WithSimd};

use crate::Stream;

pub use noise::with_noise;
pub use rows::{Rows, load, store};
pub use widest::by_widest_vectors;

/// Particles in a tile.
pub const LANES: usize = 32;

thread_local! {
    static SCRATCH: RefCell<Vec<Vec<f64>>> = const { RefCell::new(Vec::new()) };
}

/// Lends scratch of `len` numbers of any value, which begins with a line of cache. It is the thread's own and kept, so that asking again allocates
/// nothing.
pub fn with_scratch<R>(len: usize, work: impl FnOnce(&mut [f64]) -> R) -> R {
    // Taken, not borrowed, so that a call inside a call gets another.
    let mut scratch = SCRATCH.with_borrow_mut(Vec::pop).unwrap_or_default();
    if scratch.len() < len + LINE {
        scratch.resize(len + LINE, 0.0);
    }
    // Vectors as long as a line would otherwise each lie in two.
    let start = scratch.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
    let result = work(&mut scratch[start..start + len]);
    SCRATCH.with_borrow_mut(|kept| kept.push(scratch));
    result
}

/// Allocates what [`with_scratch`] lends on this thread for `depth` calls inside each other, of up to `len` numbers each.
pub fn reserve_scratch(depth: usize, len: usize) {
    SCRATCH.with_borrow_mut(|kept| {
        kept.retain(|scratch| scratch.len() >= len + LINE);
        kept.resize_with(depth.max(kept.len()), || vec![0.0; len + LINE]);
    });
}

/// Numbers in a line of cache, which is as long as the longest vector.
const LINE: usize = 8;

/// Whether so many numbers of 64 bits can be had at once: asked before what would end the process if they cannot.
pub fn there_is_memory_for(numbers: usize) -> bool {
    let mut memory = Vec::<f64>::new();
    // A compiler may leave out memory that nobody looks at.
    black_box(memory.try_reserve_exact(numbers)).is_ok() && black_box(memory).is_empty()
}

/// A matrix that maps tiles, with the entries that are not zero: a diagonal or triangular one costs what it has.
#[derive(Debug, Clone)]
pub struct TileMatrix {
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
}

impl TileMatrix {
    /// Keeps the non-zero entries of `matrix`.
    pub fn new(matrix: MatRef<'_, f64>) -> Self {
        let mut rows = TileMatrix { starts: vec![0], entries: Vec::new() };
        for i in 0..matrix.nrows() {
            let entries = (0..matrix.ncols()).map(|j| (j, matrix[(i, j)]));
            rows.entries.extend(entries.filter(|(_, value)| *value != 0.0));
            rows.starts.push(rows.entries.len());
        }
        rows
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The entries (column, value) of row `i`.
    #[inline]
    pub(crate) fn row(&self, i: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[i]..self.starts[i + 1]]
    }

    /// `(matrix · x)ᵢ` of a single vector.
    #[inline]
    pub(crate) fn row_times(&self, i: usize, x: &[f64]) -> f64 {
        self.row(i).iter().map(|&(j, value)| value * x[j]).sum()
    }

    /// `out = matrix · tile` for all [`LANES`] lanes.
    ///
    /// # Panics
    /// If a tile has fewer rows than the matrix asks for.
    pub fn times(&self, tile: &[f64], out: &mut [f64]) {
        pulp::Arch::new().dispatch(Times { matrix: self, tile, out, then: Then::Set });
    }

    /// `out = out + matrix · tile`, as [`TileMatrix::times`].
    ///
    /// # Panics
    /// As [`TileMatrix::times`].
    pub fn times_add(&self, tile: &[f64], out: &mut [f64]) {
        pulp::Arch::new().dispatch(Times { matrix: self, tile, out, then: Then::Add });
    }

    /// `out = out − matrix · tile`, as [`TileMatrix::times`].
    ///
    /// # Panics
    /// As [`TileMatrix::times`].
    pub fn times_subtract(&self, tile: &[f64], out: &mut [f64]) {
        pulp::Arch::new().dispatch(Times { matrix: self, tile, out, then: Then::Subtract });
    }
}

/// What becomes of a product.
#[derive(Clone, Copy)]
enum Then {
    Set,
    Add,
    Subtract,
}

struct Times<'a> {
    matrix: &'a TileMatrix,
    tile: &'a [f64],
    out: &'a mut [f64],
    then: Then,
}

impl WithSimd for Times<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // Four sums at a time hide the time that each addition takes.
        let (tile, _) = S::as_simd_f64s(self.tile).0.as_chunks::<4>();
        let (out, _) = S::as_mut_simd_f64s(self.out).0.as_chunks_mut::<4>();
        let groups = LANES / (4 * S::F64_LANES);
        for (i, out) in out.chunks_exact_mut(groups).take(self.matrix.len()).enumerate() {
            let entries = self.matrix.row(i);
            for (group, out) in out.iter_mut().enumerate() {
                let [mut a, mut b, mut c, mut d] = [simd.splat_f64s(0.0); 4];
                for &(j, value) in entries {
                    let column = &tile[j * groups + group];
                    let value = simd.splat_f64s(value);
                    a = simd.mul_add_f64s(value, column[0], a);
                    b = simd.mul_add_f64s(value, column[1], b);
                    c = simd.mul_add_f64s(value, column[2], c);
                    d = simd.mul_add_f64s(value, column[3], d);
                }
                for (out, sum) in out.iter_mut().zip([a, b, c, d]) {
                    *out = match self.then {
                        Then::Set => sum,
                        Then::Add => simd.add_f64s(*out, sum),
                        Then::Subtract => simd.sub_f64s(*out, sum),
                    };
                }
            }
        }
    }
}

/// The particles (`R` of them, rows of `width` in `states`) of each stream together with it.
///
/// # Panics
/// If `particles` is not a multiple of the number of streams.
pub fn particles_by_stream<'a>(
    streams: &'a mut [Stream],
    states: &'a mut [f64],
    width: usize,
    particles: usize,
) -> impl Iterator<Item = (&'a mut Stream, &'a mut [f64])> {
    assert!(particles.is_multiple_of(streams.len()), "{particles} particles for {} streams", streams.len());
    let block = width * (particles / streams.len().max(1));
    streams.iter_mut().zip(states.chunks_exact_mut(block.max(1)))
}

/// Shows each of `R` rows of `width` numbers in `out` to `draw`, with its number and its stream; the rows are split evenly over `streams`, in order.
///
/// # Panics
/// If `R` is not a multiple of the number of streams.
pub fn draw_rows(
    streams: &mut [Stream],
    width: usize,
    out: &mut [f64],
    mut draw: impl FnMut(usize, &mut Stream, &mut [f64]),
) {
    let (rows, mut row) = (out.len() / width.max(1), 0);
    for (stream, out) in particles_by_stream(streams, out, width, rows) {
        for out in out.chunks_exact_mut(width.max(1)) {
            draw(row, stream, out);
            row += 1;
        }
    }
}

/// [`draw_rows`] where each stream has one row, and whether that is so.
///
/// Simulated sequences have one particle. Drawn coordinate by coordinate, and not as noise in bulk, they are those of the published experiments.
pub(crate) fn draw_single_rows(
    streams: &mut [Stream],
    width: usize,
    out: &mut [f64],
    draw: impl FnMut(usize, &mut Stream, &mut [f64]),
) -> bool {
    let is_single = out.len() == streams.len() * width;
    if is_single {
        draw_rows(streams, width, out, draw);
    }
    is_single
}

/// `sums[l] = Σᵢ rowᵢ[l]²`, over the rows of a tile.
pub fn squared_norms(tile: &[f64], sums: &mut [f64; LANES]) {
    pulp::Arch::new().dispatch(SquaredNorms { tile, sums });
}

struct SquaredNorms<'a> {
    tile: &'a [f64],
    sums: &'a mut [f64; LANES],
}

impl WithSimd for SquaredNorms<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (tile, _) = S::as_simd_f64s(self.tile).0.as_chunks::<4>();
        let (sums, _) = S::as_mut_simd_f64s(self.sums.as_mut_slice()).0.as_chunks_mut::<4>();
        let groups = sums.len();
        for (group, sums) in sums.iter_mut().enumerate() {
            let [mut a, mut b, mut c, mut d] = [simd.splat_f64s(0.0); 4];
            for row in tile.iter().skip(group).step_by(groups) {
                a = simd.mul_add_f64s(row[0], row[0], a);
                b = simd.mul_add_f64s(row[1], row[1], b);
                c = simd.mul_add_f64s(row[2], row[2], c);
                d = simd.mul_add_f64s(row[3], row[3], d);
            }
            *sums = [a, b, c, d];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn a_tile_is_mapped_as_each_of_its_particles() {
        let matrix = Mat::from_fn(3, 5, |i, j| if (i + j) % 2 == 0 { (1 + i * j) as f64 * 0.3 } else { 0.0 });
        let map = TileMatrix::new(matrix.as_ref());
        for particles in [1, 7, 8, 9, 31, 32] {
            let states: Vec<f64> = (0..particles * 5).map(|i| (i as f64).sin()).collect();
            let (mut tile, mut out) = (vec![0.0; 5 * LANES], vec![0.0; 3 * LANES]);
            load(&states, 5, &mut tile);
            map.times(&tile, &mut out);
            let mut mapped = vec![0.0; particles * 3];
            store(&out, 3, &mut mapped);
            for (state, mapped) in states.chunks_exact(5).zip(mapped.chunks_exact(3)) {
                (0..3).for_each(|i| assert!((map.row_times(i, state) - mapped[i]).abs() < 1e-14));
            }
            map.times_add(&tile, &mut out);
            map.times_add(&tile, &mut out);
            map.times_subtract(&tile, &mut out);
            let mut squares = [0.0; LANES];
            squared_norms(&out, &mut squares);
            for (mapped, square) in mapped.chunks_exact(3).zip(squares) {
                let expected: f64 = mapped.iter().map(|value| 4.0 * value * value).sum();
                assert!((square - expected).abs() < 1e-12 * (1.0 + expected));
            }
        }
    }

    #[test]
    fn products_do_not_depend_on_the_machines_vectors() {
        let matrix = Mat::from_fn(4, 6, |i, j| 0.1 * (1 + 3 * i + j) as f64);
        let map = TileMatrix::new(matrix.as_ref());
        let tile: Vec<f64> = (0..6 * LANES).map(|i| (0.7 * i as f64).sin()).collect();
        let (mut narrow, mut wide) = (vec![1.0; 4 * LANES], vec![1.0; 4 * LANES]);
        map.times_add(&tile, &mut wide);
        pulp::Scalar::new().vectorize(Times { matrix: &map, tile: &tile, out: &mut narrow, then: Then::Add });
        assert_eq!(narrow, wide);
        let mut sums = [[0.0; LANES]; 2];
        squared_norms(&tile, &mut sums[0]);
        pulp::Scalar::new().vectorize(SquaredNorms { tile: &tile, sums: &mut sums[1] });
        assert_eq!(sums[0], sums[1]);
    }

    #[test]
    fn scratch_within_scratch_is_another() {
        with_scratch(4, |outer| {
            outer.fill(1.0);
            with_scratch(9, |inner| inner.fill(2.0));
            assert_eq!(outer, [1.0; 4]);
        });
        assert_eq!(with_scratch(4, |kept| kept[3]), 1.0);
    }
}
