//! A matrix with few entries in a row, as measurement and diffusion matrices on graphs are.

use faer::MatRef;

/// Compressed rows of a matrix; multiplying allocates nothing.
#[derive(Debug, Clone)]
pub(crate) struct SparseRows {
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
}

impl SparseRows {
    /// Keeps the non-zero entries of `matrix`.
    pub(crate) fn from_dense(matrix: MatRef<'_, f64>) -> Self {
        let mut rows = SparseRows { starts: vec![0], entries: Vec::new() };
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

    /// `(matrix · x)ᵢ`.
    #[inline]
    pub(crate) fn row_times(&self, i: usize, x: &[f64]) -> f64 {
        self.row(i).iter().map(|&(j, value)| value * x[j]).sum()
    }
}
