//! The Kalman filter and smoother: exact means, covariances and log-evidence of a linear Gaussian model.

use faer::{Col, Mat, MatRef};

use crate::error::check_matrix;
pub use crate::smoother::{Smoothed, smooth};
use crate::{
    AdditiveGaussian, Gaussian, LinearGaussian, Measurements, ModelError, PartialMeasurements,
    StateSpaceModel,
};

/// A Gaussian belief about a state.
#[derive(Debug, Clone)]
pub struct Belief {
    /// The mean, `N`.
    pub mean: Col<f64>,
    /// The covariance, `N×N`.
    pub covariance: Mat<f64>,
}

/// What the filter knows at one time.
#[derive(Debug, Clone)]
pub struct Step {
    /// `p(x_t | y_{0:t−1})`; at `t = 0` the prior.
    pub predicted: Belief,
    /// `p(x_t | y_{0:t})`.
    pub filtered: Belief,
    /// `log p(y_t | y_{0:t−1})`.
    pub log_evidence_increment: f64,
}

/// The filter's beliefs at every time.
#[derive(Debug, Clone)]
pub struct Filtered {
    /// One entry for each measurement.
    pub steps: Vec<Step>,
}

impl Filtered {
    /// `log p(y_{0:T−1}) = Σ_t log p(y_t | y_{0:t−1})`.
    pub fn log_evidence(&self) -> f64 {
        self.steps.iter().map(|step| step.log_evidence_increment).sum()
    }
}

/// Runs the Kalman filter over all measurements.
///
/// With `m⁻, P⁻` the prediction: `S = C P⁻ Cᵀ + R`, `G = P⁻ Cᵀ S⁻¹`, `m = m⁻ + G (y − C m⁻)`, and the
/// covariance in Joseph's form, `P = (I − G C) P⁻ (I − G C)ᵀ + G R Gᵀ`, which stays symmetric and positive.
///
/// # Errors
/// [`ModelError::MeasurementWidth`] if the measurements do not fit the model; [`ModelError::Numerical`] if
/// an innovation covariance cannot be factored.
pub fn filter(model: &LinearGaussian, measurements: &Measurements) -> Result<Filtered, ModelError> {
    filter_partial(model, &measurements.into())
}

/// [`filter`] with gaps: of a measurement only the entries that are there, with their rows of `C` and `R`, correct the prediction, and
/// where none is the prediction stands.
///
/// # Errors
/// As [`filter`].
pub fn filter_partial(
    model: &LinearGaussian,
    measurements: &PartialMeasurements,
) -> Result<Filtered, ModelError> {
    let (width, expected) = (measurements.width(), model.measurement_dim());
    if width != expected {
        return Err(ModelError::MeasurementWidth { width, expected });
    }
    let mut steps: Vec<Step> = Vec::with_capacity(measurements.len());
    for (time, measurement) in measurements.rows().enumerate() {
        let predicted = match steps.last() {
            None => Belief {
                mean: Col::from_fn(model.state_dim(), |i| model.initial().mean()[i]),
                covariance: model.initial().covariance().to_owned(),
            },
            Some(step) => predict(model, &step.filtered),
        };
        let (filtered, log_evidence_increment) = update(model, &predicted, measurement, time)?;
        steps.push(Step { predicted, filtered, log_evidence_increment });
    }
    Ok(Filtered { steps })
}

/// `A m`, `A P Aᵀ + Q`.
fn predict(model: &LinearGaussian, belief: &Belief) -> Belief {
    let a = model.transition_matrix();
    Belief {
        mean: a * &belief.mean,
        covariance: symmetric(a * &belief.covariance * a.transpose() + model.transition_covariance()),
    }
}

