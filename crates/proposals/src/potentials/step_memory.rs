//! What a step is computed in, when its measurement is there.

use motes_networks::Inference;

use super::features::StepFeatures;

/// What a step is computed in.
#[derive(Default, Clone)]
pub(super) struct StepMemory {
    pub(super) of_step: StepFeatures,
    pub(super) features: Vec<f64>,
    pub(super) inference: Inference,
}
