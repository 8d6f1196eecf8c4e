//! Whether a bootstrap filter that runs beside a filter says that it misses mass.

use std::ops::Deref;

use motes_models::StateSpaceModel;
use serde::{Deserialize, Serialize};

use super::misses::Misses;
use super::trust::Trust;
use super::verdict::Verdict;
use super::windows::{Since, Windows};
use crate::bank::FilterBank;
use crate::error::FilterError;
use crate::evidence::AncestryVariance;
use crate::filter::ParticleFilter;
use crate::proposal::Proposal;

/// Steps after a miss that are not looked at: what they show is a consequence of it.
const REST: usize = 5;

/// A bootstrap filter's view of another filter of the same model and measurements.
///
/// A filter's own figures cannot see a mode that no particle reached: weights are as even as if there were none. A bootstrap filter goes wherever the model goes,
/// and its log-evidence, when it is poor, is too small. So where it is far above, the other filter misses mass.
///
/// Both filters are the caller's, and nothing is changed in them. They are shown after each step, from the first on.
///
/// # How it judges
/// - A *miss* is a window of the last 1, 2, 4, … 1024 steps over which the bootstrap's log-evidence is larger by at least 5 nats, by at least 6 standard
///   errors of both ([`AncestryVariance`]), and by the filter's bias. Short windows see a local miss in a long sequence, long ones a slow drift.
/// - An estimate of error is trusted from 20 effective particles on (2 % of all if that is more), and as long as a block of steps has a variance of at most ½.
///   After a step that is not trusted, 20 more are not.
/// - A miss over steps at which both filters are trusted is warned of at once.
/// - Sound filters of few particles miss mass by chance, too, and then have few effective ones. Such a miss alone is no warning. There is one where the
///   filter has missed seven times as often as the bootstrap, counting one more of the latter.
///   Only misses during which the bootstrap had effective particles enough count against the filter.
/// - A bootstrap filter that fails, as by [`FilterError::Collapse`], has no opinion from there on.
///
/// # What it cannot see
/// - Mass that the bootstrap does not reach either.
/// - A loss below 5 nats, as of a mode with half of the mass that is lost once and for all: that is 0.7 nats.
/// - Filters of fewer than some hundred particles, and measurements so precise that the bootstrap has hardly any effective ones. The verdict then is
///   [`Verdict::NoOpinion`].
/// - Densities of a proposal that are wrong so that the evidence is too large.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian, Seed};
/// use motes_smc::{Bootstrap, FilterSettings, MinDegeneracy, ParticleFilter, SecondOpinion, Verdict};
///
/// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]])?;
/// let (seed, settings) = (Seed::from_u64(7), FilterSettings::new(1000));
/// let mut filter = ParticleFilter::new(&model, MinDegeneracy::new(&model)?, settings, seed.child("filter").stream())?;
/// let mut bootstrap = ParticleFilter::new(&model, Bootstrap, settings, seed.child("bootstrap").stream())?;
/// let mut opinion = SecondOpinion::new();
/// for measurement in [[0.3], [1.2], [0.7]] {
///     filter.step(&measurement)?;
///     // One that fails has no opinion.
///     let _ = bootstrap.step(&measurement);
///     opinion.step(&filter, &bootstrap)?;
/// }
/// assert_eq!(opinion.verdict(), Verdict::Agrees);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct SecondOpinion {
    steps: usize,
    unjudged: usize,
    first_unjudged: Option<usize>,
    has_failed: bool,
    /// Of the filter and of the bootstrap, as all pairs are.
    log_evidence: [f64; 2],
    errors: [AncestryVariance; 2],
    trust: [Trust; 2],
    windows: Windows,
    misses: Misses,
    /// Steps that are still not to be looked at.
    rest: usize,
    warning: Option<Warning>,
}

/// What was found.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Warning {
    since: Since,
    difference: f64,
    error: f64,
}

/// What a step shows.
enum StepFinding {
    Nothing,
    MissOfBootstrap,
    /// With whether both filters are trusted over its steps.
    MissOfFilter(Since, bool),
}

impl SecondOpinion {
    /// One that has seen nothing yet.
    pub fn new() -> Self {
        SecondOpinion::default()
    }

    /// Takes in the step that both filters have just taken, or at which the bootstrap failed.
    ///
    /// # Errors
    /// Nothing is taken in then. The filter's own error if it has failed; [`FilterError::Setting`] if a filter has not taken one step
    /// more than at the last call.
    pub fn step<D, P, E, Q>(
        &mut self,
        filter: &ParticleFilter<D, P>,
        bootstrap: &ParticleFilter<E, Q>,
    ) -> Result<(), FilterError>
    where
        D: Deref<Target: StateSpaceModel>,
        P: Proposal<D::Target>,
        E: Deref<Target: StateSpaceModel>,
        Q: Proposal<E::Target>,
    {
        self.step_of_banks((filter.bank(), 0), (bootstrap.bank(), 0))
    }

