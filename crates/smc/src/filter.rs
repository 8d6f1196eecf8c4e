//! One particle filter on a stream of measurements.

use std::ops::Deref;

use motes_models::{StateSpaceModel, Step, Stream};

use crate::bank::{FilterBank, FilterSettings};
use crate::diagnosis::WeightDiagnosis;
use crate::error::FilterError;
use crate::proposal::Proposal;
use crate::weights::LogWeights;

/// A filter that takes one measurement at a time: a [`FilterBank`] of one, without the index. Threads and clones are as there.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian, Seed};
/// use motes_smc::{FilterSettings, MinDegeneracy, ParticleFilter};
///
/// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]])?;
/// let proposal = MinDegeneracy::new(&model)?;
/// let stream = Seed::from_u64(7).stream();
/// let mut filter = ParticleFilter::new(&model, proposal, FilterSettings::new(1000), stream)?;
/// for measurement in [[0.3], [1.2], [0.7]] {
///     filter.step(&measurement)?;
///     println!("{:?} from {:.0} effective particles", filter.mean(), filter.effective_sample_size());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ParticleFilter<D: Deref, P: Proposal<D::Target>> {
    pub(crate) bank: FilterBank<D, P>,
    pub(crate) mean: Vec<f64>,
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> ParticleFilter<D, P> {
    /// Prepares a filter that draws from `stream`.
    ///
    /// # Errors
    /// [`FilterError::Setting`] if there is no particle or a setting is out of range.
    pub fn new(model: D, proposal: P, settings: FilterSettings, stream: Stream) -> Result<Self, FilterError> {
        let mean = vec![0.0; model.state_dim()];
        Ok(ParticleFilter { bank: FilterBank::with_streams(model, proposal, settings, vec![stream])?, mean })
    }

    /// Takes in one measurement (`M` numbers).
    ///
    /// # Errors
    /// As [`FilterBank::step`].
    pub fn step(&mut self, measurement: &[f64]) -> Result<(), FilterError> {
        self.bank.step(measurement)?;
        self.bank.mean(0, &mut self.mean);
        Ok(())
    }

    /// Takes in one measurement (`M` entries), some or all of which may be missing, by a step of its own time, length, inputs and parameters.
    ///
    /// # Errors
    /// As [`FilterBank::step_at`].
    pub fn step_at(&mut self, step: &Step<'_>, measurement: &[Option<f64>]) -> Result<(), FilterError> {
        self.bank.step_at(step, measurement)?;
        self.bank.mean(0, &mut self.mean);
        Ok(())
    }

    /// The estimate of `E[x_t | y_{0:t}]` (`N`); zeros before the first step.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Quantiles of one coordinate of `x_t` given `y_{0:t}`, as [`FilterBank::quantiles`].
    ///
    /// # Panics
    /// If there is no such coordinate, or a probability is not between 0 and 1.
    pub fn quantiles(&self, coordinate: usize, probabilities: &[f64]) -> Vec<f64> {
        self.bank.quantiles(0, coordinate, probabilities)
    }

    /// The particles, row-major `K×N`.
    pub fn particles(&self) -> &[f64] {
        self.bank.particles(0)
    }

    /// The particles a step before (`K×N`), as [`FilterBank::previous_particles`]. Where the filter has failed, they are the `x_{t−1}` of the step that failed.
    ///
    /// ```
    /// use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
    /// use motes_models::{Seed, Step};
    /// use motes_smc::{Bootstrap, FilterError, FilterSettings, ParticleFilter};
    ///
    /// /// A root whose argument can become negative.
    /// struct Root;
    ///
    /// impl Equations for Root {
    ///     fn dimensions(&self) -> [usize; 2] {
    ///         [1, 1]
    ///     }
    ///
    ///     fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
    ///         state[0] = draws.draw(normal(1.0, 0.1));
    ///     }
    ///
    ///     fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
    ///         state[0] = draws.draw(normal(x[0].sqrt() - 0.5, 0.1));
    ///     }
    ///
    ///     fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
    ///         y.push(normal(x[0], 1.0));
    ///     }
    /// }
    ///
    /// let stream = Seed::from_u64(1).stream();
    /// let mut filter = ParticleFilter::new(&Root, Bootstrap, FilterSettings::new(100), stream)?;
    /// let failure = (0..20).find_map(|_| filter.step(&[0.2]).err());
    /// let Some(FilterError::NotANumber { step, particle, .. }) = failure else { panic!("it stays in its domain") };
    /// let previous = filter.previous_particles().ok_or("there was no step before")?;
    /// let at = previous[filter.ancestors()[particle]];
    /// assert!(at < 0.0);
    /// println!("the formula left its domain at x_{} = {at:.3}", step - 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn previous_particles(&self) -> Option<&[f64]> {
        self.bank.previous_particles(0)
    }

    /// The error that this filter failed with, if it has: every later step returns it.
    pub fn failure(&self) -> Option<&FilterError> {
        self.bank.failure()
    }

    /// Their weights.
    pub fn weights(&self) -> &LogWeights {
        self.bank.weights(0)
    }

    /// For each particle, the one that it descends from in the step before; itself where there was no resampling.
    pub fn ancestors(&self) -> &[usize] {
        self.bank.ancestors()
    }

    /// `1 / Σ_k W_k²`.
    pub fn effective_sample_size(&self) -> f64 {
        self.weights().effective_sample_size()
    }

    /// What the weights of the last step say about how far they can be trusted, as [`FilterBank::diagnosis`].
    pub fn diagnosis(&self) -> WeightDiagnosis {
        self.bank.diagnosis()
    }

    /// The estimate of `log p(y_{0:t})`; its exponential is unbiased.
    pub fn log_evidence(&self) -> f64 {
        self.bank.log_evidence(0)
    }

    /// How many steps have been taken.
    pub fn time(&self) -> usize {
        self.bank.time()
    }

    /// The proposal, to be changed between two steps: for who learns while it filters. The evidence stays unbiased, whatever it is changed to by what was
    /// measured before.
    pub fn proposal_mut(&mut self) -> &mut P {
        self.bank.proposal_mut()
    }

    /// The bank of one filter that this is.
    pub fn bank(&self) -> &FilterBank<D, P> {
        &self.bank
    }
}

impl<D: Deref + Clone, P: Proposal<D::Target, Memory: Clone> + Clone> Clone for ParticleFilter<D, P> {
    fn clone(&self) -> Self {
        ParticleFilter { bank: self.bank.clone(), mean: self.mean.clone() }
    }
}
