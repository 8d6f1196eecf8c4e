//! Small vectors and matrices of several particles side by side, so that one instruction serves them all.

use motes_models::batch::by_widest_vectors;
use pulp::{Simd, WithSimd};

/// Particles side by side.
pub(crate) const LANES: usize = 8;

/// One number of each of several particles.
///
/// What changes one makes all numbers before it stores any, which a compiler needs to see to use vector instructions.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Lane(pub(crate) [f64; LANES]);

impl Lane {
    /// Column `column` of some rows of `width`; where there are too few, the last stands in for the others.
    #[inline(always)]
    pub(crate) fn gather(rows: &[f64], width: usize, column: usize) -> Self {
        let count = rows.len() / width;
        Lane(std::array::from_fn(|lane| rows[lane.min(count - 1) * width + column]))
    }

    /// The same with zeros where there are too few.
    #[inline(always)]
    pub(crate) fn gather_or_zero(rows: &[f64], width: usize, column: usize) -> Self {
        let mut lane = Lane::gather(rows, width, column);
        lane.0[rows.len() / width..].fill(0.0);
        lane
    }

    /// The inverse of [`Lane::gather`].
    #[inline(always)]
    pub(crate) fn scatter(&self, rows: &mut [f64], width: usize, column: usize) {
        for (row, value) in rows.chunks_exact_mut(width).zip(&self.0) {
            row[column] = *value;
        }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Lane) {
        self.0 = std::array::from_fn(|lane| self.0[lane] + other.0[lane]);
    }

    #[inline(always)]
    pub(crate) fn add_scaled(&mut self, scale: f64, other: &Lane) {
        self.0 = std::array::from_fn(|lane| self.0[lane] + scale * other.0[lane]);
    }

    #[inline(always)]
    pub(crate) fn add_product(&mut self, a: &Lane, b: &Lane) {
        self.0 = std::array::from_fn(|lane| self.0[lane] + a.0[lane] * b.0[lane]);
    }

    #[inline(always)]
    pub(crate) fn subtract_product(&mut self, a: &Lane, b: &Lane) {
        self.0 = std::array::from_fn(|lane| self.0[lane] - a.0[lane] * b.0[lane]);
    }

    #[inline(always)]
    pub(crate) fn divide(&mut self, by: &Lane) {
        self.0 = std::array::from_fn(|lane| self.0[lane] / by.0[lane]);
    }

    /// The sum over the particles.
    pub(crate) fn sum(&self) -> f64 {
        self.0.iter().sum()
    }
}

/// A square matrix of each of several particles.
pub(crate) struct Square {
    width: usize,
    entries: Vec<Lane>,
}

impl Square {
    pub(crate) fn zeros(width: usize) -> Self {
        Square { width, entries: vec![Lane::default(); width * width] }
    }

    #[inline(always)]
    pub(crate) fn at(&self, i: usize, j: usize) -> &Lane {
        &self.entries[i * self.width + j]
    }

    #[inline(always)]
    pub(crate) fn at_mut(&mut self, i: usize, j: usize) -> &mut Lane {
        &mut self.entries[i * self.width + j]
    }

    /// The sum over the particles, row-major.
    pub(crate) fn sums(&self) -> Vec<f64> {
        self.entries.iter().map(Lane::sum).collect()
    }
}

/// Numbers of all particles, block of particles by block.
#[derive(Clone, Copy)]
pub(crate) struct Blocks<'a> {
    /// From the first number of the first block on.
    pub(crate) lanes: &'a [Lane],
    /// How many of each block count, ...
    pub(crate) width: usize,
    /// ... and how many there are to the first one of the next.
    pub(crate) stride: usize,
}

impl Blocks<'_> {
    /// The sum of each number over all particles.
    pub(crate) fn sums(self) -> Vec<f64> {
        let mut sums = vec![Lane::default(); self.width];
        by_widest_vectors(
            #[inline(always)]
            || {
                for block in self.lanes.chunks(self.stride) {
                    for (sum, lane) in sums.iter_mut().zip(block) {
                        sum.add(lane);
                    }
                }
            },
        );
        sums.iter().map(Lane::sum).collect()
    }

    /// The sum of `aᵢ bⱼ` over all particles, row-major.
    pub(crate) fn outer(self, b: Blocks<'_>) -> Vec<f64> {
        let mut sums = vec![0.0; self.width * b.width];
        pulp::Arch::new().dispatch(Outer { a: self, b, sums: &mut sums });
        sums
    }
}

/// `outⱼ = outⱼ + Σᵢ aᵢ Wᵢⱼ`, with a row-major matrix that is the same for all particles.
pub(crate) fn add_times(out: &mut [Lane], a: &[Lane], matrix: &[f64]) {
    let steps = [out.len(), 1];
    pulp::Arch::new().dispatch(Times { out, start: Start::There, a, matrix, steps });
}

/// `outⱼ = bⱼ + Σᵢ aᵢ Wᵢⱼ`, as [`add_times`].
pub(crate) fn set_times(out: &mut [Lane], b: &[f64], a: &[Lane], matrix: &[f64]) {
    let steps = [out.len(), 1];
    pulp::Arch::new().dispatch(Times { out, start: Start::Same(b), a, matrix, steps });
}

/// `outᵢ = Σⱼ aⱼ Wᵢⱼ`, as [`add_times`].
pub(crate) fn set_times_transposed(out: &mut [Lane], a: &[Lane], matrix: &[f64]) {
    let steps = [1, a.len()];
    pulp::Arch::new().dispatch(Times { out, start: Start::Zero, a, matrix, steps });
}

