//! Filters of one model, and what each of them said.

use std::ops::ControlFlow;

use motes::smc::{EvidenceWarning, Verdict, WeightReport, WeightWarning};
use motes::{FilterOptions, Model, MotesError, Running};
use serde::{Deserialize, Serialize};

/// What one filter said, and how far it was off.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) half: String,
    pub(super) model: String,
    pub(super) proposal: String,
    pub(super) particles: usize,
    pub(super) run: usize,
    /// The log-evidence less the exact one (nats); −∞ where the filter collapsed, which is an error and said.
    pub(super) error: f64,
    pub(super) standard_error: Option<f64>,
    /// The largest ratio of a standard deviation of the last state and the exact one, either way round; none where that is not known.
    pub(super) deviation_ratio: Option<f64>,
    /// What was warned of, joined by `+`.
    pub(super) warnings: String,
    /// The hash of what determines it.
    pub(super) key: String,
}

/// The figures of one filter over all measurements.
pub(super) struct Figures {
    pub(super) log_evidence: f64,
    pub(super) standard_error: Option<f64>,
    pub(super) deviations: Vec<f64>,
    pub(super) warnings: String,
}

/// Runs one filter; a collapse is a log-evidence of −∞.
pub(super) fn run(
    model: &Model,
    options: &FilterOptions,
    measurements: &[Vec<Option<f64>>],
    proceed: &dyn Fn() -> ControlFlow<()>,
) -> Result<Figures, MotesError> {
    let mut running = Running::new(model, options, 0)?;
    let (mut report, mut deviations) = (WeightReport::default(), vec![]);
    for (time, measurement) in measurements.iter().enumerate() {
        let stepped = match time + 1 < measurements.len() {
            true => running.advance(measurement).map(|()| None),
            false => running.step(measurement).map(Some),
        };
        match stepped {
            Ok(estimate) => {
                let last = estimate.into_iter().flat_map(|estimate| estimate.state);
                deviations.extend(last.map(|coordinate| coordinate.sd));
            }
            Err(MotesError::Filter { .. }) => {
                return Ok(Figures {
                    log_evidence: f64::NEG_INFINITY,
                    standard_error: None,
                    deviations: vec![],
                    warnings: "collapse".into(),
                });
            }
            Err(error) => return Err(error),
        }
        running.diagnosis().iter().for_each(|diagnosis| report.add(diagnosis));
        if proceed().is_break() {
            return Err(MotesError::Interrupted);
        }
    }
    let of_weights = report.warnings().map(|warning| match warning {
        WeightWarning::FewParticles { .. } => "few",
        WeightWarning::HeavyTail { .. } => "tail",
    });
    let of_evidence = running.evidence_warnings().into_iter().map(|warning| match warning {
        EvidenceWarning::Surprise { .. } => "surprise",
        EvidenceWarning::LargeError { .. } => "error",
        EvidenceWarning::FewAncestors { .. } => "ancestors",
    });
    let of_opinion = matches!(running.verdict(), Some(Verdict::Warns { .. })).then_some("opinion");
    let mut warnings: Vec<&str> = of_weights.chain(of_evidence).chain(of_opinion).collect();
    warnings.dedup();
    Ok(Figures {
        log_evidence: running.log_evidence(),
        standard_error: running.standard_error(),
        deviations,
        warnings: warnings.join("+"),
    })
}
