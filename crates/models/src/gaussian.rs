//! A Gaussian with a dense covariance, factored once.

use faer::{Mat, MatRef, Side};

use crate::batch::{LANES, TileMatrix, load, squared_norms, store, with_noise, with_scratch};
use crate::{CovarianceFault, ModelError, Stream, fill_standard_normal};

/// `ln 2π`.
pub const LN_2PI: f64 = 1.837_877_066_409_345_3;

/// `N(μ, Σ)` on ℝᴺ with `Σ = L Lᵀ`.
///
/// Evaluating and drawing allocate nothing: the density is taken through `L⁻¹`, formed once.
#[derive(Debug, Clone)]
pub struct Gaussian {
    mean: Vec<f64>,
    covariance: Mat<f64>,
    lower: Mat<f64>,
    inverse_lower: Mat<f64>,
    lower_tiles: TileMatrix,
    inverse_tiles: TileMatrix,
    log_normalizer: f64,
}

impl Gaussian {
    /// Takes a mean (`N`) and a symmetric positive-definite covariance (`N×N`); `name` is what errors call it.
    ///
    /// # Errors
    /// [`ModelError::Covariance`] if the covariance is of another shape, not finite, not symmetric or not positive definite.
    /// Symmetric means up to 1e-12 of its largest entry. A covariance is never changed to make it fit.
    ///
    /// [`ModelError::Parameter`] if the mean is empty or not finite.
    pub fn new(name: &'static str, mean: Vec<f64>, covariance: Mat<f64>) -> Result<Self, ModelError> {
        if mean.is_empty() || mean.iter().any(|value| !value.is_finite()) {
            return Err(ModelError::Parameter {
                name: "the mean of a Gaussian",
                value: format!("{mean:?}"),
                expected: "one or more finite numbers",
            });
        }
        let lower = factor(name, covariance.as_ref(), mean.len())?;
        let width = mean.len();
        let mut inverse_lower = Mat::<f64>::identity(width, width);
        lower.as_ref().solve_lower_triangular_in_place(inverse_lower.as_mut());
        let half_log_determinant: f64 = (0..width).map(|i| lower[(i, i)].ln()).sum();
        let log_normalizer = -half_log_determinant - 0.5 * width as f64 * LN_2PI;
        Ok(Gaussian {
            mean,
            covariance,
            lower_tiles: TileMatrix::new(lower.as_ref()),
            inverse_tiles: TileMatrix::new(inverse_lower.as_ref()),
            lower,
            inverse_lower,
            log_normalizer,
        })
    }

