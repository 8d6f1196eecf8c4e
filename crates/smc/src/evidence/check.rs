//! A filter's log-evidence with its standard error, and warnings where neither can be trusted.

use std::ops::Deref;

use motes_models::{Seed, Simulator, StateSpaceModel, Step, Stream, StreamPosition};
use serde::{Deserialize, Serialize};

use super::ancestry::AncestryVariance;
use super::blocks::Blocks;
use super::coordinates::Coordinates;
use super::standard_error::error_of_variance;
use super::surprise::{Surprise, Surprises};
use super::warning::EvidenceWarning;
use crate::bank::{BankSnapshot, FilterBank, FilterSettings};
use crate::diagnosis::has_upper_end;
use crate::error::FilterError;
use crate::filter::ParticleFilter;
use crate::proposal::Proposal;

/// Small filters beside a filter.
const FILTERS: usize = 4;

/// The share of a filter's particles that each of them gets, at least so many particles, but for those that it cannot have.
const RATIO: usize = 16;
const LEAST_SMALL: usize = 25;

/// With a larger standard error a log-evidence hardly says which of two models is better (nats).
pub const LARGEST_ERROR: f64 = 10.0;

/// Small filters of the same model and proposal that run beside a filter, and tell how far its log-evidence may be off.
///
/// A filter of `K` particles gets four small ones of `K/16` particles, but of 25 at least (`K/4` below 100): a quarter of its particles from 400 on, as many as it
/// has with 100. They change nothing in it.
///
/// # The standard error
/// The larger of two estimates of the variance of `log Ẑ`: by ancestry ([`AncestryVariance`]), and by the small filters, block by block. Ancestry is
/// precise, but too small where errors last for long; small filters see all that varies, with few degrees of freedom. How much of it a larger filter has left
/// is read off from the ancestries of both. `log Ẑ` is too low by half its
/// variance in the mean.
///
/// # What it warns of
/// - [`EvidenceWarning::Surprise`]: measurements that the model hardly ever makes from where the particles are, one or several within five steps, as after a jump
///   that it does not know. States that lead there are rare from some steps before on, and no particle has been on such a path.
/// - [`EvidenceWarning::LargeError`]: a standard error above 10 nats. This is also what a run of selected tails looks like, in which each step is tolerable and all
///   err in one direction: small filters are lower by more than their size explains.
/// - [`EvidenceWarning::FewAncestors`]: a coordinate that hardly moves, as a constant does, has no values left.
///
/// A single step with too few effective particles is seen in its weights: [`WeightReport`](crate::WeightReport). No figure of a filter can see a mode that no
/// particle reached.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian, Seed, Step};
/// use motes_smc::{Bootstrap, EvidenceCheck, FilterSettings, ParticleFilter};
///
/// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]])?;
/// let (seed, settings) = (Seed::from_u64(7), FilterSettings::new(1000));
/// let mut filter = ParticleFilter::new(&model, Bootstrap, settings, seed.child("filter").stream())?;
/// let mut check = EvidenceCheck::new(&model, Bootstrap, settings, &seed.child("check"))?;
/// for (index, measurement) in [[Some(0.3)], [Some(1.2)], [None]].iter().enumerate() {
///     let step = Step::of_index(index);
///     filter.step_at(&step, measurement)?;
///     check.advance(&step, measurement);
///     check.take_in(&filter, measurement);
/// }
/// let error = check.standard_error().ok_or("too few particles")?;
/// println!("log-evidence {:.2} ± {error:.2}", filter.log_evidence());
/// assert!(check.warnings().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct EvidenceCheck<D: Deref, P: Proposal<D::Target>> {
    /// None where there are too few particles, or where a small filter failed.
    small: Option<FilterBank<D, P>>,
    stream: Stream,
    figures: Figures,
    /// Room for log-weights.
    logs: Vec<f64>,
}

/// What was found of a filter so far.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Figures {
    particles: usize,
    ancestry: AncestryVariance,
    /// Of each small filter.
    small_ancestry: Vec<AncestryVariance>,
    blocks: Blocks,
    coordinates: Coordinates,
    surprises: Surprises,
    log_evidence: f64,
    small_evidence: Vec<f64>,
}

/// What an [`EvidenceCheck`] is between two steps, but for its model and its proposal, to be written down as a [`BankSnapshot`] is.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct CheckSnapshot<Memory> {
    small: Option<BankSnapshot<Memory>>,
    stream: StreamPosition,
    figures: Figures,
}

/// The share of particles that are effective from which on no measurement is a surprise.
const MANY_EFFECTIVE: f64 = 0.25;

