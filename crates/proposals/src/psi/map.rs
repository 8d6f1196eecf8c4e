//! The transform of one time, forward: from noise to states, with the log density along the way.

use motes_models::batch::by_widest_vectors;
use std::f64::consts::LN_2;

use motes_models::elementary::{exp, ln};

use crate::lanes::{LANES, Lane, add_times, set_times};

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

/// The transform of one time. Matrices are row-major; samples are rows, so they are applied from the right.
#[derive(Debug, Clone)]
pub(super) struct Map {
    pub(super) width: usize,
    /// `A`.
    pub(super) noise: Vec<f64>,
    /// `B`, `N×N`.
    pub(super) previous: Vec<f64>,
    /// `C`, `M×N`.
    pub(super) measurement: Vec<f64>,
    /// `W_ℓ` and `b_ℓ`.
    pub(super) layers: Vec<(Vec<f64>, Vec<f64>)>,
}

/// What densities, and their derivatives, need of the matrices that a transform is made of.
#[derive(Debug, Clone)]
pub(super) struct Inverses {
    /// Of `A`.
    pub(super) noise: Vec<f64>,
    /// Of each `W_ℓ`.
    pub(super) layers: Vec<Vec<f64>>,
    /// `log|det A| + Σ_ℓ log|det W_ℓ|`.
    pub(super) log_abs_det: f64,
}

impl Map {
    /// Inverts `A`, which is matrix 0, and the matrix of each layer `ℓ`, which is matrix `ℓ + 1`.
    ///
    /// # Errors
    /// The number of a matrix that has no inverse, and the logarithm of its absolute determinant.
    pub(super) fn inverses(&self) -> Result<Inverses, (usize, f64)> {
        let inverse = |number: usize, matrix: &[f64]| match invert(self.width, matrix) {
            (inverse, log_abs_det) if log_abs_det.is_finite() => Ok((inverse, log_abs_det)),
            (_, log_abs_det) => Err((number, log_abs_det)),
        };
        let (noise, of_noise) = inverse(0, &self.noise)?;
        let (mut layers, mut of_layers) = (Vec::with_capacity(self.layers.len()), 0.0);
        for (number, (matrix, _)) in (1..).zip(&self.layers) {
            let (layer, log_abs_det) = inverse(number, matrix)?;
            of_layers += log_abs_det;
            layers.push(layer);
        }
        Ok(Inverses { noise, layers, log_abs_det: of_noise + of_layers })
    }

    /// `C y_t`, `N`.
    pub(super) fn shift(&self, measurement: &[f64]) -> Vec<f64> {
        let mut shift = vec![0.0; self.width];
        for (value, row) in measurement.iter().zip(self.measurement.chunks_exact(self.width)) {
            shift.iter_mut().zip(row).for_each(|(sum, entry)| *sum += value * entry);
        }
        shift
    }

