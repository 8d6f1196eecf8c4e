//! The transform of one time, forward: from noise to states, with the log density along the way.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::PartialPivLu;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use motes_smc::{Past, ProposalError};

/// An invertible matrix with its factors. Samples are rows, so it is applied from the right.
#[derive(Clone)]
pub(super) struct Square {
    pub(super) matrix: Mat<f64>,
    pub(super) factors: PartialPivLu<f64>,
    log_abs_det: f64,
}

impl Square {
    /// Takes row-major `entries` and adds `ridge` to the diagonal.
    pub(super) fn new(
        width: usize,
        entries: &[f64],
        ridge: f64,
        time: usize,
        name: impl Fn() -> String,
    ) -> Result<Self, ProposalError> {
        let mut matrix = row_major(entries, width, width);
        for i in 0..width {
            matrix[(i, i)] += ridge;
        }
        let factors = matrix.partial_piv_lu();
        let log_abs_det: f64 = (0..width).map(|i| factors.U()[(i, i)].abs().ln()).sum();
        if !log_abs_det.is_finite() {
            return Err(ProposalError::Singular { matrix: name(), time, log_abs_det });
        }
        Ok(Square { matrix, factors, log_abs_det })
    }
}

/// The transform of one time.
#[derive(Clone)]
pub(super) struct Map {
    /// `A`.
    pub(super) noise: Square,
    /// `B`, `N×N`.
    pub(super) previous: Mat<f64>,
    /// `C`, `M×N`.
    pub(super) measurement: Mat<f64>,
    /// `W_ℓ` and `b_ℓ`.
    pub(super) layers: Vec<(Square, Vec<f64>)>,
}

/// The outputs of all layers but the last, and of the first affine map before them: `R×N` each.
pub(super) type Activations = Vec<Vec<f64>>;

impl Map {
    fn width(&self) -> usize {
        self.noise.matrix.nrows()
    }

    /// `log|det A| + Σ_ℓ log|det W_ℓ|`.
    pub(super) fn log_abs_det(&self) -> f64 {
        self.noise.log_abs_det + self.layers.iter().map(|(square, _)| square.log_abs_det).sum::<f64>()
    }

    /// `B x_{t−1} + C y_t` of each particle, `R×N`.
    pub(super) fn shifts(&self, past: &Past<'_>) -> Vec<f64> {
        let n = self.width();
        let mut shifts = vec![0.0; past.particles * n];
        if let Some(previous) = past.previous {
            times(previous, self.previous.as_ref(), &mut shifts);
        }
        for (i, value) in past.measurement.iter().enumerate() {
            for shift in shifts.chunks_exact_mut(n) {
                for (j, shift) in shift.iter_mut().enumerate() {
                    *shift += value * self.measurement[(i, j)];
                }
            }
        }
        shifts
    }

    /// Transforms `noise` (`R×N`) into `states` (`R×N`), with `log q` in `log_density` (`R`).
    pub(super) fn forward(
        &self,
        shifts: &[f64],
        noise: &[f64],
        states: &mut [f64],
        log_density: &mut [f64],
    ) -> Activations {
        let n = self.width();
        log_density.fill(-self.log_abs_det());
        let mut values = vec![0.0; noise.len()];
        times(noise, self.noise.matrix.as_ref(), &mut values);
        values.iter_mut().zip(shifts).for_each(|(value, shift)| *value += shift);
        let mut activations = Vec::with_capacity(self.layers.len());
        for (square, bias) in &self.layers {
            for (row, log_density) in values.chunks_exact(n).zip(log_density.iter_mut()) {
                *log_density -= row.iter().copied().map(log_slope_of_tanh).sum::<f64>();
            }
            values.iter_mut().for_each(|value| *value = value.tanh());
            let mut next = bias.repeat(log_density.len());
            times_add(&values, square.matrix.as_ref(), &mut next);
            activations.push(std::mem::replace(&mut values, next));
        }
        states.copy_from_slice(&values);
        activations
    }
}

/// `log(1 − tanh²a)`, without the cancellation.
fn log_slope_of_tanh(a: f64) -> f64 {
    let size = a.abs();
    2.0 * (std::f64::consts::LN_2 - size - (-2.0 * size).exp().ln_1p())
}

/// A matrix from row-major values.
pub(super) fn row_major(values: &[f64], rows: usize, columns: usize) -> Mat<f64> {
    MatRef::from_row_major_slice(values, rows, columns).to_owned()
}

/// `rows · matrix`, for row-major rows.
pub(super) fn times(rows: &[f64], matrix: MatRef<'_, f64>, out: &mut [f64]) {
    multiply(rows, matrix, out, Accum::Replace);
}

/// Adds `rows · matrix`.
fn times_add(rows: &[f64], matrix: MatRef<'_, f64>, out: &mut [f64]) {
    multiply(rows, matrix, out, Accum::Add);
}

fn multiply(rows: &[f64], matrix: MatRef<'_, f64>, out: &mut [f64], accum: Accum) {
    // Row-major rows are the columns of the transpose.
    let (inputs, outputs) = (matrix.nrows(), matrix.ncols());
    let count = out.len() / outputs;
    let rows = MatRef::from_column_major_slice(rows, inputs, count);
    let out = MatMut::from_column_major_slice_mut(out, outputs, count);
    matmul(out, accum, matrix.transpose(), rows, 1.0, Par::Seq);
}
