//! The Kalman filter, for measurements with and without gaps.

use std::ops::Deref;

use faer::{Col, Mat, MatRef};

use super::belief::Belief;
use super::correction::{Correction, correction};
use super::system::LinearSystem;
use crate::{Measurements, ModelError, PartialMeasurements, StateSpaceModel, Step, StepRecord};

/// What the filter knows at one time.
#[derive(Debug, Clone)]
pub struct KalmanStep {
    /// `p(x_t | y_{0:t−1})`; at `t = 0` the prior.
    pub predicted: Belief,
    /// `p(x_t | y_{0:t})`.
    pub filtered: Belief,
    /// `log p(y_t | y_{0:t−1})`.
    pub log_evidence_increment: f64,
    /// `A_t`, which led to the prediction; none at the start.
    pub(super) transition: Option<Mat<f64>>,
    /// What the measurement says, if there is one.
    pub(super) update: Option<Update>,
}

/// What a measurement says of a predicted state.
#[derive(Debug, Clone)]
pub(super) struct Update {
    /// `Cᵀ S⁻¹ v`, `N`.
    pub(super) score: Col<f64>,
    /// `Cᵀ S⁻¹ C`, `N×N`.
    pub(super) information: Mat<f64>,
    /// `I − G C`, `N×N`.
    pub(super) kept: Mat<f64>,
}

/// The filter's beliefs at every time.
#[derive(Debug, Clone)]
pub struct Filtered {
    /// One entry for each measurement.
    pub steps: Vec<KalmanStep>,
}

impl Filtered {
    /// `log p(y_{0:T−1}) = Σ_t log p(y_t | y_{0:t−1})`.
    pub fn log_evidence(&self) -> f64 {
        self.steps.iter().map(|step| step.log_evidence_increment).sum()
    }
}

/// The Kalman filter on a stream of measurements: it takes in one at a time.
///
/// With `m⁻, P⁻` the prediction, `S = C P⁻ Cᵀ + R` and `G = P⁻ Cᵀ S⁻¹`:
///
/// - `m = m⁻ + G (y − C m⁻ − d)`
/// - `P = (I − G C) P⁻ (I − G C)ᵀ + G R Gᵀ`, Joseph's form, which stays symmetric and positive.
#[derive(Debug, Clone)]
pub struct KalmanFilter<M> {
    model: M,
    time: usize,
    belief: Option<Belief>,
}

impl<M: Deref<Target: LinearSystem>> KalmanFilter<M> {
    /// Before the first measurement.
    pub fn new(model: M) -> Self {
        KalmanFilter { model, time: 0, belief: None }
    }

    /// That which had taken in so many measurements and had this belief then; none before the first.
    pub fn resume(model: M, time: usize, belief: Option<Belief>) -> Self {
        KalmanFilter { model, time, belief }
    }

    /// `p(x_t | y_{0:t})` after the last measurement; none before the first.
    pub fn belief(&self) -> Option<&Belief> {
        self.belief.as_ref()
    }

    /// How many measurements were taken in.
    pub fn time(&self) -> usize {
        self.time
    }

    /// Takes in the measurement of the next time (`M` entries, some of which may be missing), in the model's own next step.
    ///
    /// # Errors
    /// As [`KalmanFilter::step_at`].
    pub fn step(&mut self, measurement: &[Option<f64>]) -> Result<KalmanStep, ModelError> {
        let step = StepRecord::of(&self.model.step_of_index(self.time));
        self.step_at(&step.step(), measurement)
    }

