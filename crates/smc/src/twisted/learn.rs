//! How a twisting is learned, and what it is for.

use motes_models::equations::Linearise;
use motes_models::{PartialMeasurements, Seed, Simulator, Stream};

use super::error::TwistingError;
use super::filter;
use super::fit::{coefficients, fit};
use super::model::{TwistedModel, look_ahead};
use super::quadratic::Quadratic;
use crate::error::FilterError;
use crate::filter::ParticleFilter;
use crate::proposals::Linearised;
use crate::smoothing::FilterHistory;

/// Particles for each coefficient of a quadratic, at the least.
const PARTICLES_PER_COEFFICIENT: usize = 4;

/// How often it is learned: first from a linearised filter's particles, then from those of the filter that it made last.
const PASSES: usize = 3;

/// What is measured from each time on, as a quadratic in the state of that time: for the log-evidence of one sequence.
///
/// ```
/// use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
/// use motes_models::{PartialMeasurements, Seed, Step, simulate};
/// use motes_smc::Twisting;
///
/// /// A state that turns, and is measured in one direction.
/// struct Turning;
///
/// impl Equations for Turning {
///     fn dimensions(&self) -> [usize; 2] {
///         [2, 1]
///     }
///
///     fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
///         (0..2).for_each(|i| state[i] = draws.draw(normal(0.0, 1.0)));
///     }
///
///     fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
///         state[0] = draws.draw(normal(x[0] * 0.9 + x[1] * 0.3, 0.2));
///         state[1] = draws.draw(normal(x[1] * 0.9 - x[0] * 0.3, 0.2));
///     }
///
///     fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
///         y.push(normal(x[0] + x[0] * x[0] * 0.1, 0.5));
///     }
/// }
///
/// let seed = Seed::from_u64(1);
/// let data = simulate(&Turning, 50, &mut seed.child("data").stream())?;
/// let measurements = PartialMeasurements::from(&data.measurements);
/// let twisting = Twisting::learn(&Turning, &measurements, 500, 500, &seed.child("learn"))?;
/// let found: Vec<f64> = (0..10)
///     .map(|filter| twisting.log_evidence(&Turning, 500, seed.nth(filter).stream()))
///     .collect::<Result<_, _>>()?;
/// let range = found.iter().copied().fold(f64::MIN, f64::max) - found.iter().copied().fold(f64::MAX, f64::min);
/// assert!(range < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Twisting {
    measurements: PartialMeasurements,
    /// `log φ_t` of each time.
    functions: Vec<Quadratic>,
}

impl Twisting {
    /// Learns one for a sequence of measurements (`T` rows of `M`), from `particles` particles of each time: first of a linearised filter of `first`
    /// particles, then of twisted ones of `particles`.
    ///
    /// The linearised filter must follow the state: where it has lost it, twisted filters look ahead from where the state never was.
    ///
    /// # Errors
    /// - [`TwistingError::Setting`] if there are too few particles for a quadratic of `N` coordinates.
    /// - [`TwistingError::Filter`] if the measurements do not fit the model, or a filter fails.
    /// - [`TwistingError::Fit`] if the particles of a time are too much alike.
    /// - [`TwistingError::Memory`] if they cannot be kept.
    pub fn learn<M: Linearise + Simulator + ?Sized>(
        model: &M,
        measurements: &PartialMeasurements,
        first: usize,
        particles: usize,
        seed: &Seed,
    ) -> Result<Self, TwistingError> {
        let fewest = coefficients(model.state_dim()).saturating_mul(PARTICLES_PER_COEFFICIENT);
        if particles.min(first) < fewest {
            return Err(TwistingError::Setting {
                name: "the number of particles that a twisting is learned from",
                value: format!("{} for {} coordinates", particles.min(first), model.state_dim()),
                expected: "at least 4 for each coefficient of a quadratic, of which there are 1 + N + N(N + 1)/2",
            });
        }
        let linearised = Linearised::new(model).map_err(FilterError::from)?;
        let stream = seed.nth(0).stream();
        let mut filter = ParticleFilter::new(model, linearised, filter::settings(first), stream)?;
        let mut history = FilterHistory::new();
        for row in measurements.rows() {
            filter.step_partial(row)?;
            history.record_some(&filter, particles)?;
        }
        drop(filter);
        let mut twisting = Twisting::of(model, measurements, &history)?;
        for pass in 1..PASSES {
            let mut history = FilterHistory::new();
            let stream = seed.nth(pass as u64).stream();
            filter::run(&twisting.model(model), particles, stream, |filter| {
                history.record(filter).map_err(TwistingError::from)
            })?;
            twisting = Twisting::of(model, measurements, &history)?;
        }
        Ok(twisting)
    }

    /// Learns one from the particles of a filter, backwards in time.
    fn of<M: Linearise + ?Sized>(
        model: &M,
        measurements: &PartialMeasurements,
        history: &FilterHistory,
    ) -> Result<Self, TwistingError> {
        let n = model.state_dim();
        // The last time first.
        let mut functions: Vec<Quadratic> = Vec::new();
        let mut targets = Vec::new();
        for (time, (row, generation)) in measurements.rows().zip(&history.generations).enumerate().rev() {
            let (states, log_weights) = (&generation.states, &generation.log_weights);
            targets.resize(log_weights.len(), f64::NAN);
            look_ahead(model, &generation.step.step(), row, functions.last(), states, &mut targets)
                .map_err(FilterError::from)?;
            let function = fit(n, states, log_weights, &targets);
            functions.push(function.ok_or(TwistingError::Fit { time })?);
        }
        functions.reverse();
        Ok(Twisting { measurements: measurements.clone(), functions })
    }

    /// An estimate of `log p(y_{0:T−1})` by a filter of `particles` particles; its exponential is unbiased if `stream` had no part in learning.
    ///
    /// # Errors
    /// [`FilterError`] if the filter fails, or the model is another.
    pub fn log_evidence<M: Linearise + ?Sized>(
        &self,
        model: &M,
        particles: usize,
        stream: Stream,
    ) -> Result<f64, FilterError> {
        filter::run(&self.model(model), particles, stream, |_| Ok(()))
    }

    fn model<'a, M: ?Sized>(&'a self, model: &'a M) -> TwistedModel<'a, M> {
        TwistedModel { model, measurements: &self.measurements, functions: &self.functions }
    }
}
