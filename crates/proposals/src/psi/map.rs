//! The transform of one time, forward: from noise to states, with the log density along the way.

use std::f64::consts::LN_2;

use motes_models::elementary::{exp, ln};
use motes_smc::{Past, ProposalError};

use crate::lanes::{LANES, Lane, vectorised};

/// An invertible matrix, row-major. Samples are rows, so it is applied from the right.
#[derive(Debug, Clone)]
pub(super) struct Invertible {
    pub(super) matrix: Vec<f64>,
    pub(super) inverse: Vec<f64>,
    log_abs_det: f64,
}

impl Invertible {
    /// Takes row-major `entries` and adds `ridge` to the diagonal.
    pub(super) fn new(
        width: usize,
        mut matrix: Vec<f64>,
        ridge: f64,
        time: usize,
        name: impl Fn() -> String,
    ) -> Result<Self, ProposalError> {
        for i in 0..width {
            matrix[i * width + i] += ridge;
        }
        let (inverse, log_abs_det) = invert(width, &matrix);
        if !log_abs_det.is_finite() {
            return Err(ProposalError::Singular { matrix: name(), time, log_abs_det });
        }
        Ok(Invertible { matrix, inverse, log_abs_det })
    }
}

/// The inverse and the logarithm of the absolute determinant, by elimination with row pivots.
fn invert(width: usize, matrix: &[f64]) -> (Vec<f64>, f64) {
    let wide = 2 * width;
    let mut rows = vec![0.0; width * wide];
    for (i, (row, from)) in rows.chunks_exact_mut(wide).zip(matrix.chunks_exact(width)).enumerate() {
        row[..width].copy_from_slice(from);
        row[width + i] = 1.0;
    }
    let mut log_abs_det = 0.0;
    let mut pivot_row = vec![0.0; wide];
    for k in 0..width {
        let size = |i: usize| rows[i * wide + k].abs();
        let pivot = (k..width).max_by(|&i, &j| size(i).total_cmp(&size(j))).unwrap_or(k);
        for j in 0..wide {
            rows.swap(k * wide + j, pivot * wide + j);
        }
        let lead = rows[k * wide + k];
        log_abs_det += lead.abs().ln();
        for (kept, value) in pivot_row.iter_mut().zip(&mut rows[k * wide..(k + 1) * wide]) {
            *value /= lead;
            *kept = *value;
        }
        for (i, row) in rows.chunks_exact_mut(wide).enumerate() {
            let factor = row[k];
            if i != k && factor != 0.0 {
                row.iter_mut().zip(&pivot_row).for_each(|(value, pivot)| *value -= factor * pivot);
            }
        }
    }
    let inverse = rows.chunks_exact(wide).flat_map(|row| row[width..].iter().copied()).collect();
    (inverse, log_abs_det)
}

/// The transform of one time. Matrices are row-major.
#[derive(Debug, Clone)]
pub(super) struct Map {
    pub(super) width: usize,
    /// `A`.
    pub(super) noise: Invertible,
    /// `B`, `N×N`.
    pub(super) previous: Vec<f64>,
    /// `C`, `M×N`.
    pub(super) measurement: Vec<f64>,
    /// `W_ℓ` and `b_ℓ`.
    pub(super) layers: Vec<(Invertible, Vec<f64>)>,
}

impl Map {
    /// `log|det A| + Σ_ℓ log|det W_ℓ|`.
    pub(super) fn log_abs_det(&self) -> f64 {
        self.noise.log_abs_det + self.layers.iter().map(|(layer, _)| layer.log_abs_det).sum::<f64>()
    }

