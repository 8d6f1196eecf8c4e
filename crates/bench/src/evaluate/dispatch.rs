//! From a method's settings to its proposal, whose type a visitor is told.

use motes_proposals::{
    Backend, Family, Fcnn, Frames, Gnn, Learnable, Psi, Rnn, Standardised, StandardisedConfig,
};
use motes_smc::{Bootstrap, Linearised, MinDegeneracy, Proposal};

use crate::config::Training;
use crate::learned_once::LearnedOnce;
use crate::method_config::{FrameSettings, LearnedUnit, MethodConfig};
use crate::problem::Model;
use crate::unit_error::{UnitError, failed};

/// What a unit does with the proposal of its method.
pub(super) trait Visitor {
    type Output;

    /// A proposal that is ready for use.
    fn designed(self, proposal: impl Proposal<Model> + Clone) -> Result<Self::Output, UnitError>;

    /// A family that is to be trained first, with its settings.
    fn learned<F: Family + Learnable + Proposal<Model> + Clone>(
        self,
        family: &F::Config,
        training: &Training,
        steps: usize,
        backend: Backend,
    ) -> Result<Self::Output, UnitError>;

    /// A proposal that is learned once for the unit's system.
    fn once(self, method: &LearnedOnce) -> Result<Self::Output, UnitError>;

    /// The potentials of a smoother, or of networks that are learned for so many steps.
    fn look_ahead(self, learned: Option<usize>) -> Result<Self::Output, UnitError>;

    /// The units that networks work in.
    fn frames(&self, settings: &FrameSettings) -> Result<Frames, UnitError>;

    /// The filter that others are held against, with the measurements of as many later times.
    fn reference(self, lag: usize) -> Result<Self::Output, UnitError>;
}

/// Hands the method's proposal to `visitor`.
pub(super) fn visit<V: Visitor>(
    method: &MethodConfig,
    model: &Model,
    visitor: V,
) -> Result<V::Output, UnitError> {
    match method {
        MethodConfig::MinDegeneracy => visitor.designed(MinDegeneracy::new(model).map_err(failed)?),
        MethodConfig::Bootstrap => visitor.designed(Bootstrap),
        MethodConfig::Linearised => visitor.designed(Linearised::new(model).map_err(failed)?),
        MethodConfig::Once(method) => visitor.once(method),
        MethodConfig::Fcnn(unit) => learned::<Fcnn, V>(unit, visitor),
        MethodConfig::Rnn(unit) => learned::<Rnn, V>(unit, visitor),
        MethodConfig::Gnn(unit) | MethodConfig::GnnShortSteps(unit) => learned::<Gnn, V>(unit, visitor),
        MethodConfig::Psi(unit) => learned::<Psi, V>(unit, visitor),
        MethodConfig::LookAhead => visitor.look_ahead(None),
        MethodConfig::LookAheadLearned { steps } => visitor.look_ahead(Some(*steps)),
        MethodConfig::ReferenceFilter => visitor.reference(0),
        MethodConfig::ReferenceSmoother { lag } => visitor.reference(*lag),
    }
}

fn learned<F: Family<Config: Clone> + Learnable + Proposal<Model> + Clone, V: Visitor>(
    unit: &LearnedUnit<F::Config>,
    visitor: V,
) -> Result<V::Output, UnitError> {
    let LearnedUnit { proposal, training, steps, backend, frames } = unit;
    match frames {
        None => visitor.learned::<F>(proposal, training, *steps, *backend),
        Some(settings) => {
            let frames = visitor.frames(settings)?;
            let config = StandardisedConfig { family: proposal.clone(), frames };
            visitor.learned::<Standardised<F>>(&config, training, *steps, *backend)
        }
    }
}