/// Particles below which no error is estimated.
const LEAST_PARTICLES: usize = 16;

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> EvidenceCheck<D, P> {
    /// For a filter with these settings; random numbers of the small filters come from `seed`, which the filter must not use.
    ///
    /// # Errors
    /// As [`FilterBank::new`].
    pub fn new(model: D, proposal: P, settings: FilterSettings, seed: &Seed) -> Result<Self, FilterError> {
        let particles = settings.particles;
        let small_particles = (particles / RATIO).max(LEAST_SMALL).min(particles / FILTERS);
        let is_estimable = particles >= LEAST_PARTICLES;
        let small = match is_estimable {
            true => {
                let settings = FilterSettings { particles: small_particles, ..settings };
                Some(FilterBank::new(model, proposal, settings, FILTERS, seed)?.keeping_collapsed())
            }
            false => None,
        };
        let ratio = particles as f64 / small_particles.max(1) as f64;
        let figures = Figures {
            particles,
            ancestry: AncestryVariance::default(),
            small_ancestry: vec![AncestryVariance::default(); FILTERS],
            blocks: Blocks::new(ratio, if is_estimable { FILTERS } else { 0 }),
            coordinates: Coordinates::default(),
            surprises: Surprises::default(),
            log_evidence: 0.0,
            small_evidence: vec![0.0; FILTERS],
        };
        Ok(EvidenceCheck { small, stream: seed.child("measurements").stream(), figures, logs: Vec::new() })
    }

    /// That which a snapshot was taken of, with the model and the proposal that it had.
    ///
    /// # Errors
    /// As [`FilterBank::restore`].
    pub fn restore(model: D, proposal: P, snapshot: CheckSnapshot<P::Memory>) -> Result<Self, FilterError> {
        let CheckSnapshot { small, stream, figures } = snapshot;
        let small = small.map(|bank| FilterBank::restore(model, proposal, bank)).transpose()?;
        Ok(EvidenceCheck { small, stream: stream.stream(), figures, logs: Vec::new() })
    }

    /// The standard error of the log-evidence, its bias included: the root of the mean square of `log Ẑ − log Z` (nats). None where there are too few particles to
    /// tell.
    pub fn standard_error(&self) -> Option<f64> {
        let variance = self.figures.ancestry.variance().max(self.figures.blocks.variance());
        (self.figures.particles >= LEAST_PARTICLES).then(|| error_of_variance(variance))
    }

    /// All that is not to be trusted after the steps so far.
    pub fn warnings(&self) -> Vec<EvidenceWarning> {
        let mut warnings = Vec::new();
        if let Some(Surprise { step, best, usual, .. }) = self.figures.surprises.worst {
            warnings.push(EvidenceWarning::Surprise {
                steps: self.figures.surprises.count,
                worst: step,
                best,
                usual,
            });
        }
        if let Some(standard_error) = self.standard_error().filter(|error| *error > LARGEST_ERROR) {
            warnings.push(EvidenceWarning::LargeError { standard_error });
        }
        let found = self.figures.coordinates.found().map(|found| EvidenceWarning::FewAncestors {
            coordinate: found.coordinate,
            step: found.step,
            since: found.since,
            ancestors: found.ancestors,
        });
        warnings.extend(found);
        warnings
    }
}

impl<D: Deref<Target: Simulator>, P: Proposal<D::Target>> EvidenceCheck<D, P> {
    /// Takes in the step that `filter` has just taken with this measurement, and the small filters, too.
    ///
    /// Every step is to be taken in, of one and the same filter.
    pub fn take_in(&mut self, filter: &ParticleFilter<D, P>, measurement: &[Option<f64>]) {
        let figures = &mut self.figures;
        figures.ancestry.step(filter);
        let ancestors = filter.bank().resampled(0).then(|| filter.ancestors());
        let step = filter.time().saturating_sub(1);
        figures.coordinates.step(step, filter.particles(), filter.weights(), ancestors);
        let effective = filter.effective_sample_size();
        if effective < MANY_EFFECTIVE * figures.particles as f64 {
            let of_filter = (filter.particles(), filter.weights());
            let model = &*filter.bank().model;
            // What has no density with gaps has been refused by the filter.
            let _ = figures.surprises.step(
                model,
                &filter.bank().last_step(),
                of_filter,
                measurement,
                &mut self.stream,
            );
        }
        let misses_peak = figures.blocks.would_miss(effective) && {
            self.logs.clear();
            self.logs.extend_from_slice(filter.weights().log());
            has_upper_end(&mut self.logs)
        };
        let small: Vec<f64> = match &self.small {
            Some(bank) => (0..bank.filters()).map(|number| bank.log_evidence(number)).collect(),
            None => vec![f64::NAN; figures.small_evidence.len()],
        };
        if let Some(bank) = &self.small {
            for (number, ancestry) in figures.small_ancestry.iter_mut().enumerate() {
                ancestry.step_of_bank(bank, number);
            }
        }
        let of_small = figures.small_ancestry.iter().map(AncestryVariance::variance).sum::<f64>();
        let ancestry = [figures.ancestry.variance(), of_small / figures.small_ancestry.len() as f64];
        let increment = filter.log_evidence() - figures.log_evidence;
        let grown = small.iter().zip(&figures.small_evidence).map(|(now, before)| now - before);
        figures.blocks.step(increment, grown, misses_peak, ancestry);
        figures.log_evidence = filter.log_evidence();
        figures.small_evidence = small;
    }

    /// Advances the small filters by a step with a measurement, some of whose entries may be missing. One that fails says nothing from there on.
    pub fn advance(&mut self, step: &Step<'_>, measurement: &[Option<f64>]) {
        if self.small.as_mut().is_some_and(|bank| bank.step_at(step, measurement).is_err()) {
            self.small = None;
        }
    }
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target, Memory: Clone>> EvidenceCheck<D, P> {
    /// What it is now, to be written down. It changes nothing.
    pub fn snapshot(&self) -> CheckSnapshot<P::Memory> {
        CheckSnapshot {
            small: self.small.as_ref().map(FilterBank::snapshot),
            stream: StreamPosition::of(&self.stream),
            figures: self.figures.clone(),
        }
    }
}