    /// `μ`.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// `Σ`.
    pub fn covariance(&self) -> MatRef<'_, f64> {
        self.covariance.as_ref()
    }

    /// `L`, lower triangular with `L Lᵀ = Σ`.
    pub fn lower(&self) -> MatRef<'_, f64> {
        self.lower.as_ref()
    }

    /// `−Σᵢ log Lᵢᵢ − (N/2) log 2π`, the logarithm of the density at its mean.
    pub fn log_normalizer(&self) -> f64 {
        self.log_normalizer
    }

    /// `log N(x; μ, Σ) = −½‖L⁻¹(x − μ)‖² − Σᵢ log Lᵢᵢ − (N/2) log 2π`.
    pub fn log_density(&self, x: &[f64]) -> f64 {
        self.log_density_of(|j| x[j] - self.mean[j])
    }

    /// The same density with the deviation `x − μ` given by coordinate, for a mean that moves.
    pub fn log_density_of(&self, deviation: impl Fn(usize) -> f64) -> f64 {
        self.log_normalizer - 0.5 * self.squared_distance(deviation)
    }

    /// The density of each row of `states` (`K×N`), into `out` (`K`).
    pub fn log_densities(&self, states: &[f64], out: &mut [f64]) {
        let n = self.mean.len();
        with_scratch(2 * n * LANES, |scratch| {
            let (tile, whitened) = scratch.split_at_mut(n * LANES);
            for (states, out) in states.chunks(n * LANES).zip(out.chunks_mut(LANES)) {
                load(states, n, tile);
                for (row, mean) in tile.as_chunks_mut::<LANES>().0.iter_mut().zip(&self.mean) {
                    row.iter_mut().for_each(|value| *value -= mean);
                }
                self.tile_log_density(tile, whitened, out);
            }
        });
    }

    /// `log N(d; 0, Σ)` of each lane of a tile of deviations (`N × LANES`), for as many lanes as `out` has places.
    ///
    /// `whitened` is scratch of the tile's size. It holds `L⁻¹ d` afterwards.
    pub fn tile_log_density(&self, deviations: &[f64], whitened: &mut [f64], out: &mut [f64]) {
        self.inverse_tiles.times(deviations, whitened);
        let mut squares = [0.0; LANES];
        squared_norms(whitened, &mut squares);
        for (out, square) in out.iter_mut().zip(squares) {
            *out = self.log_normalizer - 0.5 * square;
        }
    }

    /// Adds `L ε` to each lane of a tile (`N × LANES`), given a tile of noise `ε`.
    pub fn tile_add_deviation(&self, noise: &[f64], tile: &mut [f64]) {
        self.lower_tiles.times_add(noise, tile);
    }

    /// Draws a row `x = μ + L ε` for each place in `states` (`K×N`); the rows are split evenly over `streams`, in order.
    ///
    /// # Panics
    /// If `K` is not a multiple of the number of streams.
    pub fn samples(&self, streams: &mut [Stream], states: &mut [f64]) {
        let n = self.mean.len();
        with_scratch(n * LANES, |tile| {
            with_noise(streams, n, states.len() / n, fill_standard_normal, |particles, noise| {
                for (row, mean) in tile.as_chunks_mut::<LANES>().0.iter_mut().zip(&self.mean) {
                    row.fill(*mean);
                }
                self.tile_add_deviation(noise, tile);
                store(tile, n, &mut states[particles.start * n..particles.end * n]);
            });
        });
    }

    /// `‖L⁻¹ d‖²`, the squared Mahalanobis distance of a deviation `d`.
    fn squared_distance(&self, deviation: impl Fn(usize) -> f64) -> f64 {
        let width = self.mean.len();
        let squares = |whitened: &mut [f64]| {
            self.whiten(deviation, whitened);
            whitened.iter().map(|value| value * value).sum()
        };
        // No allocation in the sizes that filters are used in.
        match width {
            0..=64 => squares(&mut [0.0; 64][..width]),
            _ => squares(&mut vec![0.0; width]),
        }
    }

    /// Adds `L⁻¹ d` to `whitened`, column by column, so that each coordinate of `d` is asked for once.
    fn whiten(&self, deviation: impl Fn(usize) -> f64, whitened: &mut [f64]) {
        for j in 0..whitened.len() {
            let d = deviation(j);
            let column = &self.inverse_lower.col_as_slice(j)[j..];
            for (sum, entry) in whitened[j..].iter_mut().zip(column) {
                *sum += entry * d;
            }
        }
    }

    /// `∂ log N / ∂x = −Σ⁻¹ d` for the deviation `d = x − μ`, into `gradient` (`N`).
    pub fn gradient(&self, deviation: impl Fn(usize) -> f64, gradient: &mut [f64]) {
        gradient.fill(0.0);
        self.whiten(deviation, gradient);
        // −L⁻ᵀ w: row j reads only what stands at j and below, so that the result can take its place.
        for j in 0..gradient.len() {
            let column = &self.inverse_lower.col_as_slice(j)[j..];
            gradient[j] = -column.iter().zip(&gradient[j..]).map(|(entry, w)| entry * w).sum::<f64>();
        }
    }

    /// Draws `x = μ + L ε` with `ε ~ N(0, I)` into `x` (`N`).
    pub fn sample(&self, stream: &mut Stream, x: &mut [f64]) {
        self.sample_deviation(stream, x);
        for (x, mean) in x.iter_mut().zip(&self.mean) {
            *x += mean;
        }
    }

    /// Draws `L ε` into `x` (`N`), for a mean that moves.
    pub fn sample_deviation(&self, stream: &mut Stream, x: &mut [f64]) {
        fill_standard_normal(stream, x);
        // From the last row up, each row reads only the ε that no later row needs any more.
        for i in (0..x.len()).rev() {
            x[i] = (0..=i).map(|j| self.lower[(i, j)] * x[j]).sum();
        }
    }
}