    /// `B x_{t−1} + C y_t` of each particle, `R×N`.
    pub(super) fn shifts(&self, past: &Past<'_>) -> Vec<f64> {
        let n = self.width;
        let mut common = vec![0.0; n];
        for (value, row) in past.measurement.iter().zip(self.measurement.chunks_exact(n)) {
            common.iter_mut().zip(row).for_each(|(sum, entry)| *sum += value * entry);
        }
        let mut shifts = common.repeat(past.particles);
        if let Some(previous) = past.previous {
            vectorised(
                #[inline(always)]
                || {
                    for (shift, state) in shifts.chunks_exact_mut(n).zip(previous.chunks_exact(n)) {
                        for (value, row) in state.iter().zip(self.previous.chunks_exact(n)) {
                            shift.iter_mut().zip(row).for_each(|(sum, entry)| *sum += value * entry);
                        }
                    }
                },
            );
        }
        shifts
    }

    /// Transforms `noise` (`R×N`) into `states` (`R×N`), with `log q` in `log_density` (`R`); what [`Map::values`] of the blocks of
    /// particles were comes back.
    pub(super) fn forward(
        &self,
        shifts: &[f64],
        noise: &[f64],
        states: &mut [f64],
        log_density: &mut [f64],
    ) -> Vec<Lane> {
        let (n, rows) = (self.width, LANES * self.width);
        let each = self.layers.len() * n;
        let mut activations = vec![Lane::default(); log_density.len().div_ceil(LANES) * each];
        let start = -self.log_abs_det();
        let (mut values, mut next) = (vec![Lane::default(); n], vec![Lane::default(); n]);
        let blocks = noise.chunks(rows).zip(shifts.chunks(rows));
        let blocks = blocks.zip(states.chunks_mut(rows)).zip(log_density.chunks_mut(LANES));
        for ((((noise, shifts), states), log_density), kept) in blocks.zip(activations.chunks_mut(each)) {
            vectorised(
                #[inline(always)]
                || {
                    for (j, value) in values.iter_mut().enumerate() {
                        *value = Lane::gather(shifts, n, j);
                    }
                    for (i, row) in self.noise.matrix.chunks_exact(n).enumerate() {
                        let u = Lane::gather(noise, n, i);
                        values.iter_mut().zip(row).for_each(|(value, entry)| value.add_scaled(*entry, &u));
                    }
                    let mut log = Lane([start; LANES]);
                    for ((layer, bias), kept) in self.layers.iter().zip(kept.chunks_exact_mut(n)) {
                        bound(&values, kept, &mut log);
                        next.iter_mut().zip(bias).for_each(|(value, bias)| *value = Lane([*bias; LANES]));
                        for (z, row) in kept.iter().zip(layer.matrix.chunks_exact(n)) {
                            next.iter_mut().zip(row).for_each(|(value, entry)| value.add_scaled(*entry, z));
                        }
                        std::mem::swap(&mut values, &mut next);
                    }
                    values.iter().enumerate().for_each(|(j, value)| value.scatter(states, n, j));
                    log_density.iter_mut().zip(&log.0).for_each(|(into, log)| *into = *log);
                },
            );
        }
        activations
    }
}

/// So many factors of at most 2 have a product that is far from overflow.
const FACTORS: usize = 256;

/// `tanh a` of each, and from `log` the sum of `log(1 − tanh²a) = 2 (log 2 − |a| − log(1 + e^{−2|a|}))`.
#[inline(always)]
fn bound(values: &[Lane], bounded: &mut [Lane], log: &mut Lane) {
    for (values, bounded) in values.chunks(FACTORS).zip(bounded.chunks_mut(FACTORS)) {
        let (mut sizes, mut product) = (Lane::default(), Lane([1.0; LANES]));
        for (value, bounded) in values.iter().zip(bounded) {
            for lane in 0..LANES {
                let a = value.0[lane];
                let size = a.abs();
                let e = exp(-2.0 * size);
                let tanh = ((1.0 - e) / (1.0 + e)).copysign(a);
                // The exponential of NaN is none.
                bounded.0[lane] = if a.is_nan() { a } else { tanh };
                sizes.0[lane] += size;
                product.0[lane] *= 1.0 + e;
            }
        }
        let count = LN_2 * values.len() as f64;
        for lane in 0..LANES {
            log.0[lane] -= 2.0 * (count - sizes.0[lane] - ln(product.0[lane]));
        }
    }
}
