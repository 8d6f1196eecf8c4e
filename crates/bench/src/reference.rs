//! Posterior means to hold estimates against where no formula gives them: two independent filters with very many particles.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use motes_models::{GraphDiffusion, Noise, Seed};
use motes_smc::{Bootstrap, FilterError, FilterSettings, MinDegeneracy, ParticleFilter, Proposal};

use crate::evaluate::UnitError;
use crate::problem::Problem;
use crate::{Interrupt, UnitConfig};

/// An estimate of `E[x_{T−1} | y_{0:T−1}]`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PosteriorMean {
    /// `N` numbers.
    pub(crate) mean: Vec<f64>,
    /// `‖a − b‖² / ‖a‖²` of the two independent estimates that `mean` is the average of; `None` where it is exact.
    pub(crate) difference: Option<f64>,
}

/// What is known of a problem's posterior.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct References {
    /// Under Gaussian densities: what the filters estimate when `densities = "gaussian"`.
    pub(crate) gaussian: Option<PosteriorMean>,
    /// Under the densities of the noise that data were drawn with, where they are not Gaussian; none where all weights of
    /// a reference filter vanish.
    pub(crate) exact: Option<PosteriorMean>,
}

/// The references of each system that this process has met: all methods and numbers of particles share them.
#[derive(Default)]
pub(crate) struct ReferenceCache {
    known: Mutex<HashMap<String, Slot>>,
}

/// Filled by the first that needs it, while others that need the same wait.
type Slot = Arc<OnceLock<Result<References, UnitError>>>;

impl ReferenceCache {
    /// The references of a unit's system; none where the Kalman filter gives the posterior of the system itself.
    pub(crate) fn of(
        &self,
        unit: &UnitConfig,
        problem: &Problem,
        interrupt: &Interrupt,
    ) -> Result<References, UnitError> {
        let Some(particles) = unit.reference_particles else { return Ok(References::default()) };
        let key = serde_json::to_string(&(unit.seed, unit.repetition, &unit.system, particles))
            .expect("a configuration has only string keys");
        let slot =
            self.known.lock().unwrap_or_else(PoisonError::into_inner).entry(key.clone()).or_default().clone();
        let found = slot.get_or_init(|| find(unit, problem, particles, interrupt)).clone();
        if found == Err(UnitError::Interrupted) {
            self.known.lock().unwrap_or_else(PoisonError::into_inner).remove(&key);
        }
        found
    }
}

fn find(
    unit: &UnitConfig,
    problem: &Problem,
    particles: usize,
    interrupt: &Interrupt,
) -> Result<References, UnitError> {
    let seed = unit.system_seed().child("reference");
    // Where all weights of a reference vanish there is none, and nothing is held against it.
    let known = |found: Result<PosteriorMean, FilterError>| match found {
        Ok(mean) => Ok(Some(mean)),
        Err(FilterError::Collapse { .. }) => Ok(None),
        Err(error) => Err(UnitError::Failed(format!("reference filter: {error}"))),
    };
    let gaussian = match &problem.exact {
        Some(exact) => {
            Some(PosteriorMean { mean: exact.means.row(exact.means.len() - 1).to_vec(), difference: None })
        }
        None => {
            let model = problem.system.with_noise(Noise::Gaussian);
            let proposal =
                MinDegeneracy::new(&model).map_err(|error| UnitError::Failed(error.to_string()))?;
            let seed = seed.child("gaussian");
            known(two_filters(&model, &proposal, particles, problem, &seed, interrupt)?)?
        }
    };
    let exact = if problem.has_gaussian_noise {
        None
    } else {
        known(two_filters(&problem.system, &Bootstrap, particles, problem, &seed.child("exact"), interrupt)?)?
    };
    Ok(References { gaussian, exact })
}

fn two_filters<P: Proposal<GraphDiffusion> + Clone>(
    model: &GraphDiffusion,
    proposal: &P,
    particles: usize,
    problem: &Problem,
    seed: &Seed,
    interrupt: &Interrupt,
) -> Result<Result<PosteriorMean, FilterError>, UnitError> {
    let mut means = Vec::new();
    for index in 0..2 {
        match last_mean(model, proposal.clone(), particles, problem, &seed.nth(index), interrupt)? {
            Ok(mean) => means.push(mean),
            Err(error) => return Ok(Err(error)),
        }
    }
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>();
    let apart = square(&mut means[0].iter().zip(&means[1]).map(|(a, b)| a - b));
    let difference = Some(apart / square(&mut means[0].iter().copied()));
    let mean = means[0].iter().zip(&means[1]).map(|(a, b)| 0.5 * (a + b)).collect();
    Ok(Ok(PosteriorMean { mean, difference }))
}

/// One filter's estimate at the last time.
fn last_mean<P: Proposal<GraphDiffusion>>(
    model: &GraphDiffusion,
    proposal: P,
    particles: usize,
    problem: &Problem,
    seed: &Seed,
    interrupt: &Interrupt,
) -> Result<Result<Vec<f64>, FilterError>, UnitError> {
    let run = || {
        let mut filter = ParticleFilter::new(model, proposal, FilterSettings::new(particles), seed.stream())?;
        for measurement in problem.trajectory.measurements.rows() {
            if interrupt.check() == ControlFlow::Break(()) {
                return Ok(None);
            }
            filter.step(measurement)?;
        }
        Ok(Some(filter.mean().to_vec()))
    };
    match run() {
        Ok(Some(mean)) => Ok(Ok(mean)),
        Ok(None) => Err(UnitError::Interrupted),
        Err(error) => Ok(Err(error)),
    }
}
