//! Small matrices of several particles side by side, so that one instruction serves them all.

/// Particles side by side.
pub(super) const LANES: usize = 8;

/// One number of each of several particles.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lane(pub(super) [f64; LANES]);

impl Lane {
    /// Column `column` of some rows of `width`; where there are too few, the last stands in for the others.
    #[inline(always)]
    pub(super) fn gather(rows: &[f64], width: usize, column: usize) -> Self {
        let count = rows.len() / width;
        Lane(std::array::from_fn(|lane| rows[lane.min(count - 1) * width + column]))
    }

    #[inline(always)]
    pub(super) fn add_scaled(&mut self, scale: f64, other: &Lane) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, term)| *sum += scale * term);
    }

    #[inline(always)]
    pub(super) fn add_product(&mut self, a: &Lane, b: &Lane) {
        self.0.iter_mut().zip(a.0.iter().zip(&b.0)).for_each(|(sum, (a, b))| *sum += a * b);
    }

    #[inline(always)]
    pub(super) fn subtract_product(&mut self, a: &Lane, b: &Lane) {
        self.0.iter_mut().zip(a.0.iter().zip(&b.0)).for_each(|(sum, (a, b))| *sum -= a * b);
    }

    #[inline(always)]
    pub(super) fn divide(&mut self, by: &Lane) {
        self.0.iter_mut().zip(&by.0).for_each(|(value, by)| *value /= by);
    }
}

/// A square matrix of each of several particles.
pub(super) struct Square {
    width: usize,
    entries: Vec<Lane>,
}

impl Square {
    pub(super) fn zeros(width: usize) -> Self {
        Square { width, entries: vec![Lane::default(); width * width] }
    }

    #[inline(always)]
    pub(super) fn at(&self, i: usize, j: usize) -> &Lane {
        &self.entries[i * self.width + j]
    }

    #[inline(always)]
    pub(super) fn at_mut(&mut self, i: usize, j: usize) -> &mut Lane {
        &mut self.entries[i * self.width + j]
    }
}

/// Runs loops with the widest vector instructions that this machine has.
#[inline(always)]
pub(super) fn vectorised<R>(loops: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(loops)
}
