//! A Gaussian family of one's own, from another crate: a mean that is one affine map of the previous state and the measurement.
//!
//! `cargo run --release -p motes-proposals --example own_family`. A family is its networks. All the rest comes with them: covariance, draws, densities,
//! derivatives for training, saving and loading.

use std::error::Error;

use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, simulate};
use motes_networks::layers::Mlp;
use motes_networks::{Arithmetic, Backend, Known, Networks, Outputs, Parameters};
use motes_proposals::{Family, GaussianNetworks, GaussianProposal, load, save};
use motes_smc::{FilterSettings, ParticleFilter, ProposalError};
use serde::{Deserialize, Serialize};

/// The settings of the family.
#[derive(Clone, Serialize, Deserialize)]
struct AffineConfig {
    /// Added to the diagonal of the covariance.
    ridge: f64,
}

/// `μ_t` and `z_t`, each one affine map of `[x_{t−1}; y_t]`, the same at all times.
#[derive(Clone)]
struct Affine {
    mean: Mlp,
    representation: Mlp,
}

impl Networks for Affine {
    fn horizon(&self) -> Option<usize> {
        None
    }

    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        _time: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows> {
        let inputs = arithmetic.stacked(&known.previous, &known.measurement);
        let means = self.mean.forward(arithmetic, inputs.clone());
        let representations = self.representation.forward(arithmetic, inputs);
        Outputs::new([means, representations], [])
    }
}

impl GaussianNetworks for Affine {
    const NAME: &'static str = "affine";
    type Config = AffineConfig;

    fn check(_config: &AffineConfig, _horizon: usize) -> Result<(), ProposalError> {
        Ok(())
    }

    fn count(_config: &AffineConfig, shape: &ModelShape, _horizon: usize) -> Option<usize> {
        let inputs = shape.state_dim.checked_add(shape.measurement_dim)?;
        inputs.checked_add(1)?.checked_mul(shape.state_dim)?.checked_mul(2)
    }

    fn draw(
        _config: &AffineConfig,
        shape: &ModelShape,
        _horizon: usize,
        parameters: &mut Parameters,
        seed: &Seed,
    ) -> Result<Self, ProposalError> {
        let widths = [shape.state_dim + shape.measurement_dim, shape.state_dim];
        Ok(Affine {
            mean: Mlp::draw(parameters, "mean", &widths, seed),
            representation: Mlp::draw(parameters, "covariance", &widths, seed),
        })
    }

    fn ridge(config: &AffineConfig) -> f64 {
        config.ridge
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let seed = Seed::from_u64(1);
    let system = GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut seed.child("graph").stream())?;
    let measurements = simulate(&system, 5, &mut seed.child("data").stream())?.measurements;
    let (shape, config) = (ModelShape::of(&system), AffineConfig { ridge: 0.5 });
    let made: GaussianProposal<Affine> =
        Family::create(&config, &shape, 0, Backend::Native.into(), &seed.child("weights"))?;

    let folder = std::env::temp_dir().join(format!("motes-own-family-{}", std::process::id()));
    save(&folder, &made, &system, &shape, &config)?;
    let proposal: GaussianProposal<Affine> = load(&folder, &system, &shape, Backend::Native.into())?;
    std::fs::remove_dir_all(&folder)?;

    let settings = FilterSettings { defensive_weight: Some(0.2), ..FilterSettings::new(500) };
    let mut filter = ParticleFilter::new(&system, proposal, settings, seed.child("filter").stream())?;
    for measurement in measurements.rows() {
        filter.step(measurement)?;
        println!("{:.1} effective particles of 500", filter.effective_sample_size());
    }
    Ok(())
}
