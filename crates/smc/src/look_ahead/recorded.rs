//! A recorded sequence, step by step.

use motes_models::StepRecord;

/// A step of a recorded sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedStep {
    /// The step itself.
    pub step: StepRecord,
    /// What was measured at its end, `M` entries.
    pub measurement: Vec<Option<f64>>,
}