fn update(
    model: &LinearGaussian,
    predicted: &Belief,
    measurement: &[Option<f64>],
    time: usize,
) -> Result<(Belief, f64), ModelError> {
    let there: Vec<usize> = (0..measurement.len()).filter(|&i| measurement[i].is_some()).collect();
    if there.is_empty() {
        return Ok((predicted.clone(), 0.0));
    }
    let (c, r) = (model.measurement_matrix(), model.measurement_covariance());
    let measured: Col<f64> = measurement.iter().copied().flatten().collect();
    if there.len() == measurement.len() {
        return correct(predicted, c, r, &measured, time);
    }
    let of_c = Mat::from_fn(there.len(), c.ncols(), |i, j| c[(there[i], j)]);
    let of_r = Mat::from_fn(there.len(), there.len(), |i, j| r[(there[i], there[j])]);
    correct(predicted, of_c.as_ref(), of_r.as_ref(), &measured, time)
}

/// Corrects a belief by what was measured of `C x + w`, `w ~ N(0, R)`; the corrected one and the log-density of the measurement.
fn correct(
    predicted: &Belief,
    c: MatRef<'_, f64>,
    r: MatRef<'_, f64>,
    measured: &Col<f64>,
    time: usize,
) -> Result<(Belief, f64), ModelError> {
    let Correction { gain, covariance, innovation } = correction(predicted.covariance.as_ref(), c, r)
        .map_err(|fault| ModelError::Numerical {
            computation: "correcting a belief",
            time,
            reason: fault.to_string(),
        })?;
    let surprise = measured - c * &predicted.mean;
    let log_evidence_increment = innovation.log_density_of(|i| surprise[i]);
    Ok((Belief { mean: &predicted.mean + gain * &surprise, covariance }, log_evidence_increment))
}

/// How a linear measurement corrects a Gaussian belief: the part that does not depend on its value.
#[derive(Debug, Clone)]
pub struct Correction {
    /// `G = P Cᵀ S⁻¹`, `N×M`.
    pub gain: Mat<f64>,
    /// The corrected covariance `(I − G C) P (I − G C)ᵀ + G R Gᵀ`, `N×N`.
    pub covariance: Mat<f64>,
    /// `N(0, S)` with `S = C P Cᵀ + R`: the distribution of `y − C m`.
    pub innovation: Gaussian,
}

/// The correction of a belief of covariance `prior` (`P`, `N×N`) by `y = C x + w` with `w ~ N(0, R)`.
///
/// Its covariance is also that of the information form, `(P⁻¹ + Cᵀ R⁻¹ C)⁻¹`.
///
/// # Errors
/// [`ModelError::Shape`] or [`ModelError::NotFiniteEntry`] for a matrix that does not fit; [`ModelError::Covariance`] if the
/// innovation covariance is not positive definite.
pub fn correction(
    prior: MatRef<'_, f64>,
    measurement_matrix: MatRef<'_, f64>,
    measurement_covariance: MatRef<'_, f64>,
) -> Result<Correction, ModelError> {
    let (c, r) = (measurement_matrix, measurement_covariance);
    check_matrix("a belief's covariance P", prior, c.ncols(), c.ncols())?;
    check_matrix("the measurement-noise covariance R", r, c.nrows(), c.nrows())?;
    let cross = c * prior;
    let innovation = symmetric(&cross * c.transpose() + r);
    let innovation = Gaussian::new("the innovation covariance", vec![0.0; c.nrows()], innovation)?;
    let lower = innovation.lower();
    let mut solved = cross;
    lower.solve_lower_triangular_in_place(solved.as_mut());
    lower.transpose().solve_upper_triangular_in_place(solved.as_mut());
    let gain = solved.transpose().to_owned();
    let kept = Mat::<f64>::identity(c.ncols(), c.ncols()) - &gain * c;
    let covariance = symmetric(&kept * prior * kept.transpose() + &gain * r * gain.transpose());
    Ok(Correction { gain, covariance, innovation })
}

/// The symmetric part, which removes what rounding made of a symmetric product.
pub(crate) fn symmetric(matrix: Mat<f64>) -> Mat<f64> {
    let matrix: MatRef<'_, f64> = matrix.as_ref();
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| 0.5 * (matrix[(i, j)] + matrix[(j, i)]))
}
