//! Posterior means to hold estimates against where no formula gives them: two independent filters with very many particles.

use motes_cli::Interrupt;
use motes_models::{Seed, StateSpaceModel};
use motes_smc::{
    Bootstrap, FilterError, FilterSettings, FixedLagSmoother, LookAhead, MinDegeneracy, ParticleFilter,
    Proposal,
};

use crate::computed_once::ComputedOnce;
use crate::config::Estimand;
use crate::problem::{Model, Problem};
use crate::statistics::{squared_error, squared_norm};
use crate::unit::UnitConfig;
use crate::unit_error::{UnitError, failed};

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
    /// Smoothed means and evidence of the filter's model, where no formula gives them and units ask for them.
    pub(crate) smoothed: Option<SmoothedReference>,
}

/// Estimates of `E[x_t | y_{0:T−1}]` and `log p(y_{0:T−1})`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SmoothedReference {
    /// `T×N`.
    pub(crate) means: Vec<f64>,
    pub(crate) log_evidence: f64,
    /// How far two independent estimates are apart: `‖a − b‖² / ‖a‖²` of the means, and the difference of the log-evidences.
    pub(crate) differences: [f64; 2],
}

/// The references of each system that this process has met: all methods and numbers of particles share them.
#[derive(Default)]
pub(crate) struct ReferenceCache {
    known: ComputedOnce<References>,
}

impl ReferenceCache {
    /// The references of a unit's system; none where the Kalman filter gives the posterior of the system itself.
    pub(crate) fn of(
        &self,
        unit: &UnitConfig,
        problem: &Problem,
        interrupt: &Interrupt,
    ) -> Result<References, UnitError> {
        let Some((particles, key)) = unit.reference_particles.zip(unit.reference_key()) else {
            return Ok(References::default());
        };
        self.known.of(&key, || find(unit, problem, particles, interrupt))
    }
}

fn find(
    unit: &UnitConfig,
    problem: &Problem,
    particles: usize,
    interrupt: &Interrupt,
) -> Result<References, UnitError> {
    let seed = unit.system_seed().child("reference");
    if unit.estimand == Estimand::Smoothing {
        let smoothed = Some(smoothed(problem, particles, &seed.child("smoothed"), interrupt)?);
        return Ok(References { smoothed, ..References::default() });
    }
    let gaussian = match &problem.exact {
        Some(exact) => {
            Some(PosteriorMean { mean: exact.means.row(exact.means.len() - 1).to_vec(), difference: None })
        }
        None => {
            let model = &*problem.gaussian;
            let proposal = MinDegeneracy::new(model).map_err(failed)?;
            two_filters(model, &proposal, particles, problem, &seed.child("gaussian"), interrupt)?
        }
    };
    let exact = if problem.has_gaussian_noise {
        None
    } else {
        two_filters(&*problem.system, &Bootstrap, particles, problem, &seed.child("exact"), interrupt)?
    };
    Ok(References { gaussian, exact, smoothed: None })
}

/// The average of two filters that look ahead.
fn smoothed(
    problem: &Problem,
    particles: usize,
    seed: &Seed,
    interrupt: &Interrupt,
) -> Result<SmoothedReference, UnitError> {
    let model = problem.equations()?;
    let ahead = LookAhead::new(model, &problem.recorded()).map_err(failed)?;
    let of_filter = |index: u64| {
        let settings = FilterSettings::new(particles);
        let filter = ParticleFilter::new(model, ahead.clone(), settings, seed.nth(index).stream());
        let last = problem.trajectory.measurements.len() - 1;
        let mut smoother = FixedLagSmoother::new(filter.map_err(failed)?, last);
        for measurement in problem.trajectory.measurements.rows() {
            if interrupt.check().is_break() {
                return Err(UnitError::Interrupted);
            }
            smoother.step(measurement).map_err(failed)?;
        }
        let n = model.state_dim();
        let mut means = vec![0.0; (last + 1) * n];
        for (time, mean) in means.chunks_exact_mut(n).enumerate() {
            smoother.mean(last - time, mean).map_err(failed)?;
        }
        Ok((means, smoother.filter().log_evidence()))
    };
    let ((a, log_a), (b, log_b)) = (of_filter(0)?, of_filter(1)?);
    let differences = [squared_error(&a, &b) / squared_norm(&a), (log_a - log_b).abs()];
    let means = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
    let larger = log_a.max(log_b);
    let log_evidence = larger + (0.5 * ((log_a - larger).exp() + (log_b - larger).exp())).ln();
    Ok(SmoothedReference { means, log_evidence, differences })
}

/// The average of two filters; none where all weights of one vanish, and nothing is then held against it.
fn two_filters<P: Proposal<Model> + Clone>(
    model: &Model,
    proposal: &P,
    particles: usize,
    problem: &Problem,
    seed: &Seed,
    interrupt: &Interrupt,
) -> Result<Option<PosteriorMean>, UnitError> {
    let last = |index| last_mean(model, proposal.clone(), particles, problem, &seed.nth(index), interrupt);
    let (Some(a), Some(b)) = (last(0)?, last(1)?) else { return Ok(None) };
    let difference = Some(squared_error(&a, &b) / squared_norm(&a));
    let mean = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
    Ok(Some(PosteriorMean { mean, difference }))
}

/// One filter's estimate at the last time; none where all its weights vanish.
fn last_mean<P: Proposal<Model>>(
    model: &Model,
    proposal: P,
    particles: usize,
    problem: &Problem,
    seed: &Seed,
    interrupt: &Interrupt,
) -> Result<Option<Vec<f64>>, UnitError> {
    let settings = FilterSettings::new(particles);
    let mut filter = ParticleFilter::new(model, proposal, settings, seed.stream()).map_err(failed)?;
    for measurement in problem.trajectory.measurements.rows() {
        if interrupt.check().is_break() {
            return Err(UnitError::Interrupted);
        }
        match filter.step(measurement) {
            Ok(()) => {}
            Err(FilterError::Collapse { .. }) => return Ok(None),
            Err(error) => return Err(failed(format!("reference filter: {error}"))),
        }
    }
    Ok(Some(filter.mean().to_vec()))
}
