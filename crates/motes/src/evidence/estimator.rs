//! The log-evidence of one model and some data, as often as it is asked for.

use std::ops::ControlFlow;

use motes_models::Seed;

use super::exact::is_exact;
use super::options::EvidenceOptions;
use super::pilot::{Candidate, Pilot, choose};
use super::second_opinion::{SecondOpinion, second_opinion};
use super::sequence::{Proceed, RecordedSequence, sequences};
use crate::data::Data;
use crate::error::MotesError;
use crate::model::Model;
use crate::options::ProposalName;

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
/// assert_eq!(estimator.proposals(), [&ProposalName::LookAhead]);
/// let seed = Seed::from_u64(1);
/// let [one, other] = [0, 1].map(|run| estimator.log_evidence(&seed.nth(run)));
/// assert!((one? - other?).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct EvidenceEstimator<'m> {
    model: &'m Model,
    sequences: Vec<RecordedSequence>,
    /// The proposal of each series; none where answers are exact.
    candidates: Vec<Candidate>,
    options: EvidenceOptions,
    is_exact: bool,
    pilots: Vec<Pilot>,
}

impl<'m> EvidenceEstimator<'m> {
    /// Prepares it. Where options name no proposal, the exact one is taken if the model has exact answers, else what pilots choose for each series; their random numbers come from the seed of the options, by a
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
        let named = match &options.proposal {
            None if is_exact(model, data) => Some(ProposalName::Exact),
            named => named.clone(),
        };
        let (candidates, pilots) = match &named {
            Some(proposal) => {
                let of_series = |sequence| Candidate::of(proposal.clone(), model, sequence);
                (sequences.iter().map(of_series).collect::<Result<_, MotesError>>()?, vec![])
            }
            None => {
                let seed = Seed::from_u64(options.seed).child("evidence").child("pilot");
                choose(model, &sequences, options, &seed, proceed)?
            }
        };
        let is_exact = named == Some(ProposalName::Exact);
        Ok(EvidenceEstimator { model, sequences, candidates, options: options.clone(), is_exact, pilots })
    }

    /// What the particles of each series are drawn from.
    pub fn proposals(&self) -> Vec<&ProposalName> {
        self.candidates.iter().map(|candidate| &candidate.proposal).collect()
    }

    /// Whether every answer is the same, and exact.
    pub fn is_exact(&self) -> bool {
        self.is_exact
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
        let EvidenceEstimator { model, sequences, candidates, options, .. } = self;
        let of_series = |(number, (sequence, candidate)): (usize, (&RecordedSequence, &Candidate))| {
            let seed = seed.nth(number as u64);
            candidate.log_evidence((*model, sequence), (options, options.particles), seed, proceed)
        };
        sequences.iter().zip(candidates).enumerate().map(of_series).collect()
    }

    /// What another proposal finds of a series where it finds more than these runs have.
    ///
    /// # Errors
    /// [`MotesError::Interrupted`].
    pub(super) fn second_opinion(
        &self,
        series: usize,
        logs: &[f64],
        seed: &Seed,
        proceed: Proceed<'_>,
    ) -> Result<Option<SecondOpinion>, MotesError> {
        let (own, of_series) = (&self.candidates[series].proposal, (self.model, &self.sequences[series]));
        second_opinion(own, logs, of_series, &self.options, seed, proceed)
    }

    /// Why no particle explains a series, if that is so.
    pub(super) fn failure(&self, series: usize, seed: Seed) -> Option<String> {
        let proposal = self.candidates[series].proposal.clone();
        let filter = self.options.of_filter(proposal, self.options.particles);
        self.sequences[series].failure(self.model, &filter, seed)
    }
}
