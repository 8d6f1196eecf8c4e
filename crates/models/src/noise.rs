//! The three noise families of the experiments, all with mean 0 and variance σ².

use rand::RngExt;
use rand_distr::{Exp1, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::batch::{LANES, squared_norms};
use crate::equations::{Distribution, Exponential, Normal, Scalar, Uniform};
use crate::gaussian::LN_2PI;
use crate::{Stream, fill_standard_exponential, fill_standard_normal, fill_uniform};

/// A scalar noise with mean 0 and variance σ²; vectors have independent coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Noise {
    /// `N(0, σ²)`.
    Gaussian,
    /// `σ (E − 1)` with `E ~ Exp(1)`: bounded below by −σ.
    Exponential,
    /// Uniform on `±σ√3`.
    Uniform,
}

impl Noise {
    /// Draws one value with standard deviation `sigma`.
    pub fn sample(self, sigma: f64, stream: &mut Stream) -> f64 {
        let unit: f64 = match self {
            Noise::Gaussian => stream.sample(StandardNormal),
            Noise::Exponential => stream.sample::<f64, _>(Exp1) - 1.0,
            Noise::Uniform => (2.0 * stream.random::<f64>() - 1.0) * 3.0_f64.sqrt(),
        };
        sigma * unit
    }

    /// Fills `out` with independent values of standard deviation 1, in bulk.
    pub(crate) fn fill_unit(self, stream: &mut Stream, out: &mut [f64]) {
        match self {
            Noise::Gaussian => fill_standard_normal(stream, out),
            Noise::Exponential => {
                fill_standard_exponential(stream, out);
                out.iter_mut().for_each(|value| *value -= 1.0);
            }
            Noise::Uniform => {
                fill_uniform(stream, out);
                out.iter_mut().for_each(|value| *value = (2.0 * *value - 1.0) * 3.0_f64.sqrt());
            }
        }
    }

    /// `log p` of each lane of a tile of independent coordinates (`width × LANES`), each with standard deviation `sigma`.
    pub(crate) fn tile_log_density(self, sigma: f64, tile: &[f64], out: &mut [f64; LANES]) {
        let width = (tile.len() / LANES) as f64;
        let normalizer = -width * sigma.ln();
        match self {
            Noise::Gaussian => {
                squared_norms(tile, out);
                let (scale, normalizer) = (-0.5 / (sigma * sigma), normalizer - 0.5 * LN_2PI * width);
                out.iter_mut().for_each(|sum| *sum = *sum * scale + normalizer);
            }
            Noise::Exponential | Noise::Uniform => {
                out.fill(normalizer);
                for row in tile.as_chunks::<LANES>().0 {
                    for (sum, value) in out.iter_mut().zip(row) {
                        *sum += self.unit_log_density(value / sigma);
                    }
                }
            }
        }
    }

    /// `log p(v)` for standard deviation `sigma`; −∞ outside the support.
    ///
    /// - Gaussian: `−v²/(2σ²) − log σ − ½ log 2π`
    /// - Exponential: `−(v/σ + 1) − log σ` for `v ≥ −σ`
    /// - Uniform: `−log(2√3 σ)` for `|v| ≤ √3 σ`
    #[inline]
    pub fn log_density(self, sigma: f64, v: f64) -> f64 {
        let unit = v / sigma;
        self.unit_log_density(unit) - sigma.ln()
    }

    #[inline]
    fn unit_log_density(self, unit: f64) -> f64 {
        match self {
            Noise::Gaussian => -0.5 * unit * unit - 0.5 * LN_2PI,
            Noise::Exponential if unit >= -1.0 => -(unit + 1.0),
            Noise::Uniform if unit * unit <= 3.0 => -(2.0 * 3.0_f64.sqrt()).ln(),
            Noise::Exponential | Noise::Uniform => f64::NEG_INFINITY,
        }
    }

    /// `log p` of a vector of independent coordinates, each with standard deviation `sigma`.
    #[inline]
    pub fn log_density_of_all(self, sigma: f64, values: impl Iterator<Item = f64>) -> f64 {
        let mut count = 0.0;
        let values = values.inspect(|_| count += 1.0);
        let sum: f64 = match self {
            // The common family, written out so that the loop is one multiplication and one addition.
            Noise::Gaussian => {
                let squares = values.map(|v| v * v).sum::<f64>();
                -0.5 * squares / (sigma * sigma) - 0.5 * LN_2PI * count
            }
            Noise::Exponential | Noise::Uniform => values.map(|v| self.unit_log_density(v / sigma)).sum(),
        };
        sum - count * sigma.ln()
    }