/// The lower Cholesky factor of a covariance of size `expected`, after checking that it is one.
pub(crate) fn factor(
    name: &'static str,
    covariance: MatRef<'_, f64>,
    expected: usize,
) -> Result<Mat<f64>, ModelError> {
    let fail = |fault| Err(ModelError::Covariance { name, fault });
    let (rows, columns) = covariance.shape();
    if rows != expected || columns != expected {
        return fail(CovarianceFault::Shape { rows, columns, expected });
    }
    let mut largest: f64 = 0.0;
    for row in 0..rows {
        for column in 0..columns {
            let value = covariance[(row, column)];
            if !value.is_finite() {
                return fail(CovarianceFault::NotFinite { row, column, value });
            }
            largest = largest.max(value.abs());
        }
    }
    for row in 0..rows {
        for column in 0..row {
            let difference = (covariance[(row, column)] - covariance[(column, row)]).abs();
            if difference > 1e-12 * largest {
                return fail(CovarianceFault::NotSymmetric { row, column, difference });
            }
        }
    }
    match covariance.llt(Side::Lower) {
        Ok(factored) => Ok(factored.L().to_owned()),
        Err(_) => {
            let smallest_eigenvalue = covariance
                .self_adjoint_eigenvalues(Side::Lower)
                .ok()
                .and_then(|eigenvalues| eigenvalues.first().copied())
                .unwrap_or(f64::NAN);
            fail(CovarianceFault::NotPositiveDefinite { smallest_eigenvalue })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::mat;

    fn example() -> Gaussian {
        Gaussian::new("Σ", vec![1.0, -2.0], mat![[2.0, 0.6], [0.6, 1.0]]).unwrap()
    }

    #[test]
    fn density_is_that_of_the_formula() {
        let determinant: f64 = 2.0 - 0.36;
        // (0.5, 1.5) Σ⁻¹ (0.5, 1.5)ᵀ with Σ⁻¹ = [[1, −0.6], [−0.6, 2]] / 1.64
        let quadratic = (0.25 - 2.0 * 0.6 * 0.75 + 2.0 * 2.25) / determinant;
        let expected = -0.5 * quadratic - 0.5 * determinant.ln() - LN_2PI;
        assert!((example().log_density(&[1.5, -0.5]) - expected).abs() < 1e-14);
    }

    #[test]
    fn gradient_is_the_slope_of_the_density() {
        let gaussian = example();
        let (x, h) = ([0.3, 0.7], 1e-6);
        let mut gradient = [0.0; 2];
        gaussian.gradient(|j| x[j] - gaussian.mean()[j], &mut gradient);
        for i in 0..2 {
            let (mut up, mut down) = (x, x);
            up[i] += h;
            down[i] -= h;
            let slope = (gaussian.log_density(&up) - gaussian.log_density(&down)) / (2.0 * h);
            assert!((slope - gradient[i]).abs() < 1e-8);
        }
    }

    #[test]
    fn a_matrix_that_is_no_covariance_is_refused_with_the_reason() {
        let error = |matrix| Gaussian::new("Σ", vec![0.0; 2], matrix).unwrap_err().to_string();
        assert_eq!(error(Mat::zeros(2, 3)), "Σ is 2×3; it must be 2×2");
        assert_eq!(
            error(mat![[1.0, 0.5], [0.4, 1.0]]),
            "Σ differs from its transpose by 1.00e-1 at row 1, column 0; it must be symmetric"
        );
        assert!(error(mat![[1.0, 2.0], [2.0, 1.0]]).contains("smallest eigenvalue -1.00e0"));
        assert!(error(mat![[f64::NAN, 0.0], [0.0, 1.0]]).contains("NaN at row 0, column 0"));
    }
}