    /// Adds `B x_{t−1}` of each particle to its shift (`R×N` each); nothing at `t = 0`.
    pub(super) fn add_previous(&self, previous: Option<&[f64]>, shifts: &mut [f64]) {
        let (n, Some(previous)) = (self.width, previous) else { return };
        by_widest_vectors(
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

    /// Transforms `noise` (`R×N`) into `states` (`R×N`), with `log q` in the places (`R`) that come with the `log|det|` of all matrices;
    /// the outputs of all layers before their products come back, block of particles by block.
    pub(super) fn forward(
        &self,
        shifts: &[f64],
        noise: &[f64],
        states: &mut [f64],
        log_density: Option<(f64, &mut [f64])>,
    ) -> Vec<Lane> {
        let (n, rows) = (self.width, LANES * self.width);
        let each = self.layers.len() * n;
        let mut activations = vec![Lane::default(); (states.len() / n).div_ceil(LANES) * each];
        let (log_abs_det, mut places) = match log_density {
            Some((log_abs_det, places)) => {
                assert_eq!(places.len() * n, states.len(), "one log density for each particle");
                (log_abs_det, Some(places.chunks_mut(LANES)))
            }
            None => (0.0, None),
        };
        let (mut values, mut uniform) = (vec![Lane::default(); n], vec![Lane::default(); n]);
        let blocks = noise.chunks(rows).zip(shifts.chunks(rows)).zip(states.chunks_mut(rows));
        for (((noise, shifts), states), kept) in blocks.zip(activations.chunks_mut(each)) {
            let mut place = places.as_mut().and_then(Iterator::next);
            by_widest_vectors(
                #[inline(always)]
                || {
                    uniform.iter_mut().enumerate().for_each(|(i, u)| *u = Lane::gather(noise, n, i));
                    values.iter_mut().enumerate().for_each(|(j, value)| *value = Lane::gather(shifts, n, j));
                    add_times(&mut values, &uniform, &self.noise);
                    let mut log = Lane([-log_abs_det; LANES]);
                    for ((matrix, bias), kept) in self.layers.iter().zip(kept.chunks_exact_mut(n)) {
                        match &place {
                            Some(_) => bound_with_slope(&values, kept, &mut log),
                            None => bound(&values, kept, |_, _| ()),
                        }
                        set_times(&mut values, bias, kept, matrix);
                    }
                    values.iter().enumerate().for_each(|(j, value)| value.scatter(states, n, j));
                    if let Some(place) = &mut place {
                        place.iter_mut().zip(&log.0).for_each(|(into, log)| *into = *log);
                    }
                },
            );
        }
        activations
    }
}

/// So many factors of at most 2 have a product that is far from overflow.
const FACTORS: usize = 256;

/// Numbers whose tanh is taken at once: so many that a compiler makes vectors of a loop over them. A shorter one it writes out first, and then
/// gathers one number of each of several lanes.
const AT_ONCE: usize = 2 * LANES;

/// Makes numbers their tanh, and returns `e^{−2|a|}`, which it takes on the way.
#[inline(always)]
fn tanh(a: &mut [f64; AT_ONCE]) -> [f64; AT_ONCE] {
    const SIGN: u64 = 1 << 63;
    let mut e = [0.0; AT_ONCE];
    for i in 0..AT_ONCE {
        e[i] = exp(-2.0 * a[i].abs());
        let size = (1.0 - e[i]) / (1.0 + e[i]);
        let tanh = f64::from_bits(size.to_bits() | (a[i].to_bits() & SIGN));
        // The exponential of NaN is none.
        a[i] = if a[i].is_nan() { a[i] } else { tanh };
    }
    e
}

/// `tanh a` of each; `see` gets each `a` with its `e^{−2|a|}`.
#[inline(always)]
fn bound(values: &[Lane], bounded: &mut [Lane], mut see: impl FnMut(&Lane, &Lane)) {
    for (values, bounded) in values.chunks(2).zip(bounded.chunks_mut(2)) {
        let mut a = [0.0; AT_ONCE];
        let (lanes, _) = a.as_chunks_mut::<LANES>();
        lanes.iter_mut().zip(values).for_each(|(lane, value)| *lane = value.0);
        let e = tanh(&mut a);
        let (lanes, _) = a.as_chunks::<LANES>();
        bounded.iter_mut().zip(lanes).for_each(|(bounded, lane)| bounded.0 = *lane);
        let (e, _) = e.as_chunks::<LANES>();
        values.iter().zip(e).for_each(|(value, e)| see(value, &Lane(*e)));
    }
}

/// `tanh a` of each, and from `log` the sum of `log(1 − tanh²a) = 2 (log 2 − |a| − log(1 + e^{−2|a|}))`.
#[inline(always)]
fn bound_with_slope(values: &[Lane], bounded: &mut [Lane], log: &mut Lane) {
    for (values, bounded) in values.chunks(FACTORS).zip(bounded.chunks_mut(FACTORS)) {
        let (mut sizes, mut product) = (Lane::default(), Lane([1.0; LANES]));
        bound(
            values,
            bounded,
            #[inline(always)]
            |value, e| {
                for lane in 0..LANES {
                    sizes.0[lane] += value.0[lane].abs();
                    product.0[lane] *= 1.0 + e.0[lane];
                }
            },
        );
        let count = LN_2 * values.len() as f64;
        for lane in 0..LANES {
            log.0[lane] -= 2.0 * (count - sizes.0[lane] - ln(product.0[lane]));
        }
    }
}
