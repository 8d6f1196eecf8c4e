//! Parameters at values that a learned proposal has hardly ever seen.

use crate::model::Model;
use crate::options::ProposalName;
use crate::priors::outside;
use crate::warning::Warning;

/// That a parameter has a value which the prior that a proposal was learned over hardly ever has.
pub(crate) fn outside_of_learning(model: &Model, proposal: &ProposalName) -> Option<Warning> {
    let ProposalName::Learned(learned) = proposal else { return None };
    let outside = outside(model, &learned.prior()?.names())?;
    let text = format!(
        "--proposal {} was learned over the prior, and {outside}: the evidence is unbiased, but may vary much more",
        learned.name()
    );
    Some(Warning { series: None, text })
}
