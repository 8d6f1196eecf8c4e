//! What a maximum is sought with.

use serde::{Deserialize, Serialize};

use crate::settings::EstimatorChoice;

/// What a maximum is sought with; [`MaximumSettings::default`] is what `motes fit` takes where nothing else is said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaximumSettings {
    /// The number of searches, each from draws of its own from the prior.
    pub starts: usize,
    /// The probability that intervals are to have.
    pub level: f64,
    /// The coordinates whose profiles are sought, in order; if none are named, all.
    pub profiled: Option<Vec<usize>>,
    /// An estimator of the likelihood in the place of that which is found.
    pub estimator: Option<EstimatorChoice>,
    /// Iterated filtering in the place of searches on quadratics, where the likelihood has filters for it.
    pub iterated: Option<IteratedSettings>,
}

/// What iterated filtering is done with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct IteratedSettings {
    /// `K`, the number of particles.
    pub particles: usize,
    /// The number of passes through the data.
    pub passes: usize,
}

impl Default for IteratedSettings {
    fn default() -> Self {
        IteratedSettings { particles: 2000, passes: 100 }
    }
}

impl Default for MaximumSettings {
    fn default() -> Self {
        MaximumSettings { starts: 4, level: 0.9, profiled: None, estimator: None, iterated: None }
    }
}