    /// The same in a step that is given. Only the entries that are there correct the prediction, with their rows of `C`, `d` and `R`; where none is there, the
    /// prediction stands.
    ///
    /// # Errors
    /// [`ModelError::MeasurementWidth`] if the measurement does not fit the model. [`ModelError::Numerical`] with the time if an innovation covariance cannot
    /// be factored, or if a belief or a log-density is not finite. Nothing is taken in then.
    pub fn step_at(
        &mut self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<KalmanStep, ModelError> {
        let (model, time, width) = (&*self.model, self.time, measurement.len());
        let expected = model.measurement_dim();
        if width != expected {
            return Err(ModelError::MeasurementWidth { width, expected });
        }
        let (predicted, transition) = match &self.belief {
            None => (model.initial_belief(step).check("the first belief", time)?, None),
            Some(belief) => {
                let map = model.transition_map(step);
                (map.of_belief(belief).check("predicting a belief", time)?, Some(map.matrix))
            }
        };
        let (filtered, log_evidence_increment, update) = update(model, step, &predicted, measurement, time)?;
        self.belief = Some(filtered.clone());
        self.time += 1;
        Ok(KalmanStep { predicted, filtered, log_evidence_increment, transition, update })
    }
}

/// Runs a [`KalmanFilter`] over all measurements.
///
/// # Errors
/// As [`KalmanFilter::step`].
pub fn filter(
    model: &(impl LinearSystem + ?Sized),
    measurements: &Measurements,
) -> Result<Filtered, ModelError> {
    filter_partial(model, &measurements.into())
}

/// [`filter`] with gaps.
///
/// # Errors
/// As [`filter`].
pub fn filter_partial(
    model: &(impl LinearSystem + ?Sized),
    measurements: &PartialMeasurements,
) -> Result<Filtered, ModelError> {
    let mut filter = KalmanFilter::new(model);
    let steps = measurements.rows().map(|measurement| filter.step(measurement)).collect::<Result<_, _>>()?;
    Ok(Filtered { steps })
}

fn update(
    model: &(impl LinearSystem + ?Sized),
    step: &Step<'_>,
    predicted: &Belief,
    measurement: &[Option<f64>],
    time: usize,
) -> Result<(Belief, f64, Option<Update>), ModelError> {
    let there: Vec<usize> = (0..measurement.len()).filter(|&i| measurement[i].is_some()).collect();
    if there.is_empty() {
        return Ok((predicted.clone(), 0.0, None));
    }
    let map = model.measurement_map(step);
    let (c, r) = (map.matrix.as_ref(), map.covariance.as_ref());
    let measured =
        Col::from_fn(there.len(), |i| measurement[there[i]].unwrap_or(f64::NAN) - map.offset[there[i]]);
    if there.len() == measurement.len() {
        return correct(predicted, c, r, &measured, time);
    }
    let of_c = Mat::from_fn(there.len(), c.ncols(), |i, j| c[(there[i], j)]);
    let of_r = Mat::from_fn(there.len(), there.len(), |i, j| r[(there[i], there[j])]);
    correct(predicted, of_c.as_ref(), of_r.as_ref(), &measured, time)
}

const CORRECTING: &str = "correcting a belief";

/// Corrects a belief by what was measured of `C x + w`, `w ~ N(0, R)`. Gives the corrected belief, the log-density of the measurement, and what it says.
fn correct(
    predicted: &Belief,
    c: MatRef<'_, f64>,
    r: MatRef<'_, f64>,
    measured: &Col<f64>,
    time: usize,
) -> Result<(Belief, f64, Option<Update>), ModelError> {
    let failed = |reason| ModelError::Numerical { computation: CORRECTING, time, reason };
    let Correction { gain, covariance, innovation: distribution } =
        correction(predicted.covariance.as_ref(), c, r).map_err(|fault| failed(fault.to_string()))?;
    let innovation = measured - c * &predicted.mean;
    let log_evidence_increment = distribution.log_density_of(|i| innovation[i]);
    if !log_evidence_increment.is_finite() {
        return Err(failed(format!("the log-density of the measurement is {log_evidence_increment}")));
    }
    let lower = distribution.lower();
    let (mut whitened, mut seen) = (innovation.clone(), c.to_owned());
    lower.solve_lower_triangular_in_place(whitened.as_mut().as_mat_mut());
    lower.solve_lower_triangular_in_place(seen.as_mut());
    let update = Update {
        score: seen.transpose() * &whitened,
        information: seen.transpose() * &seen,
        kept: Mat::<f64>::identity(c.ncols(), c.ncols()) - &gain * c,
    };
    let filtered = Belief { mean: &predicted.mean + gain * &innovation, covariance };
    Ok((filtered.check(CORRECTING, time)?, log_evidence_increment, Some(update)))
}
