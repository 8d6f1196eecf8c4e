//! Inputs of a measurement that nobody knows where it is missing: filters do without them.

use motes_models::{Step, StepRecord};
use motes_smc::Predictive;

use crate::model::Model;

/// A step with 0 for each input at its end that is not known, which nothing that is measured depends on; none where all are known.
pub(crate) fn without_unknown(step: &Step<'_>) -> Option<StepRecord> {
    let end = step.inputs.len() - step.inputs.len() / (step.sub_steps + 1);
    step.inputs[end..].iter().any(|value| value.is_nan()).then(|| {
        let mut inputs = step.inputs.to_vec();
        inputs[end..].iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = 0.0);
        StepRecord::of(&Step { inputs: &inputs, ..*step })
    })
}

/// The same of steps that somebody owns.
pub(crate) fn all_known(steps: &[StepRecord]) -> Vec<StepRecord> {
    steps.iter().map(|step| without_unknown(&step.step()).unwrap_or_else(|| step.clone())).collect()
}

/// Empties the predictions of measurements that need an input which is not known at the end of a step, or a step before it where there `has_passed` no time.
pub(crate) fn empty_unknown(model: &Model, step: &Step<'_>, has_passed: bool, predictive: &mut [Predictive]) {
    let Some(frame) = model.frame() else { return };
    let inputs = step.end(frame.input_dim()).inputs;
    let unknown: Vec<usize> = (0..inputs.len()).filter(|input| inputs[*input].is_nan()).collect();
    for (entry, prediction) in predictive.iter_mut().enumerate() {
        let lacks_step = !has_passed && frame.needs_step(entry);
        if lacks_step || unknown.iter().any(|input| frame.needs_input(entry, *input)) {
            prediction.mean = f64::NAN;
            prediction.sd = f64::NAN;
            prediction.quantiles.fill(f64::NAN);
            prediction.pit = None;
        }
    }
}
