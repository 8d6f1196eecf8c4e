//! How a linear measurement corrects a Gaussian belief.

use faer::{Mat, MatRef};

use super::belief::symmetric;
use crate::error::check_matrix;
use crate::{Gaussian, ModelError};

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
