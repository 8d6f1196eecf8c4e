//! What proposals cost: counted work, the same on any machine.

use motes_inference::EstimatorCost;

use motes_models::Step;

use crate::filter_source::FilterSource;
use crate::model::{Kind, Model};
use crate::options::ProposalName;

/// The work of a smoother for a time step, for each coordinate of the state: from 100 to 300 in six models, and 2,733 in the growth model, where it does not converge; 210 in the middle.
const SMOOTHER: f64 = 210.0;

/// A network for each particle.
const PER_PARTICLE: f64 = 15.0;

/// What a proposal costs at a time step, in particles of a bootstrap filter: about. Medians of counted instructions in seven models (`experiments/look-ahead/costs.py`); of potentials in three
/// whose folders hand them out, of one coordinate each; a network for each particle is counted on the growth model alone. Of `linearised` it is the median of the times in six committed benchmarks
/// (`experiments/reference/learned-*`, from 2.0 to 5.2): valgrind counts narrower vectors, and finds 3.4. Not counted are the units of potentials over a prior, which take 32 sequences of the model
/// once for each set of parameters.
///
/// Where states have no density, the noise of a whole step is drawn at once, of all its sub-steps: a particle then costs about as many particles of a bootstrap filter as there are draws (20 of 20
/// in the cholera model of `experiments/models`).
pub(crate) fn cost(proposal: &ProposalName, model: &Model, step: &Step<'_>) -> EstimatorCost {
    let smoother = SMOOTHER * model.states().len() as f64;
    let draws = match model.kind() {
        Kind::Learnable(model) if model.density().is_none() => {
            model.noise_space().map_or(0, |noise| noise.draws(step).len()) as f64
        }
        _ => 0.0,
    };
    let (fixed, per_particle) = match proposal {
        ProposalName::Exact => (0.0, 0.0),
        ProposalName::Bootstrap => (0.0, 1.0),
        ProposalName::Linearised | ProposalName::Optimal => (0.0, draws.max(2.6)),
        ProposalName::LookAhead => (smoother, draws.max(2.1)),
        ProposalName::Learned(learned) if learned.has_potentials() => (206.0, 3.7),
        ProposalName::Learned(_) => (0.0, PER_PARTICLE),
    };
    EstimatorCost { per_particle, fixed, is_exact: *proposal == ProposalName::Exact }
}

/// The same of a filter that takes in one measurement after another.
pub(crate) fn on_line_cost(proposal: &ProposalName, model: &Model, step: &Step<'_>) -> EstimatorCost {
    let ProposalName::Learned(learned) = proposal else { return cost(proposal, model, step) };
    let (fixed, per_particle) = match (learned.filters(), proposal.of_filter()) {
        (FilterSource::Designed(_), Ok(designed)) => return cost(&designed, model, step),
        (FilterSource::Potential, _) => (126.0, 2.6),
        _ => (0.0, PER_PARTICLE),
    };
    EstimatorCost { per_particle, fixed, is_exact: false }
}
