//! The log-evidence of one model and some data, as often as it is asked for.

use std::ops::ControlFlow;

use motes_models::Seed;

use super::exact::is_exact;
use super::options::EvidenceOptions;
use super::pilot::{Candidate, Pilot, choose};
use super::sequence::{Proceed, RecordedSequence, sequences};
use crate::data::Data;
use crate::error::MotesError;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};

/// An unbiased estimator of the evidence of data, prepared once for a model, a proposal and a number of particles: smoothers and pilots have run when it is there.
///
/// ```
/// use motes::models::Seed;
/// use motes::{Data, EvidenceEstimator, EvidenceOptions, Model, ProposalName};
///
/// let text = r#"
///     [initial]
///     x = "normal(0, 1)"
///     [transition]
///     x = "normal(x, 0.1)"
///     [measurement]
///     y = "poisson(exp(x))"
/// "#;
/// let model = Model::parse(text, "counts", &[])?;
/// let data = Data::read("y\n1\n0\n2\n9\n".as_bytes(), "y.csv", &model)?;
/// let options = EvidenceOptions { particles: 32, ..EvidenceOptions::default() };
/// let estimator = EvidenceEstimator::new(&model, &data, &options)?;
/// assert_eq!(estimator.proposal(), &ProposalName::LookAhead);
/// let seed = Seed::from_u64(1);
/// let [one, other] = [0, 1].map(|run| estimator.log_evidence(&seed.nth(run)));
/// assert!((one? - other?).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct EvidenceEstimator<'m> {
    model: &'m Model,
    sequences: Vec<RecordedSequence>,
    candidate: Candidate,
    filter: FilterOptions,
    pilots: Vec<Pilot>,
}

impl<'m> EvidenceEstimator<'m> {
    /// Prepares it. Where options name no proposal, the exact one is taken if the model has exact answers, else what pilots choose; their random numbers come from the seed of the options, by a
    /// label of their own. [`EvidenceOptions::runs`] plays no part.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if the model has no such proposal, [`MotesError::Setting`] if an option is out of range; as a filter, where pilots fail.
    pub fn new(model: &'m Model, data: &Data, options: &EvidenceOptions) -> Result<Self, MotesError> {
        EvidenceEstimator::while_proceeding(model, data, options, &|| ControlFlow::Continue(()))
    }

    /// [`EvidenceEstimator::new`], which asks now and then whether to go on.
    pub(crate) fn while_proceeding(
        model: &'m Model,
        data: &Data,
        options: &EvidenceOptions,
        proceed: Proceed<'_>,
    ) -> Result<Self, MotesError> {
        let sequences = sequences(data);
        let (candidate, pilots) = match &options.proposal {
            Some(proposal) => (Candidate::of(proposal.clone(), model, &sequences)?, vec![]),
            None if is_exact(model, data) => {
                (Candidate { proposal: ProposalName::Exact, ahead: vec![] }, vec![])
            }
            None => {
                let seed = Seed::from_u64(options.seed).child("evidence").child("pilot");
                choose(model, &sequences, options, &seed, proceed)?
            }
        };
        let filter = options.of_filter(candidate.proposal.clone(), options.particles);
        Ok(EvidenceEstimator { model, sequences, candidate, filter, pilots })
    }

    /// What particles are drawn from.
    pub fn proposal(&self) -> &ProposalName {
        &self.candidate.proposal
    }

    /// Whether every answer is the same, and exact.
    pub fn is_exact(&self) -> bool {
        self.candidate.proposal == ProposalName::Exact
    }

    /// What pilots said, where they chose.
    pub fn pilots(&self) -> &[Pilot] {
        &self.pilots
    }

    /// The number of series.
    pub fn series(&self) -> usize {
        self.sequences.len()
    }

    /// An estimate of `log p(y)` of all series; its exponential is unbiased. −∞ where no particle explains a measurement. Other seeds give independent estimates.
    ///
    /// # Errors
    /// As a filter.
    pub fn log_evidence(&self, seed: &Seed) -> Result<f64, MotesError> {
        Ok(self.log_evidence_per_series(seed)?.into_iter().sum())
    }

    /// The same of each series, in order of appearance.
    ///
    /// # Errors
    /// As [`EvidenceEstimator::log_evidence`].
    pub fn log_evidence_per_series(&self, seed: &Seed) -> Result<Vec<f64>, MotesError> {
        self.per_series_while(seed, &|| ControlFlow::Continue(()))
    }

    /// [`EvidenceEstimator::log_evidence_per_series`], which asks now and then whether to go on.
    pub(crate) fn per_series_while(&self, seed: &Seed, proceed: Proceed<'_>) -> Result<Vec<f64>, MotesError> {
        let EvidenceEstimator { model, sequences, candidate, filter, .. } = self;
        let of_series = |(number, sequence): (usize, &RecordedSequence)| {
            let ahead = candidate.ahead.get(number).and_then(Option::as_ref);
            sequence.log_evidence(model, filter, seed.nth(number as u64), ahead, proceed)
        };
        sequences.iter().enumerate().map(of_series).collect()
    }
}