// Written in vectors, because a compiler would rather gather one number of each of several lanes.

struct Outer<'a> {
    a: Blocks<'a>,
    b: Blocks<'a>,
    sums: &'a mut [f64],
}

impl WithSimd for Outer<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Outer { a, b, sums } = self;
        for (row, sums) in (0..).step_by(2).zip(sums.chunks_mut(2 * b.width)) {
            for column in (0..b.width).step_by(5) {
                let at = [row, column];
                match (sums.len() / b.width, b.width - column) {
                    (2, 5..) => outer::<S, 2, 5>(simd, a, b, at, sums),
                    (2, 4) => outer::<S, 2, 4>(simd, a, b, at, sums),
                    (2, 3) => outer::<S, 2, 3>(simd, a, b, at, sums),
                    (2, 2) => outer::<S, 2, 2>(simd, a, b, at, sums),
                    (2, _) => outer::<S, 2, 1>(simd, a, b, at, sums),
                    (_, 5..) => outer::<S, 1, 5>(simd, a, b, at, sums),
                    (_, 4) => outer::<S, 1, 4>(simd, a, b, at, sums),
                    (_, 3) => outer::<S, 1, 3>(simd, a, b, at, sums),
                    (_, 2) => outer::<S, 1, 2>(simd, a, b, at, sums),
                    (_, _) => outer::<S, 1, 1>(simd, a, b, at, sums),
                }
            }
        }
    }
}

/// Some rows and columns of the sums, in registers over all blocks of particles.
#[inline(always)]
fn outer<S: Simd, const R: usize, const C: usize>(
    simd: S,
    a: Blocks<'_>,
    b: Blocks<'_>,
    [row, column]: [usize; 2],
    into: &mut [f64],
) {
    let mut lanes = [[Lane::default(); C]; R];
    for part in 0..LANES / S::F64_LANES {
        let mut sums = [[simd.splat_f64s(0.0); C]; R];
        for (a, b) in a.lanes.chunks(a.stride).zip(b.lanes.chunks(b.stride)) {
            let (a, b) = (&a[row..row + R], &b[column..column + C]);
            for (sums, a) in sums.iter_mut().zip(a) {
                let a = S::as_simd_f64s(&a.0).0[part];
                for (sum, b) in sums.iter_mut().zip(b) {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(a, S::as_simd_f64s(&b.0).0[part]));
                }
            }
        }
        for (lane, sum) in lanes.as_flattened_mut().iter_mut().zip(sums.as_flattened()) {
            S::as_mut_simd_f64s(&mut lane.0).0[part] = *sum;
        }
    }
    for (lanes, into) in lanes.iter().zip(into.chunks_exact_mut(b.width)) {
        lanes.iter().zip(&mut into[column..]).for_each(|(lane, into)| *into = lane.sum());
    }
}

/// What a sum is added to.
#[derive(Clone, Copy)]
enum Start<'a> {
    Zero,
    /// What is there.
    There,
    /// A number that is the same for all particles.
    Same(&'a [f64]),
}

struct Times<'a> {
    out: &'a mut [Lane],
    start: Start<'a>,
    a: &'a [Lane],
    matrix: &'a [f64],
    /// How far entries are from one term of a sum to the next, and from one sum to the next.
    steps: [usize; 2],
}

impl WithSimd for Times<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Times { out, start, a, matrix, steps } = self;
        // Several sums at a time hide how long an addition takes.
        for (first, out) in (0..).step_by(5).zip(out.chunks_mut(5)) {
            let matrix = &matrix[first * steps[1]..];
            let start = match start {
                Start::Same(numbers) => Start::Same(&numbers[first..]),
                other => other,
            };
            match out.len() {
                5 => sums::<S, 5>(simd, out, start, a, matrix, steps),
                4 => sums::<S, 4>(simd, out, start, a, matrix, steps),
                3 => sums::<S, 3>(simd, out, start, a, matrix, steps),
                2 => sums::<S, 2>(simd, out, start, a, matrix, steps),
                _ => sums::<S, 1>(simd, out, start, a, matrix, steps),
            }
        }
    }
}

#[inline(always)]
fn sums<S: Simd, const C: usize>(
    simd: S,
    out: &mut [Lane],
    start: Start<'_>,
    a: &[Lane],
    matrix: &[f64],
    [to_next_term, to_next_sum]: [usize; 2],
) {
    for part in 0..LANES / S::F64_LANES {
        let mut sums = [simd.splat_f64s(0.0); C];
        match start {
            Start::Zero => {}
            Start::There => {
                for (sum, out) in sums.iter_mut().zip(&*out) {
                    *sum = S::as_simd_f64s(&out.0).0[part];
                }
            }
            Start::Same(numbers) => {
                for (sum, number) in sums.iter_mut().zip(numbers) {
                    *sum = simd.splat_f64s(*number);
                }
            }
        }
        for (i, a) in a.iter().enumerate() {
            let a = S::as_simd_f64s(&a.0).0[part];
            let entries = &matrix[i * to_next_term..][..(C - 1) * to_next_sum + 1];
            for (c, sum) in sums.iter_mut().enumerate() {
                *sum = simd.add_f64s(*sum, simd.mul_f64s(simd.splat_f64s(entries[c * to_next_sum]), a));
            }
        }
        for (out, sum) in out.iter_mut().zip(sums) {
            S::as_mut_simd_f64s(&mut out.0).0[part] = sum;
        }
    }
}
