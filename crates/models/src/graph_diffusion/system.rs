//! A graph-diffusion system and how it is built.

use faer::{Mat, MatRef};

use super::config::{Drift, GraphDiffusionConfig};
use crate::batch::TileMatrix;
use crate::error::check_matrix;
use crate::{Gaussian, LinearGaussian, ModelError, Noise, RandomGeometricGraph, Stream};

/// `x_t = φ(A x_{t−1}) + v_t`, `y_t = C x_t + w_t`, `x_0 ~ N(1, I)`.
///
/// `A` is the adjacency matrix of a random geometric graph, with spectral norm 1. `C` is `[I_M, I_{M×(N−M)}]` divided by its
/// spectral norm. The noises have covariance `σ²I`. This is the system of the paper's section "Numerical Experiments".
#[derive(Debug, Clone)]
pub struct GraphDiffusion {
    pub(super) adjacency: Mat<f64>,
    pub(super) measurement_matrix: Mat<f64>,
    pub(super) diffuse: TileMatrix,
    pub(super) measure: TileMatrix,
    pub(super) drift: Drift,
    pub(super) noise: Noise,
    pub(super) state_sigma: f64,
    pub(super) measurement_sigma: f64,
    pub(super) state_covariance: Mat<f64>,
    pub(super) measurement_covariance: Mat<f64>,
    pub(super) initial: Gaussian,
}

impl GraphDiffusion {
    /// Draws the graph and builds the system on it.
    ///
    /// # Errors
    /// As [`RandomGeometricGraph::draw`] and [`GraphDiffusion::on_graph`].
    pub fn random(config: &GraphDiffusionConfig, stream: &mut Stream) -> Result<Self, ModelError> {
        let graph = RandomGeometricGraph::draw(config.state_dim, config.neighbours, stream)?;
        GraphDiffusion::on_graph(config, graph.adjacency())
    }

    /// Builds the system on a given matrix `A` (`N×N`).
    ///
    /// # Errors
    /// [`ModelError::Shape`] or [`ModelError::NotFiniteEntry`] for `A`; [`ModelError::Parameter`] if `M` is not in `N/2 ..= N` and
    /// positive, or the SNR is not finite.
    pub fn on_graph(config: &GraphDiffusionConfig, adjacency: MatRef<'_, f64>) -> Result<Self, ModelError> {
        let (n, m) = (config.state_dim, config.measurement_dim);
        check_matrix("the diffusion matrix A", adjacency, n, n)?;
        if m == 0 || m > n || 2 * m < n {
            return Err(ModelError::Parameter {
                name: "number of measured coordinates M",
                value: format!("{m} for N = {n}"),
                expected: "positive, at most N and at least N/2",
            });
        }
        let sigma = (n as f64 / 10_f64.powf(config.snr_db / 10.0)).sqrt();
        if !(sigma.is_finite() && sigma > 0.0) {
            return Err(ModelError::Parameter {
                name: "signal-to-noise ratio in dB",
                value: config.snr_db.to_string(),
                expected: "a finite number (with a finite, positive noise variance)",
            });
        }
        // Rows of [I, I'] are e_i + e_{M+i} for i < N − M and e_i else, so the norm is √2 if any overlap.
        let norm = if n > m { 2.0_f64.sqrt() } else { 1.0 };
        let measurement_matrix =
            Mat::from_fn(m, n, |i, j| if j == i || j == m + i { 1.0 / norm } else { 0.0 });
        let scaled_identity = |size, scale| Mat::from_fn(size, size, |i, j| if i == j { scale } else { 0.0 });
        Ok(GraphDiffusion {
            diffuse: TileMatrix::new(adjacency),
            measure: TileMatrix::new(measurement_matrix.as_ref()),
            adjacency: adjacency.to_owned(),
            measurement_matrix,
            drift: config.drift,
            noise: config.noise,
            state_sigma: sigma,
            measurement_sigma: sigma,
            state_covariance: scaled_identity(n, sigma * sigma),
            measurement_covariance: scaled_identity(m, sigma * sigma),
            initial: Gaussian::new("covariance of x_0", vec![1.0; n], Mat::identity(n, n))?,
        })
    }

    /// The same system with another noise family of the same moments: what a filter that assumes Gaussian
    /// densities believes, for instance.
    #[must_use]
    pub fn with_noise(&self, noise: Noise) -> Self {
        GraphDiffusion { noise, ..self.clone() }
    }

    /// `A` (`N×N`).
    pub fn adjacency(&self) -> MatRef<'_, f64> {
        self.adjacency.as_ref()
    }

    /// The linear Gaussian model with this system's matrices and second moments, for exact inference.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] unless `φ` is the identity.
    pub fn moment_matched(&self) -> Result<LinearGaussian, ModelError> {
        if self.drift != Drift::Identity {
            return Err(ModelError::Parameter {
                name: "drift",
                value: format!("{:?}", self.drift),
                expected: "Identity, for a linear model",
            });
        }
        LinearGaussian::new(
            self.initial.clone(),
            self.adjacency.clone(),
            self.state_covariance.clone(),
            self.measurement_matrix.clone(),
            self.measurement_covariance.clone(),
        )
    }

    /// `φ(A x)ᵢ`.
    #[inline]
    pub(super) fn diffused(&self, i: usize, previous: &[f64]) -> f64 {
        self.drift.apply(self.diffuse.row_times(i, previous))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AdditiveGaussian, Seed, StateSpaceModel};

    #[test]
    fn constants_are_those_of_the_protocol() {
        let config = GraphDiffusionConfig::new(10);
        let system = GraphDiffusion::random(&config, &mut Seed::from_u64(1).stream()).unwrap();
        assert_eq!((system.state_dim(), system.measurement_dim()), (10, 8));
        assert!((system.transition_covariance()[(3, 3)] - 10.0 / 10_f64.powf(0.5)).abs() < 1e-12);
        let c = system.measurement_matrix();
        assert!((c[(0, 8)] - 0.5_f64.sqrt()).abs() < 1e-15 && c[(2, 8)] == 0.0);
        let norm = c.singular_values().unwrap()[0];
        assert!((norm - 1.0).abs() < 1e-14);
    }

    #[test]
    fn unusable_settings_are_refused() {
        let mut stream = Seed::from_u64(1).stream();
        let mut refused = |change: fn(&mut GraphDiffusionConfig)| {
            let mut config = GraphDiffusionConfig::new(10);
            change(&mut config);
            GraphDiffusion::random(&config, &mut stream).unwrap_err().to_string()
        };
        assert!(refused(|c| c.snr_db = f64::NAN).contains("NaN"));
        assert!(refused(|c| c.snr_db = f64::INFINITY).contains("inf"));
        assert!(refused(|c| c.measurement_dim = 0).contains("0 for N = 10"));
        assert!(refused(|c| c.measurement_dim = 11).contains("11 for N = 10"));
    }
}
