//! Small vectors and matrices of several particles side by side, so that one instruction serves them all.

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

    /// Adds `aᵢ bⱼ` to each entry.
    pub(crate) fn add_outer(&mut self, a: &[Lane], b: &[Lane]) {
        pulp::Arch::new().dispatch(AddOuter { entries: &mut self.entries, a, b });
    }

    /// The sum over the particles, row-major.
    pub(crate) fn sums(&self) -> Vec<f64> {
        self.entries.iter().map(Lane::sum).collect()
    }
}

/// `outⱼ = outⱼ + Σᵢ aᵢ Wᵢⱼ`, with a row-major matrix that is the same for all particles.
pub(crate) fn add_times(out: &mut [Lane], a: &[Lane], matrix: &[f64]) {
    let width = out.len();
    pulp::Arch::new().dispatch(AddTimes { out, a, matrix, to_next_term: width, to_next_sum: 1 });
}

/// `outᵢ = outᵢ + Σⱼ aⱼ Wᵢⱼ`, as [`add_times`].
pub(crate) fn add_times_transposed(out: &mut [Lane], a: &[Lane], matrix: &[f64]) {
    let width = a.len();
    pulp::Arch::new().dispatch(AddTimes { out, a, matrix, to_next_term: 1, to_next_sum: width });
}

// Written in vectors, because a compiler would rather gather one number of each of several lanes.

struct AddOuter<'a> {
    entries: &'a mut [Lane],
    a: &'a [Lane],
    b: &'a [Lane],
}

impl WithSimd for AddOuter<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (row, a) in self.entries.chunks_exact_mut(self.b.len().max(1)).zip(self.a) {
            let (a, _) = S::as_simd_f64s(&a.0);
            for (entry, b) in row.iter_mut().zip(self.b) {
                let ((entry, _), (b, _)) = (S::as_mut_simd_f64s(&mut entry.0), S::as_simd_f64s(&b.0));
                for ((entry, a), b) in entry.iter_mut().zip(a).zip(b) {
                    *entry = simd.add_f64s(*entry, simd.mul_f64s(*a, *b));
                }
            }
        }
    }
}

struct AddTimes<'a> {
    out: &'a mut [Lane],
    a: &'a [Lane],
    matrix: &'a [f64],
    /// How far entries are from one term of a sum to the next, ...
    to_next_term: usize,
    /// ... and from one sum to the next.
    to_next_sum: usize,
}

impl WithSimd for AddTimes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let AddTimes { out, a, matrix, to_next_term, to_next_sum } = self;
        // Several sums at a time hide how long an addition takes.
        let (fours, rest) = out.as_chunks_mut::<4>();
        for (four, out) in fours.iter_mut().enumerate() {
            sums::<S, 4>(simd, out, a, &matrix[4 * four * to_next_sum..], [to_next_term, to_next_sum]);
        }
        for (number, out) in (4 * fours.len()..).zip(rest) {
            sums::<S, 1>(
                simd,
                std::array::from_mut(out),
                a,
                &matrix[number * to_next_sum..],
                [to_next_term, to_next_sum],
            );
        }
    }
}

#[inline(always)]
fn sums<S: Simd, const C: usize>(
    simd: S,
    out: &mut [Lane; C],
    a: &[Lane],
    matrix: &[f64],
    [to_next_term, to_next_sum]: [usize; 2],
) {
    for part in 0..LANES / S::F64_LANES {
        let mut sums = [simd.splat_f64s(0.0); C];
        for (sum, out) in sums.iter_mut().zip(&*out) {
            *sum = S::as_simd_f64s(&out.0).0[part];
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

/// Runs loops with the widest vector instructions that this machine has.
#[inline(always)]
pub(crate) fn vectorised<R>(loops: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(loops)
}
