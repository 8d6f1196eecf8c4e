//! A step of `[time]` that is longer than every gap between rows.

use crate::data::Data;
use crate::model::Model;
use crate::warning::Warning;

/// What is to be said where no gap is cut into sub-steps although the model gives their length: that is probably in another unit.
pub(crate) fn of_step(model: &Model, data: &Data) -> Option<Warning> {
    let step = model.frame()?.time_rule()?.step?;
    let steps = data.rows.iter().flat_map(|row| &row.steps).map(|step| step.step());
    let gaps = steps.filter(|step| step.index > 0 && step.sub_steps > 0).map(|step| step.length);
    let longest = gaps.reduce(f64::max).filter(|longest| *longest < step)?;
    let text = format!(
        "the step of [time] is {step}, and the longest gap between rows {longest}: each gap is one step; is it in the unit of the times?"
    );
    Some(Warning { series: None, text })
}