    /// The distribution of `location + v` where `v` has standard deviation `sigma`.
    #[inline(always)]
    pub(crate) fn around<S: Scalar>(self, sigma: f64, location: S) -> Distribution<S> {
        match self {
            Noise::Gaussian => Distribution::Normal(Normal { mean: location, sd: S::from(sigma) }),
            Noise::Exponential => {
                Distribution::Exponential(Exponential { origin: location - sigma, mean: S::from(sigma) })
            }
            Noise::Uniform => {
                let half = sigma * 3.0_f64.sqrt();
                Distribution::Uniform(Uniform { low: location - half, high: location + half })
            }
        }
    }

    /// `∂ log p / ∂v` inside the support (0 outside, where the density is flat at −∞).
    #[inline]
    pub fn gradient(self, sigma: f64, v: f64) -> f64 {
        match self {
            Noise::Gaussian => -v / (sigma * sigma),
            Noise::Exponential if v >= -sigma => -1.0 / sigma,
            Noise::Exponential | Noise::Uniform => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seed;

    const FAMILIES: [Noise; 3] = [Noise::Gaussian, Noise::Exponential, Noise::Uniform];

    #[test]
    fn drawn_noise_has_mean_zero_and_the_given_variance() {
        let (sigma, count) = (1.7, 200_000);
        for noise in FAMILIES {
            let mut stream = Seed::from_u64(5).child("noise").stream();
            let draws: Vec<f64> = (0..count).map(|_| noise.sample(sigma, &mut stream)).collect();
            let n = count as f64;
            let mean = draws.iter().sum::<f64>() / n;
            let squares: Vec<f64> = draws.iter().map(|v| v * v / (sigma * sigma)).collect();
            let variance = squares.iter().sum::<f64>() / n;
            let spread = (squares.iter().map(|s| (s - variance).powi(2)).sum::<f64>() / n / n).sqrt();
            assert!((mean / (sigma / n.sqrt())).abs() < 4.0, "{noise:?} mean {mean}");
            assert!(((variance - 1.0) / spread).abs() < 4.0, "{noise:?} variance {variance}");
        }
    }

    #[test]
    fn densities_integrate_to_one_with_the_right_moments() {
        let (sigma, step) = (1.3, 1e-3);
        for noise in FAMILIES {
            let (mut mass, mut mean, mut variance) = (0.0, 0.0, 0.0);
            for i in -13_000..40_000 {
                let v = (i as f64 + 0.5) * step;
                let p = noise.log_density(sigma, v).exp() * step;
                mass += p;
                mean += p * v;
                variance += p * v * v;
            }
            assert!((mass - 1.0).abs() < 1e-3, "{noise:?} mass {mass}");
            assert!(mean.abs() < 2e-3, "{noise:?} mean {mean}");
            assert!((variance / (sigma * sigma) - 1.0).abs() < 2e-3, "{noise:?} variance {variance}");
        }
    }

    #[test]
    fn a_vector_is_the_sum_of_its_coordinates_and_its_slope_is_the_gradient() {
        let (sigma, h) = (0.8, 1e-6);
        for noise in FAMILIES {
            let values = [0.1, -0.4, 0.9];
            let sum: f64 = values.iter().map(|&v| noise.log_density(sigma, v)).sum();
            assert!((noise.log_density_of_all(sigma, values.iter().copied()) - sum).abs() < 1e-13);
            for v in values {
                let slope = (noise.log_density(sigma, v + h) - noise.log_density(sigma, v - h)) / (2.0 * h);
                assert!((slope - noise.gradient(sigma, v)).abs() < 1e-8, "{noise:?} at {v}");
            }
        }
    }

    #[test]
    fn outside_the_support_is_impossible() {
        assert_eq!(Noise::Exponential.log_density(2.0, -2.1), f64::NEG_INFINITY);
        assert_eq!(Noise::Uniform.log_density(2.0, 3.6), f64::NEG_INFINITY);
        let values = [0.0, -2.1];
        assert_eq!(Noise::Exponential.log_density_of_all(2.0, values.into_iter()), f64::NEG_INFINITY);
    }
}
