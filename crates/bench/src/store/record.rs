//! What is stored of a unit.

use serde::{Deserialize, Serialize};

use crate::config::Point;
use crate::metric::Metric;
use crate::series::Series;
use crate::unit::UnitConfig;

/// What is stored of a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its place in the figure.
    pub point: Point,
    /// What determined it.
    pub config: UnitConfig,
    /// The source revision that computed it; more of them, `… then …`, if its training was checkpointed and resumed by another.
    pub revision: String,
    /// The kind of processor that computed it, likewise, where it was recorded: architecture and vector extensions, which results depend on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub processor: Option<String>,
    /// Its metrics, or why it failed.
    pub outcome: Outcome,
    /// What depends on the clock.
    pub timings: Vec<Metric>,
    /// Estimates over time, where the experiment shows them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub series: Option<Series>,
}

impl Record {
    /// Whether it is what is wanted at a place.
    pub(crate) fn is_of(&self, point: &Point, config: &UnitConfig) -> bool {
        self.point == *point && self.config == *config
    }
}

/// How a unit ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// With these metrics.
    Metrics(Vec<Metric>),
    /// It failed, for this reason.
    Failed(String),
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::config::Method;
    use crate::unit::tests::unit;

    /// A unit that is finished.
    pub(in crate::store) fn record() -> Record {
        Record {
            point: Point { panel: "N10".into(), x: 20, method: Method::Bootstrap, repetition: 0 },
            config: unit(10, 12, 20),
            revision: "0123".into(),
            processor: Some("x86_64 avx2 fma".into()),
            outcome: Outcome::Metrics(vec![Metric::new("ess", 0.1 + 0.2)]),
            timings: vec![],
            series: None,
        }
    }
}
