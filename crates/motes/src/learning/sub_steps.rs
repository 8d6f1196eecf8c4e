//! A proposal in noise space draws the noise of all sub-steps to the next row at once, and so is for rows with one number of them.

use motes_formulas::Schedule;

use super::LearnableModel;
use crate::error::MotesError;

/// Refuses rows with different numbers of sub-steps, where what is drawn is noise.
///
/// # Errors
/// [`MotesError::Setting`] with how many sub-steps there are, and what to do.
pub(super) fn check_sub_steps(model: &dyn LearnableModel, schedule: &Schedule) -> Result<(), MotesError> {
    if model.noise_without_density().is_none() {
        return Ok(());
    }
    let later = schedule.steps().iter().map(|step| step.step()).filter(|step| step.index > 0);
    let counts: Vec<usize> = later.map(|step| step.sub_steps).collect();
    match (counts.iter().min(), counts.iter().max()) {
        (Some(fewest), Some(most)) if fewest < most => Err(MotesError::Setting(format!(
            "learn: the gaps between rows have from {fewest} to {most} sub-steps, and a learned proposal is for one number of them; \
             take --proposal linearised, or motes evidence, which need no learning, or data with equal gaps"
        ))),
        _ => Ok(()),
    }
}
