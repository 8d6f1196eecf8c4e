//! The files that say what work is: one problem for all, and the weights and noise of each family.

use std::path::Path;

use motes_models::{
    GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, StateSpaceModel, Trajectory, simulate,
};
use motes_proposals::{Backend, Family, Learnable, save};
use motes_smc::Proposal;
use motes_train::TrainConfig;
use serde::Serialize;

use crate::error::{SpeedError, prepare};

/// Where all random numbers of this module come from.
pub(crate) fn seed() -> Seed {
    Seed::from_u64(1).child("speed")
}

/// Coordinates of the system, where nothing is said about growth with them.
pub(crate) const DIMENSION: usize = 10;

/// Times of a bank of filters, and of a training.
pub(crate) const BANK_HORIZON: usize = 12;

/// The system of this many coordinates on a graph.
pub(crate) fn system(dimension: usize) -> Result<GraphDiffusion, SpeedError> {
    let config = GraphDiffusionConfig::new(dimension);
    GraphDiffusion::random(&config, &mut seed().child("graph").stream()).map_err(prepare)
}

/// What it did, as far as it was watched.
pub(crate) fn trajectory(system: &GraphDiffusion, horizon: usize) -> Result<Trajectory, SpeedError> {
    simulate(system, horizon, &mut seed().child("trajectory").stream()).map_err(prepare)
}

/// A problem as the other libraries read it.
#[derive(Serialize)]
struct Problem {
    #[serde(rename = "A")]
    transition: Vec<Vec<f64>>,
    #[serde(rename = "C")]
    measurement: Vec<Vec<f64>>,
    sigma: f64,
    measurements: Vec<Vec<f64>>,
    shift: Vec<Vec<f64>>,
    adapter: Vec<Vec<f64>>,
}

/// Writes a system and its first `horizon` measurements.
pub(crate) fn write_problem(path: &Path, dimension: usize, horizon: usize) -> Result<(), SpeedError> {
    use motes_models::{AdditiveGaussian, GraphModel};
    let system = system(dimension)?;
    let measurements = trajectory(&system, horizon)?.measurements;
    let rows = |matrix: faer::MatRef<'_, f64>| -> Vec<Vec<f64>> {
        (0..matrix.nrows()).map(|i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect()).collect()
    };
    let graph = system.graph();
    let problem = Problem {
        transition: rows(system.adjacency()),
        measurement: rows(system.measurement_matrix()),
        sigma: system.transition_covariance()[(0, 0)].sqrt(),
        measurements: measurements.rows().map(<[f64]>::to_vec).collect(),
        shift: rows(graph.shift.as_ref()),
        adapter: rows(graph.adapter.as_ref()),
    };
    let text = serde_json::to_string(&problem).map_err(prepare)?;
    std::fs::write(path, text).map_err(SpeedError::system(path))
}

/// Writes initial weights of a family, the problem and the noise of one training step.
pub(crate) fn write_training<F: Family + Learnable + Proposal<GraphDiffusion>>(
    folder: &Path,
    config: &F::Config,
    horizon: usize,
    particles: usize,
) -> Result<(), SpeedError> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(SpeedError::system(folder))?;
    }
    let system = system(DIMENSION)?;
    let (shape, weights) = (ModelShape::on_graph(&system), seed().child("weights"));
    let proposal = F::create(config, &shape, horizon, Backend::Native.into(), &weights);
    let proposal = proposal.map_err(prepare)?;
    save(folder, &proposal, &system, &shape, &TrainConfig::paper(particles)).map_err(prepare)?;
    write_problem(&folder.join("problem.json"), DIMENSION, horizon)?;
    let (mut stream, mut noise) = (seed().child("noise").stream(), vec![0.0; particles * system.state_dim()]);
    let mut bytes = Vec::new();
    for _ in 0..horizon {
        proposal.fill_noise(&mut stream, &mut noise);
        bytes.extend(noise.iter().flat_map(|value| value.to_le_bytes()));
    }
    let path = folder.join("noise.f64");
    std::fs::write(&path, bytes).map_err(SpeedError::system(&path))
}
