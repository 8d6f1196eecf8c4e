//! What evidence and means are held against: the exact filter where there is one, else a filter with many particles.

use motes_formulas::FileModel;
use motes_models::{PartialMeasurements, kalman};

use super::sequence::Sequence;
use crate::engine::Running;
use crate::error::MotesError;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};

/// The share of a reference filter's particles that is drawn from the transition.
const DEFENSIVE: f64 = 0.1;

/// The answers for one sequence.
pub(super) struct Reference {
    pub(super) name: String,
    /// The mean of the state at each time.
    pub(super) means: Vec<Vec<f64>>,
    /// `log p(y_t | y_{0:t−1})` at each time.
    pub(super) increments: Vec<f64>,
}

impl Reference {
    pub(super) fn log_evidence(&self) -> f64 {
        self.increments.iter().sum()
    }
}

/// The reference for the sequence of that number.
pub(super) fn reference(
    model: &Model,
    sequence: &Sequence,
    options: &FilterOptions,
    particles: usize,
    number: usize,
) -> Result<Reference, MotesError> {
    if let FileModel::LinearGaussian(linear) = model.model() {
        let measurements =
            PartialMeasurements::new(model.measurements().len(), sequence.measurements.concat())?;
        let exact = kalman::filter_partial(linear, &measurements)?;
        return Ok(Reference {
            name: "the Kalman filter, which is exact".into(),
            means: exact.steps.iter().map(|step| step.filtered.mean.iter().copied().collect()).collect(),
            increments: exact.steps.iter().map(|step| step.log_evidence_increment).collect(),
        });
    }
    // A filter that misses mass has too little evidence: of two the one with more is nearer to the truth.
    let filter = FilterOptions {
        check: false,
        particles,
        defensive: Some(DEFENSIVE),
        seed: options.seed.wrapping_add(1),
        ..options.clone()
    };
    let of_bootstrap = by_particles(model, sequence, &filter, number, ProposalName::Bootstrap);
    let of_linearised = by_particles(model, sequence, &filter, number, ProposalName::Linearised);
    let name = format!(
        "bootstrap or linearised with {particles} particles, whichever has more evidence ({DEFENSIVE} of the latter's are from the transition)"
    );
    let (means, increments) = match (of_bootstrap, of_linearised) {
        (Ok(a), Ok(b)) if a.1.iter().sum::<f64>() > b.1.iter().sum::<f64>() => a,
        (_, Ok(b)) => b,
        (Ok(a), Err(_)) => a,
        (Err(error), Err(_)) => return Err(error),
    };
    Ok(Reference { name, means, increments })
}

/// Means, and increments of the log-evidence.
type Answers = (Vec<Vec<f64>>, Vec<f64>);

/// Those of a filter with many particles.
fn by_particles(
    model: &Model,
    sequence: &Sequence,
    options: &FilterOptions,
    number: usize,
    proposal: ProposalName,
) -> Result<Answers, MotesError> {
    let filter = FilterOptions { proposal, ..options.clone() };
    let mut running = Running::new(model, &filter, number)?;
    let (mut means, mut increments) = (Vec::new(), Vec::new());
    for measurement in &sequence.measurements {
        let before = running.log_evidence();
        running.advance(measurement)?;
        increments.push(running.log_evidence() - before);
        means.push(running.means().to_vec());
    }
    Ok((means, increments))
}
