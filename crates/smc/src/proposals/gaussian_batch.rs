//! Gaussians with a mean and a covariance of their own for each particle.

use motes_models::batch::particles_by_stream;
use motes_models::{Stream, fill_standard_normal};

use crate::proposal::Conditional;

/// `N(μ_k, L_k L_kᵀ)` for each of `R` particles; what a guided proposal of one's own, or of a learned Gaussian family, conditions to.
#[derive(Debug, Clone, Default)]
pub struct GaussianBatch {
    width: usize,
    means: Vec<f64>,
    lowers: Vec<f64>,
    noise: Vec<f64>,
}

impl GaussianBatch {
    /// Takes means (`R×N`, row-major) and lower Cholesky factors (`R` of them, each `N×N` column-major).
    ///
    /// # Panics
    /// If the two do not hold the same number of whole particles of `width` coordinates.
    pub fn new(width: usize, means: Vec<f64>, lowers: Vec<f64>) -> Self {
        assert!(width > 0 && means.len().is_multiple_of(width), "whole rows of `width` coordinates");
        assert_eq!(means.len() * width, lowers.len(), "one mean and one factor for each particle");
        GaussianBatch { width, means, lowers, noise: Vec::new() }
    }

    /// The places of the means (`R×N`) and factors (`R·N·N`, each column-major) of `particles` particles, to be filled; memory is used again.
    pub fn places(&mut self, width: usize, particles: usize) -> (&mut [f64], &mut [f64]) {
        self.width = width;
        self.means.resize(particles * width, 0.0);
        self.lowers.resize(particles * width * width, 0.0);
        (&mut self.means, &mut self.lowers)
    }

    /// The mean of each particle, `R×N`.
    pub fn means(&self) -> &[f64] {
        &self.means
    }

    /// Column `j` of the factor of particle `row`, from the diagonal down.
    fn column(&self, row: usize, j: usize) -> &[f64] {
        let n = self.width;
        &self.lowers[row * n * n + j * n + j..row * n * n + (j + 1) * n]
    }

    /// All factors, one after another (`R·N·N`, each column-major).
    pub fn into_lowers(self) -> Vec<f64> {
        self.lowers
    }

    /// `x = μ + L ε` for standard normal `noise` (`R×N`).
    ///
    /// # Panics
    /// If `states` are not as many as the means.
    pub fn transform(&self, noise: &[f64], states: &mut [f64]) {
        let n = self.width;
        states.copy_from_slice(&self.means);
        for (row, (state, epsilon)) in states.chunks_exact_mut(n).zip(noise.chunks_exact(n)).enumerate() {
            for (j, epsilon) in epsilon.iter().enumerate() {
                for (state, entry) in state[j..].iter_mut().zip(self.column(row, j)) {
                    *state += entry * epsilon;
                }
            }
        }
    }

    /// `log q = −½ εᵀε − Σᵢ log Lᵢᵢ − (N/2) log 2π` of what [`GaussianBatch::transform`] makes of `noise`.
    pub fn log_density_of_noise(&self, noise: &[f64], log_density: &mut [f64]) {
        let rows = noise.chunks_exact(self.width).zip(log_density);
        for (row, (epsilon, log_density)) in rows.enumerate() {
            *log_density = self.log_normalizer(row) - 0.5 * epsilon.iter().map(|e| e * e).sum::<f64>();
        }
    }

    /// `−Σᵢ log Lᵢᵢ − (N/2) log 2π`.
    fn log_normalizer(&self, row: usize) -> f64 {
        let half_log_determinant: f64 = (0..self.width).map(|j| self.column(row, j)[0].ln()).sum();
        -half_log_determinant - 0.5 * self.width as f64 * std::f64::consts::TAU.ln()
    }
}

impl Conditional for GaussianBatch {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let mut noise = std::mem::take(&mut self.noise);
        noise.resize(states.len(), 0.0);
        for (stream, noise) in particles_by_stream(streams, &mut noise, self.width, log_density.len()) {
            fill_standard_normal(stream, noise);
        }
        self.transform(&noise, states);
        self.log_density_of_noise(&noise, log_density);
        self.noise = noise;
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        let n = self.width;
        let mut deviation = std::mem::take(&mut self.noise);
        deviation.resize(n, 0.0);
        for (row, log_density) in log_density.iter_mut().enumerate() {
            let at = row * n..(row + 1) * n;
            for ((d, x), mean) in deviation.iter_mut().zip(&states[at.clone()]).zip(&self.means[at]) {
                *d = x - mean;
            }
            // L⁻¹ d, column by column from the first on.
            for j in 0..n {
                let column = self.column(row, j);
                deviation[j] /= column[0];
                let whitened = deviation[j];
                for (d, entry) in deviation[j + 1..].iter_mut().zip(&column[1..]) {
                    *d -= entry * whitened;
                }
            }
            *log_density = self.log_normalizer(row) - 0.5 * deviation.iter().map(|d| d * d).sum::<f64>();
        }
        self.noise = deviation;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motes_models::{Gaussian, Seed};

    #[test]
    fn the_density_along_a_sample_is_that_at_its_point_and_that_of_a_dense_gaussian() {
        let covariance = faer::mat![[1.0, 0.4, 0.1], [0.4, 0.8, -0.2], [0.1, -0.2, 0.5]];
        let dense = Gaussian::new("Σ", vec![1.0, 0.0, -1.0], covariance).unwrap();
        let lower: Vec<f64> = (0..9).map(|i| dense.lower()[(i % 3, i / 3)]).collect();
        let mut batch = GaussianBatch::new(3, dense.mean().repeat(4), lower.repeat(4));
        let mut streams = Seed::from_u64(1).streams(2);
        let (mut states, mut along, mut at) = (vec![0.0; 12], vec![0.0; 4], vec![0.0; 4]);
        batch.sample(&mut streams, &mut states, &mut along);
        batch.log_density(&states, &mut at);
        for row in 0..4 {
            let expected = dense.log_density(&states[row * 3..(row + 1) * 3]);
            assert!((along[row] - expected).abs() < 1e-12 && (at[row] - expected).abs() < 1e-12);
        }
    }
}
