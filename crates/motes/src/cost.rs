//! What proposals cost: counted work, the same on any machine.

use motes_inference::EstimatorCost;

use crate::filter_source::FilterSource;
use crate::model::Model;
use crate::options::ProposalName;

/// The work of a smoother for a time step, for each coordinate of the state: from 154 to 2,556 in seven models, by how many iterations it takes.
const SMOOTHER: f64 = 500.0;

/// A network for each particle.
const PER_PARTICLE: f64 = 15.0;

/// What a proposal costs at a time step, in particles of a bootstrap filter: about. Medians of counted instructions in seven models (`experiments/look-ahead/costs.py`); of potentials in three
/// whose folders hand them out, of one coordinate each; a network for each particle is counted on the growth model alone. Not counted are the units of potentials over a prior, which take 32
/// sequences of the model once for each set of parameters.
pub(crate) fn cost(proposal: &ProposalName, model: &Model) -> EstimatorCost {
    let smoother = SMOOTHER * model.states().len() as f64;
    let (fixed, per_particle) = match proposal {
        ProposalName::Exact => (0.0, 0.0),
        ProposalName::Bootstrap => (0.0, 1.0),
        ProposalName::Linearised | ProposalName::Optimal => (0.0, 2.5),
        ProposalName::LookAhead => (smoother, 2.2),
        ProposalName::Learned(learned) if learned.has_potentials() => (250.0, 4.3),
        ProposalName::Learned(_) => (0.0, PER_PARTICLE),
    };
    EstimatorCost { per_particle, fixed, is_exact: *proposal == ProposalName::Exact }
}

/// The same of a filter that takes in one measurement after another.
pub(crate) fn on_line_cost(proposal: &ProposalName, model: &Model) -> EstimatorCost {
    let ProposalName::Learned(learned) = proposal else { return cost(proposal, model) };
    let (fixed, per_particle) = match (learned.filters(), proposal.of_filter()) {
        (FilterSource::Designed(_), Ok(designed)) => return cost(&designed, model),
        (FilterSource::Potential, _) => (150.0, 3.2),
        _ => (0.0, PER_PARTICLE),
    };
    EstimatorCost { per_particle, fixed, is_exact: false }
}
