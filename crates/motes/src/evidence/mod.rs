//! The log-evidence of data and nothing else.

mod estimate;
mod estimator;
mod exact;
mod judged;
mod log_evidence;
mod many;
mod options;
mod pilot;
mod sequence;
mod worth;

pub use estimate::{Evidence, evidence};
pub use estimator::EvidenceEstimator;
pub(crate) use exact::is_exact;
pub(crate) use judged::{Contender, judged};
pub use log_evidence::{LogEvidence, log_evidence};
pub use many::log_evidence_at;
pub use options::EvidenceOptions;
pub use pilot::Pilot;
pub(crate) use pilot::{ON_LINE, candidates, cost, counted, fixed_cost};
pub(crate) use sequence::{Sequence, sequences};
pub use worth::EvidenceWorth;
pub(crate) use worth::{AHEAD, LOOK_AHEAD, NETWORK, NOW};
