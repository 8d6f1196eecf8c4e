//! The transform of one time, backward: from states to the noise that would give them.

use faer::linalg::solvers::{PartialPivLu, SolveCore};
use faer::{Mat, MatRef};

use super::map::Map;

/// A log density that rounding may have moved by more than this is none.
const LOG_DENSITY_ERROR: f64 = 1e-4;

/// How many times the estimated rounding error a value must be inside or outside a bound to be taken for so.
const SAFETY: f64 = 16.0;

/// The matrices of a transform, factored once for all states.
#[derive(Debug, Clone)]
pub(super) struct Factored {
    log_abs_det: f64,
    noise: PartialPivLu<f64>,
    layers: Vec<PartialPivLu<f64>>,
}

impl Factored {
    /// Those of `map`, whose `log|det|` together are `log_abs_det`.
    pub(super) fn new(map: &Map, log_abs_det: f64) -> Self {
        let n = map.width;
        let factor = |matrix: &[f64]| MatRef::from_row_major_slice(matrix, n, n).partial_piv_lu();
        Factored {
            log_abs_det,
            noise: factor(&map.noise),
            layers: map.layers.iter().map(|(matrix, _)| factor(matrix)).collect(),
        }
    }
}

impl Map {
    /// The noise (`R×N`) and `log q` (`R`) of each state; −∞ where there is none, NaN where rounding hides whether there is.
    ///
    /// Each layer's inverse magnifies rounding errors, and atanh near ±1 does so without bound. So a first-order estimate of
    /// the error goes along: the derivative of what is recovered with respect to the state, times one unit of rounding.
    pub(super) fn inverse(
        &self,
        factored: &Factored,
        shifts: &[f64],
        states: &[f64],
        noise: &mut [f64],
        log_density: &mut [f64],
    ) {
        let n = self.width;
        let rows = states.chunks_exact(n).zip(shifts.chunks_exact(n)).zip(noise.chunks_exact_mut(n));
        for (((state, shift), noise), log_density) in rows.zip(log_density) {
            *log_density = self.invert(factored, state, shift, noise);
        }
    }

    fn invert(&self, factored: &Factored, state: &[f64], shift: &[f64], noise: &mut [f64]) -> f64 {
        let n = state.len();
        let (mut log_density, mut log_density_error) = (-factored.log_abs_det, 0.0);
        // The values of one layer, and beside them how each depends on a rounding error of each coordinate of the state.
        let mut values = Mat::zeros(n, n + 1);
        for (i, x) in state.iter().enumerate() {
            values[(i, 0)] = *x;
            values[(i, i + 1)] = f64::EPSILON * x.abs().max(1.0);
        }
        for ((_, bias), factors) in self.layers.iter().zip(&factored.layers).rev() {
            (0..n).for_each(|i| values[(i, 0)] -= bias[i]);
            factors.solve_transpose_in_place_with_conj(faer::Conj::No, values.as_mut());
            for i in 0..n {
                let (value, error) = (values[(i, 0)], SAFETY * error(&values, i));
                if value.abs() - error > 1.0 {
                    return f64::NEG_INFINITY;
                }
                let slope = (1.0 - value) * (1.0 + value);
                if value.is_nan() || error.is_nan() || value.abs() + error >= 1.0 {
                    return f64::NAN;
                }
                log_density -= slope.ln();
                log_density_error += 2.0 * value.abs() * error / slope;
                values[(i, 0)] = value.atanh();
                for j in 1..=n {
                    values[(i, j)] /= slope;
                }
            }
        }
        (0..n).for_each(|i| values[(i, 0)] -= shift[i]);
        factored.noise.solve_transpose_in_place_with_conj(faer::Conj::No, values.as_mut());
        for i in 0..n {
            let (value, error) = (values[(i, 0)], SAFETY * error(&values, i));
            if value + error < 0.0 || value - error > 1.0 {
                return f64::NEG_INFINITY;
            }
            // So near an edge of the cube that rounding decides on which side, and not a hair's breadth.
            let edge = value.min(1.0 - value).abs();
            let blunt = edge < error && error > LOG_DENSITY_ERROR;
            if !value.is_finite() || !error.is_finite() || blunt || error >= 0.5 {
                return f64::NAN;
            }
            noise[i] = value;
        }
        if log_density_error < LOG_DENSITY_ERROR { log_density } else { f64::NAN }
    }
}

/// The estimated rounding error of value `i`.
fn error(values: &Mat<f64>, i: usize) -> f64 {
    (1..values.ncols()).map(|j| values[(i, j)].abs()).sum()
}
