//! Small vectors and matrices of several particles side by side, so that one instruction serves them all.

/// Particles side by side.
pub(crate) const LANES: usize = 8;

/// One number of each of several particles.
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
        self.0.iter_mut().zip(&other.0).for_each(|(sum, term)| *sum += term);
    }

    #[inline(always)]
    pub(crate) fn add_scaled(&mut self, scale: f64, other: &Lane) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, term)| *sum += scale * term);
    }

    #[inline(always)]
    pub(crate) fn add_product(&mut self, a: &Lane, b: &Lane) {
        self.0.iter_mut().zip(a.0.iter().zip(&b.0)).for_each(|(sum, (a, b))| *sum += a * b);
    }

    #[inline(always)]
    pub(crate) fn subtract_product(&mut self, a: &Lane, b: &Lane) {
        self.0.iter_mut().zip(a.0.iter().zip(&b.0)).for_each(|(sum, (a, b))| *sum -= a * b);
    }

    #[inline(always)]
    pub(crate) fn divide(&mut self, by: &Lane) {
        self.0.iter_mut().zip(&by.0).for_each(|(value, by)| *value /= by);
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

/// Runs loops with the widest vector instructions that this machine has.
#[inline(always)]
pub(crate) fn vectorised<R>(loops: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(loops)
}