    /// The same of one filter of a bank, and one of a bank of bootstrap filters.
    ///
    /// # Errors
    /// As [`SecondOpinion::step`], and [`FilterError::Setting`] if there is no such filter.
    pub fn step_of_banks<D, P, E, Q>(
        &mut self,
        filter: (&FilterBank<D, P>, usize),
        bootstrap: (&FilterBank<E, Q>, usize),
    ) -> Result<(), FilterError>
    where
        D: Deref<Target: StateSpaceModel>,
        P: Proposal<D::Target>,
        E: Deref<Target: StateSpaceModel>,
        Q: Proposal<E::Target>,
    {
        if let Some(failure) = filter.0.failure() {
            return Err(failure.clone());
        }
        self.check(filter)?;
        self.has_failed |= bootstrap.0.failure().is_some();
        if !self.has_failed {
            self.check(bootstrap)?;
            let before = self.log_evidence;
            self.read(0, filter);
            self.read(1, bootstrap);
            let grown = [0, 1].map(|of| self.log_evidence[of] - before[of]);
            self.compare(grown[1] - grown[0]);
        }
        if self.has_failed || self.judged_steps() == 0 {
            self.unjudged += 1;
            self.first_unjudged.get_or_insert(self.steps);
        }
        self.steps += 1;
        Ok(())
    }

    /// Whether there is such a filter, and it has taken the next step.
    fn check<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>>(
        &self,
        (bank, filter): (&FilterBank<D, P>, usize),
    ) -> Result<(), FilterError> {
        let (name, value, expected) = if filter >= bank.filters() {
            ("the filter that there is to be a second opinion of", filter, "one of its bank")
        } else if bank.time() != self.steps + 1 {
            (
                "the number of steps that a filter has taken",
                bank.time(),
                "one more than the steps of the second opinion on it",
            )
        } else {
            return Ok(());
        };
        Err(FilterError::Setting { name, value: value.to_string(), expected })
    }

    /// Reads off the filter (0) or the bootstrap (1).
    fn read<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>>(
        &mut self,
        which: usize,
        (bank, filter): (&FilterBank<D, P>, usize),
    ) {
        self.errors[which].step_of_bank(bank, filter);
        self.trust[which].step(bank.weights(filter), &self.errors[which]);
        self.log_evidence[which] = bank.log_evidence(filter);
    }

    /// For how many steps up to now both filters have been trusted.
    fn judged_steps(&self) -> usize {
        self.trust[0].recovered_steps().min(self.trust[1].recovered_steps())
    }

    /// Takes in the difference of two increments of log-evidence.
    fn compare(&mut self, difference: f64) {
        let is_resting = self.rest > 0;
        if is_resting {
            self.rest -= 1;
            self.windows.skip(difference);
        } else {
            self.windows.step(self.steps, difference, &self.errors);
        }
        if let Some(Warning { since, .. }) = self.warning {
            return self.warn(since);
        }
        if is_resting {
            return;
        }
        match self.look() {
            StepFinding::Nothing => {}
            StepFinding::MissOfBootstrap => {
                self.misses.bootstrap_missed();
                self.rest = REST;
            }
            StepFinding::MissOfFilter(since, true) => self.warn(since),
            StepFinding::MissOfFilter(since, false) => {
                self.rest = REST;
                if let Some(first) = self.misses.filter_missed(since) {
                    self.warn(first);
                }
            }
        }
    }

    /// Looks at all windows that end now.
    fn look(&self) -> StepFinding {
        let mut alone = StepFinding::Nothing;
        for (length, since) in self.windows.ending_now() {
            let excess = self.windows.since(&since, &self.errors);
            if excess.is_miss_of_bootstrap() {
                return StepFinding::MissOfBootstrap;
            }
            if excess.is_miss_of_filter() && length <= self.trust[1].steps() {
                if length <= self.judged_steps() {
                    return StepFinding::MissOfFilter(since, true);
                }
                alone = StepFinding::MissOfFilter(since, false);
            }
        }
        alone
    }

    /// Warns of what has happened since then, or of worse if it has become worse.
    fn warn(&mut self, since: Since) {
        let excess = self.windows.since(&since, &self.errors);
        if self.warning.is_none_or(|warning| excess.difference > warning.difference) {
            self.warning = Some(Warning { since, difference: excess.difference, error: excess.error() });
        }
    }

    /// What it says of all steps so far. Once it warns, it goes on to.
    pub fn verdict(&self) -> Verdict {
        let (unjudged, steps) = (self.unjudged, self.steps);
        match (self.warning, self.first_unjudged) {
            (Some(Warning { since, difference, error }), _) => {
                Verdict::Warns { first_step: since.step, difference, error }
            }
            (None, Some(first_step)) => Verdict::NoOpinion { first_step, unjudged, steps },
            (None, None) if steps == 0 => Verdict::NoOpinion { first_step: 0, unjudged, steps },
            _ => Verdict::Agrees,
        }
    }

    /// How many steps it has seen.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// How many of them it could not judge.
    pub fn unjudged_steps(&self) -> usize {
        self.unjudged
    }

    /// The bootstrap's log-evidence of all steps less that of the filter, as long as the bootstrap had not failed (nats).
    pub fn difference(&self) -> f64 {
        self.windows.difference()
    }

    /// The Monte Carlo standard error of [`SecondOpinion::difference`] (nats), where both filters can be trusted.
    pub fn standard_error(&self) -> f64 {
        (self.errors[0].variance() + self.errors[1].variance()).sqrt()
    }
}
