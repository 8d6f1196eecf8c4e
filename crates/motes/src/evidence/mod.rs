//! The log-evidence of data and nothing else.

mod estimate;
mod estimator;
mod exact;
mod judgement;
mod log_evidence;
mod many;
mod options;
mod pilot;
mod runs;
mod second_opinion;
mod sequence;
mod worth;

pub use estimate::{Evidence, MissedMass, evidence};
pub use estimator::EvidenceEstimator;
pub(crate) use exact::is_exact;
pub(crate) use judgement::{JudgedSequence, judge};
pub use log_evidence::{LogEvidence, log_evidence};
pub use many::log_evidence_at;
pub use options::EvidenceOptions;
pub(crate) use options::share_for_evidence;
pub use pilot::Pilot;
pub(crate) use pilot::candidates;
pub(crate) use second_opinion::missed;
pub(crate) use sequence::{RecordedSequence, STEPS_AT_ONCE, sequences};
pub(crate) use worth::LOOK_AHEAD;
pub use worth::{EvidenceWorth, LearnedWorth};
