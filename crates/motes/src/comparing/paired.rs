//! Proposals beside one of them, sequence by sequence: what differs between sequences is left out.

use super::card::{Figure, Steps};
use crate::contender::Contender;
use crate::options::ProposalName;

/// A proposal's figures less those of another on the same sequences.
#[derive(Debug, Clone, PartialEq)]
pub struct Paired {
    /// What is held against the other.
    pub contender: Contender,
    /// The mean difference of `K_eff/K`.
    pub ess_fraction: Option<Figure>,
    /// The mean difference of the log-evidence of a sequence, over those that neither collapsed on.
    pub log_evidence: Option<Figure>,
}

impl Paired {
    /// Of filters with `particles` particles, one for each sequence.
    pub(super) fn of(contender: Contender, runs: &[Steps], others: &[Steps], particles: usize) -> Self {
        let pairs = || runs.iter().zip(others);
        let size = |run: &Steps| run.mean_size().map(|size| size / particles as f64);
        Paired {
            contender,
            ess_fraction: Figure::of(pairs().filter_map(|(own, other)| Some(size(own)? - size(other)?))),
            log_evidence: Figure::of(
                pairs().filter_map(|(own, other)| Some(own.log_evidence_gap? - other.log_evidence_gap?)),
            ),
        }
    }
}

/// The one that the others are held against: linearised where it is there, else the first; none where there is one alone.
pub(super) fn baseline(contenders: &[Contender]) -> Option<usize> {
    let is_linearised = |contender: &Contender| *contender.proposal() == ProposalName::Linearised;
    let linearised = contenders.iter().position(is_linearised);
    (contenders.len() > 1).then(|| linearised.unwrap_or(0))
}
